"""What a user can cause ends in one sentence, and carries its data for a program."""

import pytest
from torquebench.controllers import InvalidInput, PlugInFailure, Refusal, TorquebenchError, UnknownName


def test_an_unknown_name_suggests_the_nearest():
    """One suggestion is read; a list is not."""
    error = UnknownName("controller", "computed_torqe", ["computed_torque", "compliant"])
    assert str(error) == "unknown controller 'computed_torqe'; did you mean 'computed_torque'?"
    assert (error.kind, error.name, error.known) == (
        "controller",
        "computed_torqe",
        ("computed_torque", "compliant"),
    )


def test_an_unknown_name_far_from_all_lists_them_in_order():
    """Nothing is near: say what exists."""
    assert str(UnknownName("plant", "xyz", ["pybullet", "mujoco"])) == "unknown plant 'xyz'; known: mujoco, pybullet"


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        (("mass -1 kg", "load", "masses are positive"), "load: mass -1 kg; masses are positive"),
        (("mass -1 kg", "load"), "load: mass -1 kg"),
        (("mass -1 kg",), "mass -1 kg"),
    ],
)
def test_invalid_input_says_where_what_and_what_would_be_valid(parts, sentence):
    """In this order, leaving out what is not known."""
    assert str(InvalidInput(*parts)) == sentence


def test_a_failed_plug_in_keeps_its_cause():
    """The program can still show the traceback when asked to."""
    cause = ImportError("line one\n  line two")
    error = PlugInFailure("controller", "law", "pkg, pkg:Law", cause)
    assert error.cause is cause
    assert str(error) == "controller 'law' (pkg, pkg:Law) could not be loaded: ImportError: line one line two"


@pytest.mark.parametrize("kind", [UnknownName, InvalidInput, PlugInFailure, Refusal])
def test_every_error_of_a_user_has_one_root(kind):
    """The command line catches one class and prints one line."""
    assert issubclass(kind, TorquebenchError)
