"""Every registered controller keeps the contract on a real episode; broken ones are found out."""

import numpy as np
import pytest
from torquebench.controllers import PlugInFailure, UnknownName, discovery
from torquebench.scenarios.conformance import SECONDS, check, recording


def broken(findings):
    """Return what does not hold, with its detail."""
    return {finding.check: finding.detail for finding in findings if not finding.passed}


@pytest.mark.parametrize("name", discovery.names("controllers"))
def test_a_registered_controller_keeps_the_contract(name):
    """Determinism after reset, in a fresh instance, beside another; inputs neither kept nor changed."""
    try:
        discovery.load("controllers", name)
    except PlugInFailure as failure:
        pytest.skip(str(failure))
    assert broken(check(name)) == {}


def test_the_recording_is_a_real_episode():
    """Quantised positions, noisy forces, a load the model does not know, a plan that gets moving."""
    task, observations, targets = recording()
    assert len(observations) == len(targets) == round(SECONDS / task.period)
    assert observations[0].time == -SECONDS
    assert np.linalg.norm(targets[-1].twist[:3]) > 0.2
    assert np.linalg.norm(targets[-1].q - observations[-1].q) < 0.05
    assert observations[50].wrench[2] == pytest.approx(2.5 * 9.81, abs=3.0)
    assert len({observation.wrench[0] for observation in observations}) == len(observations)
    assert not task.robot.payload.any()


SOURCE = """
import numpy as np
class Sound:
    def __init__(self, *, gain=100.0): self.gain = gain
    def reset(self, task): self.robot = task.robot
    def compute(self, observation, target):
        return self.gain * (target.q - observation.q) - 5 * observation.dq + self.robot.gravity(observation.q)
class KeepsATarget(Sound):
    def reset(self, task): super().reset(task); self.last = None
    def compute(self, observation, target):
        moved = 0 if self.last is None else target.q - self.last
        self.last = target.q
        return super().compute(observation, target) + 1000 * moved
class Unseeded(Sound):
    def compute(self, observation, target): return super().compute(observation, target) + np.random.normal(size=7)
class Six(Sound):
    def compute(self, observation, target): return super().compute(observation, target)[:6]
class Late(Sound):
    def reset(self, task): super().reset(task); self.k = 0
    def compute(self, observation, target):
        self.k += 1
        return super().compute(observation, target) + (np.nan if self.k > 150 else 0.0)
"""


@pytest.fixture
def door(tmp_path):
    """Leads to a class of an author's file."""
    file = tmp_path / "laws.py"
    file.write_text(SOURCE)
    return lambda name: f"{file}:{name}"


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("Sound", set()),
        ("KeepsATarget", {"keeps no input"}),
        ("Six", {"shape"}),
        ("Late", {"finite"}),
    ],
)
def test_an_authors_file_is_checked_like_any_other(door, name, found):
    """Broken in one way each, and found out in that way."""
    assert set(broken(check(door(name)))) == found


def test_an_unseeded_controller_differs_wherever_it_is_repeated(door):
    """From the first tick."""
    found = broken(check(door("Unseeded")))
    assert set(found) >= {"repeats after reset", "repeats in a fresh instance", "keeps no input"}
    assert found["repeats after reset"].startswith("differs from tick 0")


def test_the_finding_names_the_tick(door):
    """NaN after 150 of 200."""
    assert broken(check(door("Late")))["finite"].startswith("tick 150 returned")


def test_settings_reach_the_controller(door):
    """The configured controller is what is checked."""
    assert broken(check(door("Sound"), {"gain": float("nan")})).keys() == {"finite"}


def test_an_unknown_controller_names_the_nearest():
    """One line, as everywhere."""
    with pytest.raises(UnknownName, match="did you mean"):
        check("computed_torqu")
