"""Laws of the errors: a sentence for a person, data for a program, one root."""

import inspect

import pytest
from torquebench.evaluation import errors
from torquebench.evaluation.errors import (
    AmbiguousRuns,
    EmptyWindow,
    EvaluationError,
    InvalidLog,
    MissingFields,
    NothingToCompare,
    TooFewUnits,
    UnequalLengths,
    UnknownMetric,
    UnknownMotionSet,
    UnknownWindow,
)

EXAMPLES = (
    EmptyWindow("time_lag"),
    InvalidLog("quat", "length 1.2 in row 0", "valid are unit quaternions"),
    MissingFields("torque_ripple", ("tau",)),
    UnequalLengths("time_lag", {"p": 10, "p_ref": 9}),
    UnknownMetric("time_lagg", ["time_lag", "lag_share"]),
    UnknownWindow("event", ("run", "steady")),
    UnknownMotionSet("new", ("paper", "further")),
    TooFewUnits("BCa interval", 4, 5),
    AmbiguousRuns("pd", ("T1", 1.5, "", 0)),
    NothingToCompare("pd", "mpc", "no pair"),
)


def test_every_error_has_an_example_here():
    """A new error must show its sentence."""
    defined = {c for _, c in inspect.getmembers(errors, inspect.isclass) if issubclass(c, EvaluationError)}
    assert {type(example) for example in EXAMPLES} == defined - {EvaluationError}


@pytest.mark.parametrize("error", EXAMPLES, ids=lambda error: type(error).__name__)
def test_one_except_catches_all(error):
    """A caller of this room needs a single clause."""
    with pytest.raises(EvaluationError):
        raise error


@pytest.mark.parametrize("error", EXAMPLES, ids=lambda error: type(error).__name__)
def test_the_message_is_one_line_without_quotes_around_it(error):
    """The command line prints it as it is."""
    assert "\n" not in str(error)
    assert not str(error).startswith(("'", '"'))
    assert len(str(error)) > 10


def test_unequal_lengths_name_each_array():
    """Which one is short is what the reader looks for."""
    error = UnequalLengths("time_lag", {"p": 10, "p_ref": 9})
    assert str(error) == "time_lag: arrays of unequal length: p has 10, p_ref has 9 ticks"
    assert error.lengths == {"p": 10, "p_ref": 9}


def test_a_near_miss_gets_a_hint():
    """One letter wrong, one suggestion."""
    assert "did you mean 'time_lag'?" in str(UnknownMetric("time_lagg", ["time_lag", "lag_share"]))


def test_a_wild_guess_gets_the_list():
    """Nothing is near: show what there is."""
    assert str(UnknownMetric("qqq", ["time_lag", "lag_share"])).endswith("known: lag_share, time_lag")


def test_errors_of_lookup_and_value_are_pythons_too():
    """An analyst who catches ValueError or KeyError is served."""
    assert isinstance(EmptyWindow("x"), ValueError)
    assert isinstance(UnknownMetric("x", ["y"]), KeyError)


def test_errors_carry_what_they_say():
    """A program must not parse sentences."""
    assert EmptyWindow("time_lag").metric == "time_lag"
    assert UnknownWindow("event", ("run",)).known == ("run",)
    assert (TooFewUnits("BCa", 4, 5).n, TooFewUnits("BCa", 4, 5).minimum) == (4, 5)
    assert AmbiguousRuns("pd", ("T1",)).key == ("T1",)
    assert NothingToCompare("pd", "mpc", "no pair").reason == "no pair"
