"""Random streams: shared by all controllers, moved by nothing that is not the draw's own."""

import subprocess
import sys

import numpy as np
import pytest
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.streams import controller_seed, scenario_stream

SHARED = {
    "controller": "compliant",
    "settings": {"gain": 3.0},
    "knowledge": "oracle",
    "plant": "pybullet",
    "tier": "ideal",
    "schedule": LoadSchedule(entries=((0.0, Payload(mass=1.5)), (3.0, Payload(mass=3.5, material="sand")))),
    "twins": True,
    "laps": 20,
    "lead_in": 0.0,
    "latency": 3,
    "tare": True,
    "tool": "flange",
}
GOLDEN_SEED, GOLDEN_DRAW = 6518539692048689474, -0.4548792097175093
OWN = {"robot": "other", "trajectory": "T2", "repetition": 1, "campaign": 2}


def run(**changes):
    """Return a run."""
    settings = {
        "controller": "computed_torque",
        "trajectory": "T1",
        "schedule": LoadSchedule.constant(Payload(mass=1.5)),
        "robot": "rizon4s",
        "plant": "pinocchio",
        "tier": "actuated",
    }
    return RunSpecification(**settings | changes)


def draws(specification, name="sensor"):
    """Return the first numbers of a stream."""
    return scenario_stream(name, specification).standard_normal(5)


def one(changes, name):
    """Return a single change."""
    return {name: changes[name]}


@pytest.mark.parametrize("name", SHARED)
def test_no_draw_depends_on_who_controls_or_what_hangs_there(name):
    """Twins, variants and rivals share every draw, or their difference would be noise."""
    assert np.array_equal(draws(run(**one(SHARED, name))), draws(run()))


@pytest.mark.parametrize("name", OWN)
def test_another_motion_or_repetition_draws_anew(name):
    """Ten repetitions are ten samples."""
    assert not np.array_equal(draws(run(**one(OWN, name))), draws(run()))


def test_streams_of_one_run_are_independent_and_know_nothing_of_each_other():
    """A stream is found by its name: one more, or more draws from one, moves no other."""
    before = draws(run(), "plant")
    scenario_stream("a new stream", run()).standard_normal(1000)
    scenario_stream("sensor", run()).standard_normal(1000)
    assert np.array_equal(draws(run(), "plant"), before)
    firsts = [draws(run(), name)[0] for name in ("sensor", "plant", "initial state", "a new stream")]
    assert len(set(firsts)) == 4


@pytest.mark.parametrize("name", ["controller", "settings", "repetition", "campaign", "trajectory", "robot"])
def test_a_controllers_own_seed_moves_with_its_name_and_settings(name):
    """Two presets of one law are two samples."""
    assert controller_seed(run(**one(SHARED | OWN, name))) != controller_seed(run())


@pytest.mark.parametrize("name", ["knowledge", "plant", "tier", "schedule", "laps", "latency", "tare"])
def test_a_controllers_own_seed_stays_with_its_knowledge_plant_and_load(name):
    """A twin differs by its load and nothing else; so does a level of knowledge."""
    assert controller_seed(run(**one(SHARED, name))) == controller_seed(run())


def test_the_order_of_settings_is_no_other_controller():
    """Dictionaries have an order; seeds must not."""
    assert controller_seed(run(settings={"a": 1, "b": 2})) == controller_seed(run(settings={"b": 2, "a": 1}))


def test_seeds_are_the_same_in_every_process():
    """Python's own hash of a text differs from process to process."""
    program = (
        "import sys; from torquebench.scenarios.specification import RunSpecification as R;"
        "from torquebench.scenarios.streams import controller_seed, scenario_stream;"
        "s = R.from_json(sys.stdin.read());"
        "print(controller_seed(s), scenario_stream('sensor', s).standard_normal().hex())"
    )
    text = run().as_json()
    done = subprocess.run([sys.executable, "-c", program], input=text, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(controller_seed(run())), draws(run())[0].hex()]


def test_the_draws_are_these():
    """A golden value: whoever changes how streams are made changes every published result."""
    assert controller_seed(run()) == GOLDEN_SEED
    assert draws(run())[0] == GOLDEN_DRAW
