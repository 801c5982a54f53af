"""The command of a run: a shell and the benchmark's own reader must turn it back into the very specification."""

import shlex

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.scenarios.benchmark import load_benchmark
from torquebench.scenarios.command import _toml, repeating_command
from torquebench.scenarios.expansion import expand
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.perturbation import Perturbation
from torquebench.scenarios.specification import RunSpecification

SAND = Payload(mass=3.5, material="sand")
EMPTY = Payload(mass=1.5)
EVENTS = LoadSchedule(entries=((0.0, EMPTY), (1.25, SAND), (2.5, EMPTY)))


def run_of(**changes):
    plain = {
        "controller": "computed_torque", "trajectory": "T1", "schedule": LoadSchedule.constant(SAND),
        "robot": "rizon4s", "tool": "gripper", "plant": "pinocchio", "tier": "actuated",
    }  # fmt: skip
    return RunSpecification(**(plain | changes))


def changes_of(command: str) -> list[str]:
    """Read a command as a shell would."""
    words = shlex.split(command)
    assert words[:3] == ["torquebench", "run", "quick"]
    assert set(words[3::2]) == {"--set"}
    return words[4::2]


@pytest.mark.parametrize(
    "run",
    [
        run_of(),
        run_of(schedule=LoadSchedule.constant(EMPTY), knowledge="oracle", laps=2, lead_in=0.5, campaign=7),
        run_of(settings={"bandwidth": 12.5}, repetition=2, draws=True),
        run_of(schedule=EVENTS, twins=True),
        run_of(schedule=EVENTS, latency="measured", tare=True),
        run_of(perturbation=Perturbation(payload=0.5, delay=3), latency=2, tier="tight_rate"),
        run_of(controller="torquebench.baselines.presets:computed_torque", settings={"bandwidth": 30.0}),
        run_of(controller="cbmc_v3_carried", protocol="carried", repetitions=3),
    ],
    ids=["plain", "empty", "settings", "twins", "measured", "perturbed", "door", "carried"],
)
def test_a_command_runs_the_specification_it_came_from(run):
    """The same specification has the same address: a command that only looks right would run something else."""
    benchmark = load_benchmark("quick", changes=changes_of(repeating_command(run)))
    found = expand(benchmark).specifications
    assert run.as_json() in [specification.as_json() for specification in found]
    assert len(found) == run.repetition + 1


def test_a_controller_that_was_an_object_has_no_command():
    """A command with its name would find nobody, or somebody else."""
    assert repeating_command(run_of(controller="MyOwnLaw")) == ""


PLAIN = st.recursive(
    st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(min_size=1), inner, max_size=3),
    max_leaves=6,
)


@given(PLAIN)
def test_every_plain_value_survives_the_shell_and_toml(value):
    """Quotes, dollars, newlines and right-to-left marks in a setting reach the controller unchanged."""
    import tomllib

    (word,) = shlex.split(shlex.quote(f"value={_toml(value)}"))
    assert tomllib.loads(word)["value"] == value


def test_a_setting_of_none_has_no_command():
    """TOML cannot say it, and a setting left out is another run."""
    assert repeating_command(run_of(settings={"bandwidth": None})) == ""
