"""Every registered controller is counted, and what its counters are called is what they are priced by."""

import pytest
from torquebench.cbmc.patterns import find_patterns
from torquebench.controllers import build_controller, discovery
from torquebench.operation_costs import costs_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World


def run_of(controller, **settings):
    load = LoadSchedule.constant(Payload(mass=1.5))
    return RunSpecification(
        controller=controller, trajectory="T1", schedule=load, robot="rizon4s", plant="pinocchio", tier="actuated",
        settings=settings,
    )  # fmt: skip


@pytest.mark.parametrize("name", discovery.names("controllers"))
def test_every_registered_controller_is_counted(name):
    """A comparison in which one side is not counted is none."""
    costs = costs_of(run_of(name))
    assert costs is not None and costs.how
    assert costs.parameters > 0 and costs.state > 0
    assert any(cost.arithmetic > 0 for cost in costs.by_event.values())


def test_the_events_of_cbmc_are_its_counters_and_they_start_at_nothing():
    """A counter under another name would make the networks free."""
    run = run_of("cbmc_v3")
    controller = build_controller(discovery.load("controllers", "cbmc_v3"), {}, name="cbmc_v3")
    controller.reset(World(run, run.schedule).task())
    assert set(costs_of(run).by_event) <= set(controller.operations())
    assert controller.operations()["cerebellum_dense"] == 0


def test_the_memory_of_cbmc_is_that_of_its_arrays(rizon):
    """Two networks of 300 and 200 neurons, their last layer folded, and two small ones that learn."""
    patterns = find_patterns(rizon.model(rotor_inertia=rizon.rotor_inertia), "")
    weights = 2 * (300 * 7 + 300 + 300 * 400 + 200 + 7 * 200 + 7)
    assert patterns.granule.shape == (2, 300, 7)
    thalamus, brainstem = 6 * 5 + 5 + 5 * 2 + 2, 28 * 10 + 10 + 10 * 14 + 14
    assert costs_of(run_of("cbmc_v3")).parameters == weights + thalamus + brainstem
    assert costs_of(run_of("no_learning")).parameters == weights


def test_settings_change_the_count_where_they_change_the_work():
    few, many = (costs_of(run_of("pes_adaptive", neurons=count)) for count in (100, 1000))
    assert many.parameters - few.parameters == 900 * (14 + 1 + 7)
    assert costs_of(run_of("computed_torque", bandwidth=10.0)) == costs_of(run_of("computed_torque", bandwidth=40.0))


@pytest.mark.parametrize("name", ["./mine.py:Mine", "some.module:Law", "no_such_controller"])
def test_a_plug_in_is_not_counted_and_not_loaded(name):
    """Nobody has written its graph; a report must not run foreign code to find out."""
    assert costs_of(run_of(name)) is None
