"""How many peaks the error shows after a load event: a count that depends on what is called a peak."""

from functools import partial

import numpy as np

from .curves import PEAK_WINDOW, between, count_peaks, count_raw_peaks
from .registry import UNDEFINED, metric, variant

PROMINENCES = (0.05, 0.10, 0.15, 0.20, 0.30)
"""Least prominences at which peaks are counted, as shares of the largest excess."""
STABLE = (0.10, 0.15, 0.20)
"""Where the count must not change to be called one."""


def _count(share: float, error: np.ndarray, error_old: np.ndarray, event: float, until: float, dt: float) -> float:
    return count_peaks(between(error - error_old, event, min(until, event + PEAK_WINDOW), dt), share, dt)


@metric(
    unit="-",
    better="none",
    family="resilience",
    needs=("error", "error_old", "event", "until", "dt"),
    source="peaks of |excess over the old load's twin| within 2.5 s, 20 ms average, prominence 5 %, 0.1 s apart",
    label="peaks (prominence 5 %)",
    kind="twins",
)
def recovery_peaks_05(error: np.ndarray, error_old: np.ndarray, event: float, until: float, dt: float) -> float:
    """Number of peaks of the excess in the 2.5 s after an event.

    A damped oscillation alone has several: only the difference between two controllers at one prominence says
    anything, and only if :func:`recovery_peaks_stable` has a value.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_old: The same of the twin whose event never happens, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        dt: Control period [s].

    Returns:
        The count [1]; NaN if a sample is not finite or none follows the event.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    return _count(0.05, error, error_old, event, until, dt)


recovery_peaks_10 = variant(
    recovery_peaks_05, "recovery_peaks_10", "peaks (prominence 10 %)", function=partial(_count, 0.10)
)
recovery_peaks_15 = variant(
    recovery_peaks_05, "recovery_peaks_15", "peaks (prominence 15 %)", function=partial(_count, 0.15)
)
recovery_peaks_20 = variant(
    recovery_peaks_05, "recovery_peaks_20", "peaks (prominence 20 %)", function=partial(_count, 0.20)
)
recovery_peaks_30 = variant(
    recovery_peaks_05, "recovery_peaks_30", "peaks (prominence 30 %)", function=partial(_count, 0.30)
)


@metric(
    unit="-",
    better="none",
    family="resilience",
    needs=("error", "error_old", "event", "until", "dt"),
    source="the count, if it is the same at prominences of 10, 15 and 20 %",
    label="peaks, if the count is stable",
    kind="twins",
)
def recovery_peaks_stable(error: np.ndarray, error_old: np.ndarray, event: float, until: float, dt: float) -> float:
    """Number of peaks of the excess, if it does not depend on what is called a peak.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_old: The same of the twin whose event never happens, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        dt: Control period [s].

    Returns:
        The count [1]; NaN if a sample is not finite, none follows the event, or prominences of 10, 15 and 20 % give
        different counts.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    counts = {_count(share, error, error_old, event, until, dt) for share in STABLE}
    return counts.pop() if len(counts) == 1 else UNDEFINED


@metric(
    unit="-",
    better="none",
    family="resilience",
    needs=("error", "event", "until", "dt"),
    source="paper's panels; peaks of the error itself within 2.5 s, 20 ms average, prominence 15 % of its range",
    label="peaks of the error itself",
    kind="twins",
)
def recovery_peaks_raw(error: np.ndarray, event: float, until: float, dt: float) -> float:
    """Number of peaks of the error itself in the 2.5 s after an event, as the paper counts.

    A motion has peaks of its own: read it only beside :func:`recovery_peaks_raw_null`.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        dt: Control period [s].

    Returns:
        The count [1]; NaN if a sample is not finite or none follows the event.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return count_raw_peaks(between(error, event, min(until, event + PEAK_WINDOW), dt), 0.15, dt)


recovery_peaks_raw_null = variant(
    recovery_peaks_raw,
    "recovery_peaks_raw_null",
    "peaks of the error without any event",
    needs=("error_old", "event", "until", "dt"),
)
