"""Pieces of error curves: which rows a time means, whole laps before it, averages at the ends, peaks by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics.curves import (
    between,
    count_peaks,
    count_raw_peaks,
    first_stay,
    last_cycles,
    moving_average,
    row_at,
)
from torquebench.evaluation.metrics.registry import Censored
from torquebench.evaluation.metrics.series import phase_matched

DT = 1e-3


def bump(centre, height=1.0, width=0.05, seconds=2.5, dt=DT):
    """A smooth hill at a time."""
    t = np.arange(round(seconds / dt)) * dt
    return height * np.exp(-0.5 * ((t - centre) / width) ** 2)


@given(st.integers(0, 50_000), st.sampled_from([1e-3, 2e-3, 1e-2]))
def test_the_row_of_a_row_s_time_is_that_row(row, dt):
    """12.0 s is a decimal, row 12000 times 1 ms is not: rounding must not move an event by a tick."""
    assert row_at(row * dt, dt, 100_000) == row
    assert row_at(round(row * dt, 9), dt, 100_000) == row


@pytest.mark.parametrize(("time", "row"), [(-1.0, 0), (0.0, 0), (0.0104, 10), (0.0106, 11), (1e6, 20), (math.inf, 20)])
def test_a_time_beyond_the_curve_is_its_end(time, row):
    """The event of a run that ended early, and the end that never comes."""
    assert row_at(time, DT, 20) == row


@given(st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3))
def test_neighbouring_parts_share_no_row_and_lose_none(times):
    """What one event is charged for, the next one is not."""
    curve = np.arange(1000.0)
    first, second, third = sorted(times)
    joined = np.concatenate([between(curve, first, second, DT), between(curve, second, third, DT)])
    assert np.array_equal(joined, between(curve, first, third, DT))


def test_a_part_of_many_joints_keeps_its_columns():
    """The rows are times, whatever stands in them."""
    curve = np.arange(60.0).reshape(20, 3)
    assert np.array_equal(between(curve, 5 * DT, 8 * DT, DT), curve[5:8])
    assert between(curve, 8 * DT, 5 * DT, DT).shape == (0, 3)


@pytest.mark.parametrize("laps", [1, 2, 3])
def test_the_last_laps_end_where_the_time_is(laps):
    """Row by row: the lap before the event ends with the tick before it."""
    curve = np.arange(1000.0)
    assert np.array_equal(last_cycles(curve, 0.7, 0.2, DT, laps=laps), np.arange(700.0 - 200.0 * laps, 700.0))


@pytest.mark.parametrize("lap", [0.8, math.inf])
def test_a_curve_that_does_not_reach_back_has_no_lap(lap):
    """Half a lap would be a median of the easier half."""
    assert len(last_cycles(np.ones(1000), 0.7, lap, DT)) == 0
    assert len(last_cycles(np.ones(1000), math.inf, 0.6, DT, laps=2)) == 0


@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.integers(1, 200))
def test_an_average_is_the_mean_of_what_its_window_holds(seed, width, rows):
    """Recomputed sample by sample, ends included."""
    curve = np.random.default_rng(seed).normal(size=rows)
    starts = np.arange(rows) - width // 2
    expected = [curve[max(0, a) : min(rows, a + width)].mean() for a in starts]
    assert moving_average(curve, width * DT, DT) == pytest.approx(expected, abs=1e-12)


def test_an_average_narrower_than_a_tick_is_the_curve_itself():
    """A trace of every fiftieth tick has no 20 ms in it."""
    curve = np.array([1.0, 5.0, 2.0])
    assert moving_average(curve, 0.02, 0.05).tolist() == [1.0, 5.0, 2.0]
    assert len(moving_average(curve[:0], 0.02, DT)) == 0


def test_an_average_takes_no_step_ahead_of_its_time():
    """It is centred: half of a step's rise lies before the step, half behind it."""
    step = np.repeat([0.0, 1.0], 500)
    smooth = moving_average(step, 0.02, DT)
    assert smooth[500 - 11] == 0.0 and smooth[500 + 10] == 1.0
    assert smooth[500] == pytest.approx(0.5, abs=0.051)


@given(st.lists(st.booleans(), min_size=1, max_size=300), st.integers(1, 20))
def test_a_stay_is_the_first_run_that_is_long_enough(inside, dwell):
    """Recomputed by looking at every place."""
    needed = dwell + 1
    places = [i for i in range(len(inside) - needed + 1) if all(inside[i : i + needed])]
    found = first_stay(np.array(inside), DT, dwell=dwell * DT)
    if len(inside) < needed:
        assert math.isnan(found)
    elif places:
        assert found == pytest.approx(places[0] * DT)
    else:
        assert isinstance(found, Censored) and found == math.inf


def test_both_ends_of_a_stay_are_inside():
    """Half a second is 501 samples of a millisecond: a sample less is no half second."""
    inside = np.zeros(2000, dtype=bool)
    inside[700:1200] = True
    assert math.isinf(first_stay(inside, DT))
    inside[1200] = True
    assert first_stay(inside, DT) == pytest.approx(0.7)


def test_peaks_nearer_than_a_tenth_of_a_second_are_one():
    """A spike on a hill is no second overshoot."""
    near, far = (bump(0.5, width=0.02) + bump(0.5 + gap, 0.9, width=0.02) for gap in (0.08, 0.2))
    assert count_peaks(near, 0.15, DT) == 1.0
    assert count_peaks(far, 0.15, DT) == 2.0


@given(st.floats(0.01, 100.0))
def test_the_count_of_peaks_does_not_depend_on_the_unit(factor):
    """Prominence is a share of the largest: radians or degrees, three hills are three."""
    curve = bump(0.3) + bump(0.9, 0.6) + bump(1.6, 0.3)
    assert count_peaks(factor * curve, 0.15, DT) == count_peaks(curve, 0.15, DT) == 3.0
    assert count_raw_peaks(factor * curve + 5.0 * factor, 0.15, DT) == 3.0


def test_an_undershoot_is_a_peak_of_the_excess_as_well():
    """The excess is counted by its size: an arm that does better for a moment has moved all the same."""
    curve = bump(0.3) - bump(0.9, 0.8)
    assert count_peaks(curve, 0.15, DT) == 2.0
    assert count_raw_peaks(curve, 0.15, DT) == 1.0


def test_a_motion_s_own_level_is_no_peak_of_the_error():
    """A constant has no range to take a share of."""
    assert count_raw_peaks(np.full(2500, 0.02), 0.15, DT) == 0.0
    assert count_peaks(np.zeros(2500), 0.15, DT) == 0.0


@pytest.mark.parametrize("count", [count_peaks, count_raw_peaks])
def test_nothing_has_no_count(count):
    """An event at the very end of a run has no samples after it: undefined, not zero peaks."""
    assert math.isnan(count(np.zeros(0), 0.15, DT))


@pytest.mark.parametrize("rows", [1, 7, 10, 25, 30])
def test_a_lap_repeated_backwards_ends_with_its_end(rows):
    """Sample k before the end of the curve is sample k before the end of the lap, as often as it fits."""
    lap = np.arange(10.0)
    found = phase_matched(lap, rows)
    assert len(found) == rows
    assert found[::-1].tolist() == [9.0 - k % 10 for k in range(rows)]
