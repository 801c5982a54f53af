"""Counting peaks: the count of a known curve, and how it depends on what is called a peak."""

import math

import numpy as np
import pytest
from torquebench.evaluation.metrics import (
    recovery_peaks_05,
    recovery_peaks_15,
    recovery_peaks_30,
    recovery_peaks_raw,
    recovery_peaks_raw_null,
    recovery_peaks_stable,
)
from torquebench.evaluation.metrics.curves import count_peaks, count_raw_peaks

DT = 1e-3
T = np.arange(2500) * DT


def gaussians():
    """Three bumps, each smaller and wider than the one before."""
    bumps = ((0.2, 0.05, 1.0), (0.6, 0.08, 0.6), (1.2, 0.1, 0.3))
    return sum(height * np.exp(-0.5 * ((T - centre) / width) ** 2) for centre, width, height in bumps)


@pytest.mark.parametrize(("share", "peaks"), [(0.05, 3), (0.15, 3), (0.25, 3), (0.4, 2), (0.7, 1)])
def test_three_bumps_are_three_peaks_until_they_are_too_small(share, peaks):
    assert count_peaks(gaussians(), share, DT) == peaks


def test_a_peak_at_the_event_itself_is_found():
    """Without a zero before it, a maximum at the first sample is no peak."""
    assert count_peaks(np.exp(-T / 0.4), 0.15, DT) == 1
    assert count_raw_peaks(np.exp(-T / 0.4), 0.15, DT) == 0


@pytest.mark.parametrize("share", [0.13, 0.17])
@pytest.mark.parametrize("damping", [0.1, 0.2, 0.4, 0.7])
def test_a_damped_oscillation_has_peaks_without_any_hierarchy(damping, share):
    """Half waves shrink by exp(-pi zeta / sqrt(1 - zeta^2)): 7, 4, 2, 1 of them, and no level of control anywhere."""
    omega, root = 12.6, math.sqrt(1.0 - damping**2)
    swing = np.exp(-damping * omega * T) * np.sin(omega * root * T)
    expected = 1 + math.floor(math.log(1.0 / share) * root / (math.pi * damping))
    assert count_peaks(swing, share, DT) == expected


def test_no_excess_has_no_peak():
    assert count_peaks(np.zeros(2500), 0.15, DT) == 0


def with_event(excess):
    base = 0.02 + 0.01 * np.sin(2.0 * np.pi * np.arange(6000) * DT)
    error = base.copy()
    error[2000:4500] += excess
    return error, base


def test_the_excess_is_counted_not_the_motion():
    """The motion's own waves cancel against the twin; in the error itself they count."""
    error, base = with_event(0.05 * gaussians())
    assert recovery_peaks_15(error, base, 2.0, 6.0, DT) == 3
    assert recovery_peaks_30(error, base, 2.0, 6.0, DT) == 2
    assert recovery_peaks_raw_null(base, 2.0, 6.0, DT) == recovery_peaks_raw(base, 2.0, 6.0, DT) == 3


def test_a_count_that_depends_on_the_prominence_is_none():
    error, base = with_event(gaussians())
    assert recovery_peaks_stable(error, base, 2.0, 6.0, DT) == 3
    third = 0.14 * np.exp(-0.5 * ((T - 1.2) / 0.1) ** 2)
    error, base = with_event(np.exp(-0.5 * ((T - 0.2) / 0.05) ** 2) + third)
    assert recovery_peaks_05(error, base, 2.0, 6.0, DT) == 2
    assert math.isnan(recovery_peaks_stable(error, base, 2.0, 6.0, DT))


def test_peaks_beyond_the_window_or_the_next_event_do_not_count():
    error, base = with_event(gaussians())
    assert recovery_peaks_15(error, base, 2.0, 2.9, DT) == 2
    assert math.isnan(recovery_peaks_15(error, base, 9.0, 9.5, DT))
