"""Path velocity in the style of ISO 9283:1998, 8.6; only where the plan's speed is constant. A cycle is a whole lap."""

from itertools import pairwise

import numpy as np

from .laps import lap_bounds
from .registry import UNDEFINED, metric

CONSTANT_SPEED = 0.02
"""Largest departure of a plan's speed from its mean, as a share of it, that still counts as constant."""


def speeds_by_lap(twist: np.ndarray, twist_ref: np.ndarray, dt: float, lap: float) -> tuple[list[np.ndarray], float]:
    """Return the tool's speed in each whole lap, and the commanded speed.

    Args:
        twist: Tool twists from phase 0 of a lap, shape (N, 6) [m/s, rad/s].
        twist_ref: Reference twists of the same ticks, shape (N, 6) [m/s, rad/s].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        One array for each lap [m/s], none if the plan's speed is not constant; the plan's mean speed [m/s].
    """
    planned, speed = (np.linalg.norm(t[:, :3], axis=1) for t in (twist_ref, twist))
    mean = float(planned.mean())
    if mean <= 0.0 or np.abs(planned - mean).max() > CONSTANT_SPEED * mean:
        return [], mean
    return [speed[start:stop] for start, stop in pairwise(lap_bounds(len(speed), lap, dt))], mean


@metric(
    unit="%",
    better="lower",
    family="iso",
    needs=("twist", "twist_ref", "dt", "lap"),
    source="ISO 9283:1998, 8.6, AV",
    label="path velocity accuracy, ISO style",
)
def iso_velocity_accuracy(twist: np.ndarray, twist_ref: np.ndarray, dt: float, lap: float) -> float:
    """Mean speed of the tool less the commanded speed, in per cent of it; negative is too slow.

    Args:
        twist: Tool twists from phase 0 of a lap, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Reference twists of the same ticks, shape (N, 6) [m/s, rad/s].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The difference [%]; NaN if any sample is not finite, there is no whole lap, or the plan's speed varies by more
        than 2 %.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    laps, planned = speeds_by_lap(twist, twist_ref, dt, lap)
    return 100.0 * (float(np.mean([speed.mean() for speed in laps])) - planned) / planned if laps else UNDEFINED


@metric(
    unit="%",
    better="lower",
    family="iso",
    needs=("twist", "twist_ref", "dt", "lap"),
    source="ISO 9283:1998, 8.6, RV",
    label="path velocity repeatability, ISO style",
)
def iso_velocity_repeatability(twist: np.ndarray, twist_ref: np.ndarray, dt: float, lap: float) -> float:
    """Three standard deviations of the laps' mean speeds, in per cent of the commanded speed.

    Args:
        twist: Tool twists from phase 0 of a lap, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Reference twists of the same ticks, shape (N, 6) [m/s, rad/s].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The half-width [%]; NaN if any sample is not finite, there are no two laps, or the plan's speed varies by more
        than 2 %.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    laps, planned = speeds_by_lap(twist, twist_ref, dt, lap)
    return 300.0 * float(np.std([speed.mean() for speed in laps], ddof=1)) / planned if len(laps) > 1 else UNDEFINED


@metric(
    unit="m/s",
    better="lower",
    family="iso",
    needs=("twist", "twist_ref", "dt", "lap"),
    source="ISO 9283:1998, 8.6, FV",
    label="path velocity fluctuation, ISO style",
)
def iso_velocity_fluctuation(twist: np.ndarray, twist_ref: np.ndarray, dt: float, lap: float) -> float:
    """Largest difference, over the laps, between the highest and the lowest speed of the tool.

    Args:
        twist: Tool twists from phase 0 of a lap, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Reference twists of the same ticks, shape (N, 6) [m/s, rad/s].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The difference [m/s]; NaN if any sample is not finite, there is no whole lap, or the plan's speed varies by more
        than 2 %.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    laps, _ = speeds_by_lap(twist, twist_ref, dt, lap)
    return max(float(np.ptp(speed)) for speed in laps) if laps else UNDEFINED
