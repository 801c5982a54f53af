"""Pieces of error curves around a load event, which the resilience metrics reduce to numbers."""

import math

import numpy as np

from .registry import UNDEFINED, Censored

TICK = 1e-3
"""What a recovery in no time at all counts as in ratios: one control period, for nobody looked between two [s]."""
DWELL = 0.5
"""How long an error must stay small to count as recovered [s]."""
PEAK_WINDOW = 2.5
"""How long after an event its peaks are looked for [s]."""


def row_at(time: float, dt: float, rows: int) -> int:
    """Return the row of a time, at most the number of rows; an event acts from its row on.

    Args:
        time: Time since row 0 [s]; may be infinite.
        dt: Time between rows [s].
        rows: Number of rows.
    """
    return min(max(math.ceil(time / dt - 0.5), 0), rows) if math.isfinite(time) else rows


def between(curve: np.ndarray, start: float, stop: float, dt: float) -> np.ndarray:
    """Return the part of a curve from one time up to, not including, another.

    Args:
        curve: Shape (N, ...).
        start: First time [s].
        stop: Time of the first row that is left out [s]; may be infinite.
        dt: Time between rows [s].
    """
    return curve[row_at(start, dt, len(curve)) : row_at(stop, dt, len(curve))]


def last_cycles(curve: np.ndarray, stop: float, lap: float, dt: float, laps: int = 1) -> np.ndarray:
    """Return the last whole laps of a curve before a time, empty if it does not reach back so far.

    Args:
        curve: Shape (N,).
        stop: Time of the first row that is left out [s]; may be infinite.
        lap: Duration of one lap [s].
        dt: Time between rows [s].
        laps: How many.
    """
    end = row_at(stop, dt, len(curve))
    count = round(laps * lap / dt) if math.isfinite(lap) else end + 1
    return curve[end - count : end] if 0 < count <= end else curve[:0]


def moving_average(curve: np.ndarray, width: float, dt: float) -> np.ndarray:
    """Return the centred moving average of a curve; at its ends, of the part of the window that it has.

    Args:
        curve: Shape (N,).
        width: Duration of the window [s].
        dt: Time between rows [s].

    Returns:
        Shape (N,).
    """
    rows = max(1, round(width / dt))
    if rows == 1 or len(curve) == 0:
        return np.asarray(curve, dtype=float)
    places = np.arange(len(curve)) - rows // 2
    sums = np.concatenate([[0.0], np.cumsum(curve)])
    start, stop = places.clip(min=0), (places + rows).clip(max=len(curve))
    return np.asarray((sums[stop] - sums[start]) / (stop - start))


def first_stay(inside: np.ndarray, dt: float, dwell: float = DWELL) -> float:
    """Return the time from which a condition holds for as long as asked.

    Args:
        inside: Whether it holds, from the event to the next one, shape (N,).
        dt: Time between rows [s].
        dwell: How long it must hold, both ends included [s].

    Returns:
        The time since row 0 [s]; infinite and censored if it never holds so long, undefined if there is no time to.
    """
    rows = round(dwell / dt) + 1
    if len(inside) < rows:
        return UNDEFINED
    # A run of rows is inside if as many are inside as it has rows.
    counts = np.concatenate([[0], np.cumsum(inside)])
    starts = np.flatnonzero(counts[rows:] - counts[:-rows] == rows)
    return float(starts[0] * dt) if len(starts) else Censored(math.inf)


def count_peaks(curve: np.ndarray, share: float, dt: float) -> float:
    """Count the peaks of an excess that starts from nothing.

    A zero is put before the curve: a maximum at its first sample would not be found otherwise.

    Args:
        curve: The excess from the event on, any sign, shape (N,).
        share: Least prominence of a peak, as a share of the largest value.
        dt: Time between rows [s].

    Returns:
        How many peaks the 20 ms moving average of the magnitude has, at least 0.1 s apart; undefined without a sample.
    """
    if len(curve) == 0:
        return UNDEFINED
    smooth = moving_average(np.abs(curve), 0.02, dt)
    return _peaks(np.concatenate([[0.0], smooth]), share * float(smooth.max()), dt)


def count_raw_peaks(curve: np.ndarray, share: float, dt: float) -> float:
    """Count the peaks of an error curve itself, which does not start from nothing.

    Args:
        curve: The error from the event on, shape (N,).
        share: Least prominence of a peak, as a share of the curve's range.
        dt: Time between rows [s].

    Returns:
        How many peaks its 20 ms moving average has, at least 0.1 s apart; undefined without a sample.
    """
    if len(curve) == 0:
        return UNDEFINED
    smooth = moving_average(curve, 0.02, dt)
    return _peaks(smooth, share * float(np.ptp(smooth)), dt)


def _peaks(curve: np.ndarray, prominence: float, dt: float) -> float:
    from scipy.signal import find_peaks

    places, _ = find_peaks(curve, prominence=max(prominence, np.finfo(float).tiny), distance=max(1.0, 0.1 / dt))
    return float(len(places))
