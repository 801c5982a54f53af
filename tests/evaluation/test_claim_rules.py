"""Verdict rules on numbers made by hand: every column of every rule."""

import math

import pytest
from torquebench.evaluation.claims.rules import (
    NOT_REPRODUCED,
    OPPOSITE,
    REPRODUCED,
    SMALLER,
    UNDECIDED,
    UNTESTABLE,
    agreement_rule,
    cells_rule,
    correlation_rule,
    count_rule,
    effect_rule,
    interaction_rule,
    level_rule,
    ratio_rule,
    slope_rule,
    time_rule,
)
from torquebench.evaluation.intervals import Interval


def between(low, high):
    return Interval(low, high, 0.95, "t")


PRINTED = math.log(1.0 - 0.206)
"""The paper's 20.6 %: half of its logarithm is a ratio of 0.891."""


@pytest.mark.parametrize(
    ("estimate", "interval", "n", "printed", "word"),
    [
        (-0.20, between(-0.30, -0.10), 8, PRINTED, REPRODUCED),
        (-0.12, between(-0.20, -0.04), 8, PRINTED, REPRODUCED),
        (-0.01, between(-0.02, -0.005), 8, None, REPRODUCED),
        (-0.10, between(-0.18, -0.02), 8, PRINTED, SMALLER),
        (-0.02, between(-0.08, 0.04), 8, PRINTED, NOT_REPRODUCED),
        (0.30, between(0.10, 0.50), 8, PRINTED, OPPOSITE),
        (0.30, between(0.10, 0.50), 8, None, OPPOSITE),
        (-0.10, between(-0.30, 0.10), 8, PRINTED, UNDECIDED),
        (-0.02, between(-0.08, 0.04), 8, None, UNDECIDED),
        (-0.20, between(-0.30, -0.10), 5, PRINTED, UNDECIDED),
        (-0.20, between(-0.30, -0.10), 6, PRINTED, REPRODUCED),
        (-0.20, None, 1, PRINTED, UNDECIDED),
    ],
)
def test_a_ratio(estimate, interval, n, printed, word):
    """Five trajectories never decide: their smallest p is 0.0625."""
    assert ratio_rule(estimate, interval, n, printed).word == word


def test_a_ratio_whose_averages_disagree_is_none():
    """The geometric mean says one thing, the paper's percentage another: the reader is told, not one of them chosen."""
    found = ratio_rule(-0.2, between(-0.3, -0.1), 8, PRINTED, averages_agree=False)
    assert (found.word, found.reason) == (UNDECIDED, "depends on the average used")


def test_a_ratio_of_ranges_without_repetitions_is_undecided():
    """Trajectories cannot be resampled for a range."""
    assert effect_rule(-1.0, None, PRINTED).word == UNDECIDED


@pytest.mark.parametrize(
    ("interval", "word"),
    [
        (between(-0.3, -0.1), REPRODUCED),
        (between(0.1, 0.3), OPPOSITE),
        (between(-0.2, 0.1), UNDECIDED),
        (None, UNDECIDED),
    ],
)
def test_an_interaction(interval, word):
    """Five against three motions usually leave it open."""
    assert interaction_rule(interval).word == word


@pytest.mark.parametrize(
    ("holding", "pooled", "word"),
    [
        (10, between(-0.3, -0.1), REPRODUCED),
        (9, between(-0.3, -0.1), SMALLER),
        (8, between(-0.3, -0.1), SMALLER),
        (7, between(-0.3, -0.1), NOT_REPRODUCED),
        (2, between(-0.3, -0.1), NOT_REPRODUCED),
        (10, between(0.1, 0.3), NOT_REPRODUCED),
        (3, between(0.1, 0.3), NOT_REPRODUCED),
        (2, between(0.1, 0.3), OPPOSITE),
        (0, between(0.1, 0.3), OPPOSITE),
        (10, between(-0.3, 0.1), UNDECIDED),
        (10, None, UNDECIDED),
    ],
)
def test_every_cell(holding, pooled, word):
    """One cell that fails is enough to lose the first word."""
    assert cells_rule({f"cell {i}": i < holding for i in range(10)}, pooled).word == word


def test_the_cells_that_fail_are_named():
    """A reader must be able to look."""
    assert "not in 3.5 kg" in cells_rule({str(i): True for i in range(9)} | {"3.5 kg": False}, between(-2, -1)).reason


@pytest.mark.parametrize(
    ("interval", "word"),
    [
        (between(-0.3, -0.1), REPRODUCED),
        (between(0.1, 0.3), OPPOSITE),
        (between(-0.01, 0.01), NOT_REPRODUCED),
        (between(-0.1, 0.1), UNDECIDED),
        (None, UNDECIDED),
    ],
)
def test_a_slope(interval, word):
    """No slope is a finding only where it is known to within 2 % of the mean."""
    assert slope_rule(interval, 1.0).word == word


@pytest.mark.parametrize(
    ("times", "word"),
    [
        ([1.0, 1.4, 2.2], REPRODUCED),
        ([2.25, 2.25], REPRODUCED),
        ([3.0, 4.0], SMALLER),
        ([5.0], NOT_REPRODUCED),
        ([1.0, math.inf, math.inf], NOT_REPRODUCED),
        ([1.0, 1.1, math.inf], REPRODUCED),
        ([], UNDECIDED),
    ],
)
def test_a_time_of_recovery(times, word):
    """Against 1.5 s; a recovery that never came counts as the longest."""
    assert time_rule(times, 1.5).word == word


def test_a_time_that_depends_on_its_threshold_is_none():
    """Recovered at 50 %, never at 10 %: which is it?"""
    found = time_rule([1.0], 1.5, [[1.0], [0.4], [math.inf]])
    assert found.word == UNDECIDED
    assert time_rule([1.0], 1.5, [[1.0], [0.4], []]).word == REPRODUCED


@pytest.mark.parametrize(
    ("counts", "stable", "null", "word"),
    [
        ([3, 3, 3, 3, 2], 1.0, [1, 1, 2], REPRODUCED),
        ([3, 3, 3, 3, 3], 1.0, [3, 3, 2], SMALLER),
        ([3, 3, 3, 2, 2], 1.0, [1, 1, 2], NOT_REPRODUCED),
        ([2, 2, 2, 2, 2], 1.0, [1, 1, 2], NOT_REPRODUCED),
        ([3, 3, 3, 3, 3], 0.6, [1, 1, 2], UNDECIDED),
        ([3, 3, 3, 3, 3], 1.0, [], UNDECIDED),
        ([], 1.0, [1], UNDECIDED),
    ],
)
def test_a_count_of_peaks(counts, stable, null, word):
    """Three peaks of a plain controller are no signature of three levels."""
    assert count_rule(counts, 3, stable=stable, nulls={"a plain controller": null}).word == word


@pytest.mark.parametrize(
    ("r", "interval", "word"),
    [
        (-0.6, between(-0.8, -0.4), REPRODUCED),
        (-0.2, between(-0.3, -0.1), SMALLER),
        (-0.1, between(-0.3, 0.1), NOT_REPRODUCED),
        (0.6, between(0.4, 0.8), OPPOSITE),
    ],
)
def test_a_correlation(r, interval, word):
    """Against the printed -0.564 and a band of 0.3."""
    assert correlation_rule(r, interval, -0.564, 0.3).word == word


def test_a_level():
    """Limits included."""
    assert [level_rule(v, 0.5, 2.0).word for v in (0.5, 2.0, 0.49, 2.1)] == [REPRODUCED] * 2 + [NOT_REPRODUCED] * 2


@pytest.mark.parametrize(
    ("words", "word"),
    [
        ([(REPRODUCED, SMALLER)] * 5, REPRODUCED),
        ([(OPPOSITE, OPPOSITE)] * 5, REPRODUCED),
        ([(REPRODUCED, REPRODUCED)] * 4 + [(REPRODUCED, OPPOSITE)], SMALLER),
        ([(REPRODUCED, REPRODUCED)] * 3 + [(REPRODUCED, OPPOSITE)], NOT_REPRODUCED),
        ([(REPRODUCED, REPRODUCED)] * 4 + [(REPRODUCED, UNDECIDED)], UNDECIDED),
        ([(REPRODUCED, UNTESTABLE)], UNDECIDED),
        ([], UNDECIDED),
    ],
)
def test_an_agreement(words, word):
    """One open claim leaves all open."""
    assert agreement_rule({f"C{i}": pair for i, pair in enumerate(words)}).word == word
