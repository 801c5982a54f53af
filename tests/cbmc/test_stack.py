"""The stack: Algorithm 1's schedule, warm and cold starts, and CBMC-V3 as a controller."""

import json
import subprocess
import sys

import numpy as np
import pytest
from torquebench.cbmc.controller import CbmcV3
from torquebench.cbmc.learning import Gradients
from torquebench.cbmc.pathways import Ascending, Descending
from torquebench.cbmc.raster import Raster
from torquebench.cbmc.stack import Schedule, Stack
from torquebench.controllers import InvalidInput, NoKnowledge
from torquebench.scenarios.episode import run_episode
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.workers import Duty, run_in_workers
from torquebench.scenarios.world import World
from torquebench.scoring import score, score_events


class Recorder:
    """Stands in for every module and writes down who was called."""

    def __init__(self):
        self.calls = []
        self.encoded_position = self.encoded_velocity = np.zeros(2)

    def __getattr__(self, name):
        return lambda *_: self.calls.append(name)


class Rule:
    """Writes down that it was asked."""

    def __init__(self, calls):
        self.calls = calls

    def connect(self, *_):
        """Take nothing."""

    def evaluate(self):
        """Say so."""
        self.calls.append("evaluate")


def recorded(ticks, *, warm=False, learning=True):
    """Return the calls of a stack over some ticks."""
    modules = Recorder()
    stack = Stack(
        ascending=Ascending.of(2),
        descending=Descending.of(2, 2),
        cerebellum=modules,
        thalamus=modules,
        brainstem=modules,
        spinal_cord=modules,
        rule=Rule(modules.calls) if learning else None,
        schedule=Schedule(),
    )
    if warm:
        stack.settle()
    for _ in range(ticks):
        stack.tick()
    return modules.calls


def test_the_levels_run_every_1_10_and_50_ticks_in_the_order_of_algorithm_1():
    """Sub-thread 1 every tick; 2 and 3 every tenth; 4 every fiftieth, last of its tick."""
    calls = recorded(50)
    assert calls.count("act") == 50
    assert calls.count("gains") == calls.count("weigh") == calls.count("combine") == calls.count("evaluate") == 5
    assert calls.count("compensate") == 1
    second = ["gains", "weigh", "combine", "evaluate", "learn", "learn"]
    assert calls[-8:] == ["act", *second, "compensate"]


def test_a_cold_start_has_no_gravity_torque_for_fifty_ticks():
    """The cerebellum's first answer comes at T3: what the paper's first error peak shows."""
    assert "compensate" not in recorded(49)


def test_a_warm_start_runs_every_level_once_and_fills_both_membranes():
    """A fair comparison starts with the arm held."""
    assert recorded(0, warm=True) == ["compensate", "gains", "weigh", "settle", "settle"]


def test_without_a_rule_nothing_learns():
    """An ablation must not learn by the back door."""
    assert "learn" not in recorded(100, learning=False)


def specification(controller="cbmc_v3", **changes):
    """Return a short run on the Pinocchio plant."""
    load = changes.pop("load", Payload(mass=2.5, material="sand"))
    settings = {"trajectory": "S1", "laps": 1, "tier": "ideal", "plant": "pinocchio", **changes}
    return RunSpecification(controller=controller, schedule=LoadSchedule.constant(load), robot="rizon4s", **settings)


def run(*arguments, **changes):
    """Run it."""
    (result,) = execute(specification(*arguments, **changes), evaluate=score, traces="none")
    return result


def test_two_runs_with_one_seed_are_bit_identical_and_another_repetition_differs():
    """Spikes are random, but their draws are the run's own."""
    first, again, other = run(), run(), run(repetition=1)
    assert first.metrics == again.metrics
    assert first.metrics != other.metrics


def test_the_first_command_of_a_warm_start_holds_the_arm(rizon):
    """Half the patterns' mixture each: within what an unknown load and the initial weights leave open."""
    spec = specification(load=Payload(mass=1.186))
    world = World(spec, spec.schedule)
    controller = CbmcV3()
    controller.reset(world.task())
    observed = world.episode(controller, None)
    assert observed.plant.q == pytest.approx(world.table["q"][0])
    up = controller.up
    up.q[:] = up.q_desired[:] = world.plant.q
    controller.stack.settle()
    weights, compensation = controller.down.weights, controller.down.compensation
    assert controller.down.torque == pytest.approx(weights @ compensation)
    light = rizon.model().gravity(world.plant.q)
    assert np.abs(compensation[0] - light).max() < 1.5


def test_no_torque_is_compensated_before_the_cerebellum_has_answered_in_a_cold_start():
    """Cold means cold: 50 ms without gravity torque."""
    spec = specification(lead_in=0.0)
    world = World(spec, spec.schedule)
    controller = CbmcV3(start="cold")
    controller.reset(world.task())
    assert not controller.down.gravity_torque.any()
    assert controller.down.stiffness == pytest.approx(200.0)
    assert controller.down.damping == pytest.approx(20.0)


@pytest.mark.parametrize("changes", [{"start": "lukewarm"}, {"sensitivity": 0.0}])
def test_settings_that_cannot_be_are_refused_by_name(changes):
    """One line, at construction."""
    (name,) = changes
    with pytest.raises(InvalidInput, match=name):
        CbmcV3(**changes)


def test_gradients_are_zero_until_the_second_level_has_run():
    """The record starts empty."""
    gradients = Gradients(weights=np.zeros(2), gains=np.zeros(14), losses=np.zeros(2))
    assert not gradients.losses.any()


def test_a_raster_holds_the_spikes_that_the_kernels_counted_and_changes_nothing():
    """It is a second look at the same windows; a run with it is the run without it, to the bit."""
    spec = specification()
    logs = []
    for controller in (CbmcV3(), CbmcV3(raster=100_000)):
        world = World(spec, spec.schedule)
        controller.reset(world.task())
        logs.append(run_episode(world.episode(controller, NoKnowledge())).log["command"])
    assert np.array_equal(*logs)
    events, stack = controller.events(), controller.stack
    for name in ("thalamus", "brainstem"):
        rows = events[f"spikes_{name}"]
        last = rows[rows[:, 0] == rows[:, 0].max()]
        counts = np.bincount(last[:, 2], minlength=len(getattr(stack, name).network.hidden_spikes))
        assert counts.tolist() == getattr(stack, name).network.hidden_spikes.tolist()


def test_a_raster_is_bounded():
    """What was not asked for is not kept."""
    raster = Raster(10)
    for _ in range(5):
        raster.note("layer", np.ones((3, 2)))
    assert raster.events()["spikes_layer"].shape == (10, 3)


def test_a_pool_of_workers_gives_the_bits_of_one_process():
    """Random draws belong to the run, not to the process that happens to do it."""
    duty = Duty(evaluate=score, evaluate_events=score_events, traces="none", plug_ins={})
    specifications = [specification(repetition=repetition) for repetition in range(3)]
    pooled = dict(run_in_workers(specifications, duty, workers=2))
    for position, here in enumerate(specifications):
        (alone,) = execute(here, evaluate=score, traces="none")
        # As text: a value that is not a number equals no other, not even itself from another process.
        assert json.dumps(pooled[position][0].metrics) == json.dumps(alone.metrics)


def test_running_needs_no_torch():
    """A user who only compares installs no torch; importing it would cost seconds even where it is there."""
    code = (
        "import sys\n"
        "from torquebench.controllers import discovery\n"
        "for name in ('cbmc_v3', 'cbmc_v3_literal', 'no_encoder', 'w_integrator', 'pd_oracle'):\n"
        "    discovery.load('controllers', name)()\n"
        "from torquebench.scenarios.robots import load_robot\n"
        "from torquebench.cbmc.patterns import find_patterns\n"
        "find_patterns(load_robot('rizon4s').model())\n"
        "print('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.strip() == "False"
