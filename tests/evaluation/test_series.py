"""Recovery from mean curves: the paper's reading and the rule of the cycle band, on curves of known shape."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation import EmptyWindow
from torquebench.evaluation.metrics import (
    error_peak_raw,
    improvement_rate,
    last_cycle_error,
    recovery_time_cycle_band,
    recovery_time_paper_style,
)

LAP = 3.0


def curves(dt, size=0.05, decay=0.4, level=0.02, wave=0.004):
    """Three trajectories over 24 s with a wave in every lap, an exponential at 12 s, each path of its own size."""
    t = np.arange(round(24.0 / dt)) * dt
    error = level + wave * np.sin(2.0 * np.pi * t / LAP)
    error = error + np.where(t >= 12.0 - dt / 2, size * np.exp(-(t - 12.0) / decay), 0.0)
    return np.array([0.8, 1.0, 1.2])[:, None] * error


@pytest.mark.parametrize("dt", [1e-3, 1e-2])
def test_the_cycle_band_is_a_fifth_of_the_peak(dt):
    """An exponential is at a fifth of its peak after tau ln 5, whatever the motion's own wave does."""
    recovery = recovery_time_cycle_band(curves(dt), 12.0, math.inf, LAP, dt)
    assert recovery == pytest.approx(0.4 * math.log(5.0), abs=0.06)


def test_the_cycle_band_is_never_narrower_than_five_milliradians():
    assert recovery_time_cycle_band(curves(1e-2, size=0.004), 12.0, math.inf, LAP, 1e-2) == 0.0
    small = recovery_time_cycle_band(curves(1e-2, size=0.02), 12.0, math.inf, LAP, 1e-2)
    assert small == pytest.approx(0.4 * math.log(4.0), abs=0.06)


def test_a_late_excursion_counts():
    """Stays below means until the next event."""
    errors = curves(1e-2)
    errors[:, 1800:1810] += 0.05
    assert recovery_time_cycle_band(errors, 12.0, math.inf, LAP, 1e-2) > 6.0


@pytest.mark.parametrize("dt", [1e-3, 1e-2])
def test_paper_style_is_the_entry_into_the_band_of_the_last_laps(dt):
    """Ten per cent around 20 mrad: the exponential of 50 mrad is inside after tau ln 25."""
    errors = curves(dt, wave=0.0)
    recovery = recovery_time_paper_style(errors, 12.0, math.inf, LAP, dt)
    assert recovery == pytest.approx(0.4 * math.log(25.0), abs=0.06)


def test_paper_style_needs_two_laps_and_finds_recovery_by_construction():
    """However bad a controller is, it does at the end what it does at the end."""
    assert math.isnan(recovery_time_paper_style(curves(1e-2), 12.0, 17.0, LAP, 1e-2))
    rng = np.random.default_rng(1)
    assert recovery_time_paper_style(rng.uniform(0.0, 1.0, (3, 2400)), 0.0, 12.0, LAP, 1e-2) <= 6.0


def test_what_follows_the_next_event_is_not_seen():
    """Neither by a smoothing window nor by a cycle."""
    calm, shaken = curves(1e-2), curves(1e-2)
    shaken[:, 1200:] += 3.0
    for found in (recovery_time_cycle_band, recovery_time_paper_style, last_cycle_error):
        assert found(calm, 0.0, 12.0, LAP, 1e-2) == found(shaken, 0.0, 12.0, LAP, 1e-2)
    assert error_peak_raw(calm, 0.0, 12.0, 1e-2) == error_peak_raw(shaken, 0.0, 12.0, 1e-2)


def test_the_steady_error_is_that_of_the_last_lap():
    assert last_cycle_error(curves(1e-2), 0.0, 12.0, LAP, 1e-2) == pytest.approx(0.02)
    assert error_peak_raw(curves(1e-3, wave=0.0), 12.0, math.inf, 1e-3) == pytest.approx(0.07, rel=0.02)


def test_no_trajectory_is_an_error():
    with pytest.raises(EmptyWindow):
        last_cycle_error(np.zeros((0, 100)), 0.0, 1.0, 0.5, 1e-2)


@given(st.floats(0.2, 5.0))
def test_recovery_from_the_curves_does_not_depend_on_the_unit_of_a_large_error(factor):
    errors = curves(1e-2, size=0.5)
    same = recovery_time_paper_style(factor * errors, 12.0, math.inf, LAP, 1e-2)
    assert same == pytest.approx(recovery_time_paper_style(errors, 12.0, math.inf, LAP, 1e-2), abs=0.011)


def test_the_rate_of_improvement_is_the_slope_of_the_logarithm():
    """One event in six that went wrong does not turn the sign."""
    halves = 0.02 * 0.5 ** np.arange(6)
    assert improvement_rate(halves) == pytest.approx(-math.log(2.0))
    halves[3] *= 5.0
    assert improvement_rate(halves) < 0.0
    assert math.isnan(improvement_rate(halves[:2]))
    assert math.isnan(improvement_rate(np.array([0.1, 0.0, 0.1])))
