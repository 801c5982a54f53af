"""Pairs of two controllers: their log-ratios, cell by cell, in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.pairing import FLOOR, Ratios
from torquebench.evaluation.rows import Reading

LIGHT, HEAVY = (1.5, ""), (2.5, "sand")


def readings(pairs, status="ok"):
    """Return readings of pairs of magnitudes by trajectory, load and repetition."""
    return {
        (path, *load, repetition): tuple(Reading(value, status if value is not None else "undefined") for value in pair)
        for (path, load, repetition), pair in pairs.items()
    }


@pytest.fixture
def uneven():
    """Two motions; the first has two loads and two repetitions of one of them."""
    return {
        ("T1", LIGHT, 0): (1.0, 2.0),
        ("T1", LIGHT, 1): (1.0, 8.0),
        ("T1", HEAVY, 0): (1.0, 16.0),
        ("T2", LIGHT, 0): (4.0, 1.0),
    }


def test_a_trajectory_is_the_mean_of_its_cells_of_the_mean_of_their_repetitions(uneven):
    """Logarithms to base 2: -1 and -3 are -2, with -4 they are -3; the other motion is +2."""
    found = Ratios.of(readings(uneven)).by_trajectory() / math.log(2.0)
    assert found == pytest.approx([-3.0, 2.0])


def test_a_pair_without_one_side_is_no_pair(uneven):
    """Half a comparison would be one with the average of others."""
    lost = {**uneven, ("T3", LIGHT, 0): (1.0, None), ("T4", LIGHT, 0): (None, 1.0)}
    assert len(Ratios.of(readings(lost)).pairs) == len(uneven)
    assert Ratios.of(readings(lost)).by_trajectory() == pytest.approx(Ratios.of(readings(uneven)).by_trajectory())


def test_exchanging_the_two_turns_the_sign(uneven):
    """Who is called the reference must not decide how far apart the two are."""
    swapped = {key: (b, a) for key, (a, b) in uneven.items()}
    assert Ratios.of(readings(swapped)).by_trajectory() == pytest.approx(-Ratios.of(readings(uneven)).by_trajectory())


@given(st.floats(1e-3, 1e3))
def test_the_unit_of_both_cancels(factor):
    """Metres or millimetres: a ratio has none."""
    pairs = {("T1", LIGHT, 0): (0.3, 0.7), ("T2", HEAVY, 0): (0.5, 0.2)}
    scaled = {key: (factor * a, factor * b) for key, (a, b) in pairs.items()}
    expected = Ratios.of(readings(pairs)).by_trajectory()
    assert Ratios.of(readings(scaled)).by_trajectory() == pytest.approx(expected, rel=1e-9)


def test_a_zero_has_the_logarithm_of_the_floor():
    """No clipped tick against no clipped tick is equal, not undefined; against one it is far better."""
    both, one = (Ratios.of(readings({("T1", LIGHT, 0): pair})) for pair in ((0.0, 0.0), (0.0, 1.0)))
    assert both.by_trajectory().tolist() == [0.0]
    assert one.by_trajectory() == pytest.approx([math.log(FLOOR)])


def test_one_repetition_has_no_interval_of_the_suite():
    """Nothing scatters where nothing was repeated."""
    assert Ratios.of(readings({("T1", LIGHT, 0): (1.0, 2.0)})).suite_interval() is None


def test_the_interval_of_the_suite_is_around_the_mean_over_trajectories(uneven):
    """The same weights as the point that it belongs to: 1/2 for each motion, shared by its cells."""
    ratios = Ratios.of(readings(uneven))
    interval = ratios.suite_interval()
    middle = math.sqrt(interval.low * interval.high)
    assert middle == pytest.approx(math.exp(np.mean(ratios.by_trajectory())))
    assert interval.method == "suite"


def test_the_interval_of_the_suite_is_student_s_of_the_one_cell_that_repeats():
    """One motion, one load, logs of -1, 0 and 1: mean 0, error 1/sqrt 3, and 4.3027 from the table."""
    pairs = {("T1", LIGHT, k): (math.exp(k - 1.0), 1.0) for k in range(3)}
    interval = Ratios.of(readings(pairs)).suite_interval()
    half = 4.302653 / math.sqrt(3.0)
    assert math.log(interval.low) == pytest.approx(-half, rel=1e-5)
    assert math.log(interval.high) == pytest.approx(half, rel=1e-5)


def test_means_of_cells_are_of_the_magnitudes_of_one_side(uneven):
    """For the ratio of means, which is the paper's percentage."""
    ratios = Ratios.of(readings(uneven))
    assert ratios.cell_means(0) == [1.0, 1.0, 4.0]
    assert ratios.cell_means(1) == [5.0, 16.0, 1.0]


def test_nothing_to_compare_is_empty_everywhere():
    """Two controllers on different motions."""
    empty = Ratios.of({})
    assert len(empty.by_trajectory()) == 0
    assert empty.cell_means(0) == []
    assert empty.suite_interval() is None


def test_a_bound_counts_with_its_magnitude():
    """A censored lag has a number; only what has none is left out."""
    bounded = Ratios.of(readings({("T1", LIGHT, 0): (0.25, 0.5)}, status="censored"))
    assert bounded.by_trajectory() == pytest.approx([-math.log(2.0)])
