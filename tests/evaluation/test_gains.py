"""Gains and laps: what may not change a correlation, where laps begin, and means that are recomputed lap by lap."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics import (
    gain_correlation,
    gain_correlation_by_joint,
    gain_correlation_within_laps,
    gain_variation,
    less_lap_mean,
)
from torquebench.evaluation.metrics.laps import error_by_lap, lap_bounds, last_lap, orientation_error_by_lap

DT = 1e-2
SEEDS = st.integers(0, 2**32 - 1)


def gains(seed, joints=5, rows=300):
    """Stiffness and damping of an arm that share a part of their movement."""
    rng = np.random.default_rng(seed)
    common = rng.normal(size=(rows, joints))
    return 200.0 + 5.0 * common, 20.0 + common + rng.normal(size=(rows, joints))


@given(SEEDS)
def test_a_correlation_is_numpy_s(seed):
    """Joint by joint, and the median of them."""
    stiffness, damping = gains(seed)
    expected = [np.corrcoef(stiffness[:, j], damping[:, j])[0, 1] for j in range(5)]
    assert gain_correlation_by_joint(stiffness, damping) == pytest.approx(expected, abs=1e-10)
    assert gain_correlation(stiffness, damping) == pytest.approx(np.median(expected), abs=1e-10)


@given(SEEDS, st.floats(0.01, 100.0), st.floats(-1e3, 1e3))
def test_a_correlation_knows_neither_unit_nor_offset(seed, factor, offset):
    """Newton metres by radian or by degree; a negative factor turns its sign."""
    stiffness, damping = gains(seed)
    found = gain_correlation(stiffness, damping)
    assert gain_correlation(factor * stiffness + offset, damping) == pytest.approx(found, abs=1e-8)
    assert gain_correlation_by_joint(-stiffness, damping) == pytest.approx(
        -gain_correlation_by_joint(stiffness, damping)
    )


@given(SEEDS)
def test_a_correlation_does_not_say_which_gain_came_first(seed):
    """Exchanged, it is the same."""
    stiffness, damping = gains(seed)
    assert gain_correlation(stiffness, damping) == pytest.approx(gain_correlation(damping, stiffness))


@given(SEEDS, st.lists(st.floats(-100.0, 100.0), min_size=3, max_size=3))
def test_what_is_added_from_lap_to_lap_is_no_part_of_it_within_laps(seed, steps):
    """The drift of a controller that is still learning, whatever its size, is taken out exactly."""
    stiffness, damping = gains(seed)
    drift = np.repeat(steps, 100)[:, None]
    found = gain_correlation_within_laps(stiffness, damping, 1.0, DT)
    assert gain_correlation_within_laps(stiffness + drift, damping - drift, 1.0, DT) == pytest.approx(found, abs=1e-8)


@given(SEEDS, st.integers(100, 299))
def test_a_lap_that_is_not_finished_is_no_part_of_it_either(seed, rows):
    """Its mean is one of other phases."""
    stiffness, damping = gains(seed)
    whole = 100 * (rows // 100)
    cut = gain_correlation_within_laps(stiffness[:rows], damping[:rows], 1.0, DT)
    assert cut == gain_correlation_within_laps(stiffness[:whole], damping[:whole], 1.0, DT)


def test_without_a_whole_lap_there_is_nothing_within_laps():
    """Undefined, not zero."""
    stiffness, damping = gains(1)
    assert math.isnan(gain_correlation_within_laps(stiffness, damping, 4.0, DT))
    assert math.isnan(gain_correlation_within_laps(stiffness, damping, math.inf, DT))


@given(SEEDS)
def test_every_lap_has_no_mean_left(seed):
    """And the differences within it are what they were."""
    series, _ = gains(seed)
    left = less_lap_mean(series, 1.0, DT)
    assert left.reshape(3, 100, 5).mean(axis=1) == pytest.approx(np.zeros((3, 5)), abs=1e-10)
    assert np.diff(left[:100], axis=0) == pytest.approx(np.diff(series[:100], axis=0), abs=1e-9)


def test_a_joint_at_its_clamp_does_not_decide_the_median():
    """Six joints of seven may stand still: the one that moves is the answer."""
    t = np.arange(300) * DT
    stiffness = np.full((300, 7), 200.0)
    stiffness[:, 3] += np.sin(t)
    assert gain_correlation(stiffness, stiffness.copy()) == pytest.approx(1.0)
    assert gain_variation(stiffness) == 0.0


@pytest.mark.parametrize("amplitude", [0.0, 0.1, 0.5])
def test_a_sine_varies_by_its_amplitude_over_the_root_of_two(amplitude):
    """Of its mean, at any number of whole periods."""
    t = np.arange(400) * DT
    stiffness = 200.0 * (1.0 + amplitude * np.sin(2.0 * np.pi * t))[:, None]
    assert gain_variation(stiffness) == pytest.approx(amplitude / math.sqrt(2.0))
    assert gain_variation(-stiffness) == pytest.approx(amplitude / math.sqrt(2.0))


def test_gains_that_are_all_zero_have_no_variation_to_speak_of():
    """A share of nothing."""
    assert math.isnan(gain_variation(np.zeros((10, 3))))


@given(st.integers(1, 6), st.floats(0.5, 3.0))
def test_laps_follow_each_other_without_a_gap_and_none_is_longer_by_more_than_a_tick(laps, lap):
    """A lap need not be a whole number of ticks; over a run the rounding does not add up."""
    ticks = round(laps * lap / DT)
    bounds = lap_bounds(ticks, lap, DT)
    assert len(bounds) == laps + 1
    assert bounds[0] == 0 and bounds[-1] <= ticks <= bounds[-1] + 1
    assert np.all(np.abs(np.diff(bounds) - lap / DT) <= 1.0)
    assert np.abs(bounds - np.arange(laps + 1) * lap / DT).max() <= 0.5 + 1e-6


@pytest.mark.parametrize("lap", [0.0, -1.0, math.inf, math.nan])
def test_a_motion_without_a_lap_has_none(lap):
    """One bound, no lap; nothing is divided by zero."""
    assert lap_bounds(500, lap, DT).tolist() == [0]
    assert last_lap(500, lap, DT) is None


@pytest.mark.parametrize(("ticks", "rows"), [(300, (200, 300)), (350, (250, 350)), (100, (0, 100)), (99, None)])
def test_the_last_lap_is_a_lap_s_length_that_ends_with_the_log(ticks, rows):
    """Also of a log that goes on for half a lap: what it ends with is what it has reached."""
    found = last_lap(ticks, 1.0, DT)
    assert found == (None if rows is None else slice(*rows))


def test_errors_by_lap_are_the_means_of_their_laps():
    """A millimetre more in each lap, in any direction; the unfinished lap is left out."""
    p_ref = np.random.default_rng(0).normal(size=(350, 3))
    distance = 1e-3 * (1.0 + np.arange(350) // 100)
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    found = error_by_lap(p_ref + distance[:, None] * direction, p_ref, 1.0, DT)
    assert found == pytest.approx([1e-3, 2e-3, 3e-3])
    assert len(error_by_lap(p_ref[:50], p_ref[:50], 1.0, DT)) == 0


def test_attitude_errors_by_lap_are_the_angles_of_their_laps():
    """A turn about one axis by 10 mrad in the first lap and 30 in the second; q and -q are one attitude."""
    angle = np.repeat([0.01, 0.03], 100)
    half = 0.5 * angle
    quat = np.stack([np.zeros(200), np.sin(half), np.zeros(200), np.cos(half)], axis=1)
    quat[::3] *= -1.0
    upright = np.tile([0.0, 0.0, 0.0, 1.0], (200, 1))
    assert orientation_error_by_lap(quat, upright, 1.0, DT) == pytest.approx([0.01, 0.03])


def test_a_sample_that_is_not_finite_costs_its_own_lap():
    """The other laps keep their means."""
    p = np.zeros((300, 3))
    p[150, 1] = np.nan
    found = error_by_lap(p, np.zeros_like(p), 1.0, DT)
    assert found[[0, 2]].tolist() == [0.0, 0.0] and math.isnan(found[1])
