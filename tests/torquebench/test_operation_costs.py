"""Every registered controller is counted, and what its counters are called is what they are priced by."""

from dataclasses import replace

import pytest
from torquebench.cbmc.patterns import find_patterns
from torquebench.controllers import build_controller, discovery
from torquebench.operation_costs import costs_of
from torquebench.scenarios.execution import record
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World
from torquebench.scoring import score


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


LEVELS = {"spinal_cord": 1, "brainstem": 10, "thalamus": 10, "cerebellum": 50}
"""Ticks between the updates of each module: 1 kHz, 100 Hz, 20 Hz."""
LEARNT = {"thalamus": 6 * 5 + 5 + 5 * 2 + 2, "brainstem": 28 * 10 + 10 + 10 * 14 + 14}
"""Parameters of the modules that learn online."""


@pytest.fixture(scope="module")
def lap():
    """Counters of a lap of two seconds, with learning and without."""

    def counted(controller):
        result = record(replace(run_of(controller), trajectory="T6", laps=1, lead_in=0.0), evaluate=score).result
        assert (result.status, result.counts["ticks"]) == ("ok", 2000)
        return result.counts["operations"]

    return {name: counted(name) for name in ("cbmc_v3", "no_learning")}


def test_every_level_counts_at_its_rate_and_once_more_to_start_warm(lap):
    """The report divides by seconds: a level that ran twice as often, or unseen, would be priced wrongly."""
    calls = {module: lap["cbmc_v3"][f"{module}_calls"] for module in LEVELS}
    assert calls == {module: 2000 // ticks + (ticks > 1) for module, ticks in LEVELS.items()}


def test_only_what_learns_online_is_charged_for_learning(lap):
    """The cerebellum was trained before the run, the cord has nothing to learn, and a clamped gain moves nothing."""
    moved = {module: lap["cbmc_v3"][f"{module}_parameter_updates"] for module in LEVELS}
    assert moved["cerebellum"] == moved["spinal_cord"] == 0
    assert all(0 < moved[module] <= size * 2000 // LEVELS[module] for module, size in LEARNT.items())
    without = {name: count for name, count in lap["no_learning"].items() if "learning" in name or "updates" in name}
    assert without and not any(count for name, count in without.items() if "membrane" not in name)


def test_learning_costs_nothing_that_is_called_inference(lap):
    """The networks that both have in common run as often: what learning adds stands in columns of its own."""
    with_it, without = lap["cbmc_v3"], lap["no_learning"]
    for name in ("cerebellum_dense", "cerebellum_effective_macs", "cerebellum_executed_macs", "spinal_cord_dense"):
        assert with_it[name] == without[name] > 0
    priced = costs_of(run_of("cbmc_v3")).by_event
    learning = [cost for name, cost in priced.items() if "learning" in name or name.endswith("parameter_updates")]
    assert len(learning) == 8 and all(cost.arithmetic == 0.0 for cost in learning)


@pytest.mark.parametrize("name", ["./mine.py:Mine", "some.module:Law", "no_such_controller"])
def test_a_plug_in_is_not_counted_and_not_loaded(name):
    """Nobody has written its graph; a report must not run foreign code to find out."""
    assert costs_of(run_of(name)) is None
