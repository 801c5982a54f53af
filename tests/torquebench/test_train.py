"""``torquebench train`` as a user meets it."""

import importlib.util
import json

import pytest
from click.testing import CliRunner
from torquebench.cbmc.patterns import find_patterns
from torquebench.commands.train import command
from torquebench.controllers import TorquebenchError
from torquebench.scenarios.robots import read_robot


@pytest.fixture
def swing(tmp_path, urdf_of, monkeypatch):
    """A URDF of two joints, in a home folder without patterns."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    file = tmp_path / "swing.urdf"
    file.write_text(urdf_of("yy"))
    return file


def call(*arguments):
    return CliRunner().invoke(command, ["cerebellum", *map(str, arguments)])


@pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="training needs torch")
@pytest.mark.parametrize("as_json", [True, False])
def test_an_arm_of_ones_own_is_trained_and_found_from_then_on(swing, as_json):
    """No setting names the file: the arm is known by its gravity."""
    done = call("--robot", swing, "--preset", "smoke", "--loads", "0.5", *(["--json"] if as_json else []))
    assert done.exit_code == 0, done.output
    patterns = find_patterns(read_robot(swing).model())
    assert patterns.loads == (0.5,)
    if as_json:
        printed = json.loads(done.stdout)
        assert printed["robot"]["name"] == "swing" and printed["file"].endswith("swing.safetensors")
        assert [row["group"] for row in printed["evaluation"]["rows"]] == ["workspace"]
    else:
        assert "0.5 kg beyond the gripper" in done.stdout and "workspace" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--robot", "nobody"), "unknown robot 'nobody'"),
        (("--loads", "0;3"), "--loads: '0;3' is no list of masses"),
        (("--loads", "3,0"), "give increasing masses"),
        (("--set", "tubes"), "did you mean 'tube'"),
        (("--preset", "bset"), "did you mean 'best'"),
        (("--out", "here.npz"), "give a name in .safetensors"),
        (("--seed", "-1"), "seed -1"),
    ],
)
def test_a_wrong_input_is_one_line_and_starts_no_training(arguments, says):
    """The command line prints the sentence and ends with status 2."""
    error = call(*arguments).exception
    assert isinstance(error, TorquebenchError)
    assert says in str(error) and "\n" not in str(error)
