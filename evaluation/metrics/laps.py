"""Whole laps of a log, and the error of each: who wins depends on how long one learns."""

import math
from itertools import pairwise

import numpy as np

from .geometry import rotation_angles


def lap_bounds(ticks: int, lap: float, dt: float) -> np.ndarray:
    """Return where the whole laps of a log begin and end.

    Args:
        ticks: Number of rows; row 0 is phase 0 of a lap.
        lap: Duration of one lap [s]; need not be a whole number of ticks.
        dt: Control period [s].

    Returns:
        Row indices, shape (laps + 1,); lap i holds the rows from entry i up to, not including, entry i + 1.
    """
    if not (math.isfinite(lap) and lap > 0.0):
        return np.zeros(1, dtype=int)
    # Half a tick of grace: neither rounding of the ratio nor a lap that ends between two ticks loses a lap.
    laps = math.floor((ticks + 0.5) * dt / lap)
    bounds: np.ndarray = np.rint(np.arange(laps + 1) * (lap / dt)).astype(int)
    return bounds.clip(max=ticks)


def last_lap(ticks: int, lap: float, dt: float) -> slice | None:
    """Return the rows of the last lap's length, None if the log is shorter than one lap.

    Args:
        ticks: Number of rows.
        lap: Duration of one lap [s].
        dt: Control period [s].
    """
    bounds = lap_bounds(ticks, lap, dt)
    return slice(ticks - int(bounds[1]), ticks) if len(bounds) > 1 else None


def last_rows(ticks: int, duration: float, dt: float) -> slice | None:
    """Return the rows of the last stretch of a log, None if the log is shorter.

    Args:
        ticks: Number of rows.
        duration: Duration of the stretch [s].
        dt: Control period [s].
    """
    count = max(round(duration / dt), 1)
    return slice(ticks - count, ticks) if ticks >= count else None


def error_by_lap(p: np.ndarray, p_ref: np.ndarray, lap: float, dt: float) -> np.ndarray:
    """Mean distance between tool point and reference in each whole lap.

    Args:
        p: Tool positions from phase 0 of the first lap, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        lap: Duration of one lap [s].
        dt: Control period [s].

    Returns:
        One mean for each whole lap, shape (laps,) [m]; NaN for a lap with a sample that is not finite.
    """
    return _mean_by_lap(np.linalg.norm(p_ref - p, axis=1), lap, dt)


def orientation_error_by_lap(quat: np.ndarray, quat_ref: np.ndarray, lap: float, dt: float) -> np.ndarray:
    """Mean angle between tool attitude and reference in each whole lap.

    Args:
        quat: Tool attitudes xyzw from phase 0 of the first lap, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).
        lap: Duration of one lap [s].
        dt: Control period [s].

    Returns:
        One mean for each whole lap, shape (laps,) [rad]; NaN for a lap with a sample that is not finite.
    """
    return _mean_by_lap(rotation_angles(quat, quat_ref), lap, dt)


def _mean_by_lap(error: np.ndarray, lap: float, dt: float) -> np.ndarray:
    bounds = lap_bounds(len(error), lap, dt)
    return np.array([error[start:stop].mean() for start, stop in pairwise(bounds)])
