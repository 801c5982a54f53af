"""A run as data: the same text, the same address, on every machine."""

import dataclasses
import json
import subprocess
import sys

import pytest
from torquebench.controllers import InvalidInput
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.perturbation import Perturbation
from torquebench.scenarios.specification import RunSpecification, canonical_json

STEP = LoadSchedule(
    entries=((0.0, Payload(mass=1.5)), (12.0, Payload(mass=3.5, material="sand")), (24.0, Payload(mass=1.5)))
)


def specification(**changes):
    """Return a run with a load step."""
    settings = {
        "controller": "computed_torque",
        "settings": {"bandwidth": 20.0, "b": [1, 2.5], "a": {"y": None, "x": True}},
        "trajectory": "T6",
        "schedule": STEP,
        "robot": "rizon4s",
        "plant": "pinocchio",
        "tier": "actuated",
        "twins": True,
    }
    return RunSpecification(**settings | changes)


def test_a_specification_read_back_is_the_same():
    """All of it, settings and schedule included."""
    original = specification(tool="flange", laps=20, lead_in=0.5, latency=2, campaign=7, repetition=3, draws=True)
    assert RunSpecification.from_json(original.as_json()) == original


def test_its_text_is_canonical():
    """Sorted keys, no spaces, the same after any number of round trips."""
    text = specification().as_json()
    assert RunSpecification.from_json(text).as_json() == text
    assert json.dumps(json.loads(text), sort_keys=True, separators=(",", ":")) == text


def test_the_order_of_settings_does_not_matter():
    """One run, one address."""
    one = specification(settings={"a": 1, "b": 2})
    two = specification(settings={"b": 2, "a": 1})
    assert one.as_json() == two.as_json()


@pytest.mark.parametrize("value", [0.1, 1 / 3, 1e-300, 2.0**-52, 123456789.123456789])
def test_numbers_read_back_to_the_bit(value):
    """The shortest text that does: no digit lost, none invented."""
    found = RunSpecification.from_json(specification(settings={"x": value}).as_json()).settings["x"]
    assert found == value


@pytest.mark.parametrize(
    "change",
    [
        {"controller": "compliant"},
        {"settings": {"bandwidth": 20.000000000000004}},
        {"knowledge": "oracle"},
        {"trajectory": "T5"},
        {"schedule": LoadSchedule.constant(Payload(mass=1.5))},
        {"twins": False},
        {"robot": "other"},
        {"tool": "flange"},
        {"plant": "pybullet"},
        {"tier": "ideal"},
        {"laps": 4},
        {"lead_in": 0.0},
        {"latency": 1},
        {"latency": "measured"},
        {"tare": True},
        {"campaign": 2},
        {"repetition": 1},
        {"perturbation": Perturbation(payload=0.1)},
        {"twins": False, "study": "load_margin"},
        {"twins": False, "study": "delay_margin"},
        {"protocol": "carried", "twins": False},
        {"protocol": "carried", "twins": False, "repetitions": 2},
        {"draws": True},
    ],
    ids=lambda change: next(iter(change)),
)
def test_whatever_changes_the_result_changes_the_address(change):
    """A store that answers with another run's row is worse than none; the table covers every field."""
    assert specification(**change).address("code") != specification().address("code")


def test_every_field_is_in_the_text():
    """A field added later must not be forgotten in the address."""
    fields = {field.name for field in dataclasses.fields(RunSpecification)}
    rare = {"tare": True, "draws": True, "tier_constants": {"substeps": 2}}
    full = specification(twins=False, perturbation=Perturbation(delay=1), study="load_margin", **rare)
    assert set(json.loads(full.as_json())) == fields | {"schema"}
    assert RunSpecification.from_json(full.as_json()) == full


def test_an_ordinary_run_has_no_word_of_what_came_later():
    """Its text, and with it its address, is what it was before there were tares, draws, perturbations and studies."""
    assert not {"tier_constants", "tare", "draws", "perturbation", "study"} & set(json.loads(specification().as_json()))
    assert RunSpecification.from_json(specification().as_json()) == specification()


def test_draws_in_the_tier_ideal_are_refused():
    """It is the nominal arm by definition."""
    line = "run: draws = true in tier 'ideal'; it is the nominal arm with exact sensors; choose another tier"
    with pytest.raises(InvalidInput, match=line):
        specification(tier="ideal", draws=True)


def test_the_code_that_runs_is_part_of_the_address():
    """Another digest, another result."""
    assert specification().address("one") != specification().address("two")


def test_an_address_does_not_depend_on_the_process():
    """Python's own hash does; results are looked up by other processes and machines."""
    program = (
        "import sys; from torquebench.scenarios.specification import RunSpecification as R;"
        "print(R.from_json(sys.stdin.read()).address('code'))"
    )
    original = specification()
    done = subprocess.run(
        [sys.executable, "-c", program], input=original.as_json(), capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == original.address("code")
    assert len(original.address("code")) == 64


def test_the_label_is_the_controllers_own_name_with_its_knowledge():
    """What follows the colon of a door: tables are narrow."""
    assert specification(controller="./laws/mine.py:Mine", knowledge="oracle").label == "Mine / oracle"
    assert specification().label == "computed_torque / none"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"laps": 0}, "run: laps = 0; at least 1"),
        ({"latency": -1}, "run: latency = -1; whole ticks from 0, or 'measured'"),
        ({"latency": 1.5}, "run: latency = 1.5; whole ticks from 0"),
        ({"latency": True}, "run: latency = True; whole ticks from 0"),
        ({"latency": "mesured"}, "run: latency = 'mesured'; did you mean 'measured'?"),
        ({"repetition": -1}, "run: repetition = -1; at least 0"),
        ({"lead_in": -0.1}, "run: lead_in = -0.1 s; between 0 and 60 s"),
        ({"lead_in": 60.0}, "run: lead_in = 60 s"),
        ({"lead_in": float("nan")}, "run: lead_in = nan s"),
    ],
)
def test_numbers_that_cannot_be_run_are_refused(change, message):
    """The field, what came, what is valid."""
    with pytest.raises(InvalidInput, match=message):
        specification(**change)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), object(), {1, 2}])
def test_settings_that_json_cannot_hold_are_refused(value):
    """NaN too: it is equal to nothing, itself included."""
    with pytest.raises(InvalidInput, match="not JSON-serialisable"):
        canonical_json({"gain": value})


def test_a_specification_is_frozen():
    """Its address was taken."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        specification().laps = 5
