"""How long an arm needs to recover from a load event, judged against its twins."""

import math
from functools import partial

import numpy as np

from .curves import TICK, between, first_stay, last_cycles
from .registry import UNDEFINED, metric, variant

NEEDS = ("error", "error_old", "error_new", "event", "until", "lap", "dt")
POSITION = ("position_error", "position_error_old", "position_error_new", "event", "until", "lap", "dt")
SMALLEST_THRESHOLD = 1e-4
"""Errors below this count as none, however well the arm tracked before [rad, m]."""


def recovery_threshold(error_old: np.ndarray, event: float, lap: float, dt: float, share: float) -> float:
    """Return how much excess counts as recovered: a share of the median error of the last lap before the event.

    Args:
        error_old: Norm of the error with the old load, shape (N,) [rad].
        event: Time of the event [s].
        lap: Duration of one lap [s].
        dt: Time between rows [s].
        share: Which share of the median.

    Returns:
        The threshold, at least 1e-4; NaN if there is no whole lap before the event.
    """
    before = last_cycles(error_old, event, lap, dt)
    return max(share * float(np.median(before)), SMALLEST_THRESHOLD) if len(before) else math.nan


def _settled(
    share: float,
    error: np.ndarray,
    error_old: np.ndarray,
    error_new: np.ndarray,
    event: float,
    until: float,
    lap: float,
    dt: float,
) -> float:
    threshold = recovery_threshold(error_old, event, lap, dt, share)
    excess = between(error - error_new, event, until, dt)
    return UNDEFINED if math.isnan(threshold) else first_stay(np.abs(excess) <= threshold, dt)


@metric(
    unit="s",
    better="lower",
    family="resilience",
    needs=NEEDS,
    source="excess over the new load's twin at most 25 % of the error before, for 0.5 s",
    label="recovery, settled (25 %)",
    kind="twins",
    resolution=TICK,
)
def recovery_time_settled(
    error: np.ndarray,
    error_old: np.ndarray,
    error_new: np.ndarray,
    event: float,
    until: float,
    lap: float,
    dt: float,
) -> float:
    r"""Time from an event until the error is what it would be had the new load always been there.

    .. math:: |e - e_\mathrm{new}| \le \max(0.25 \, \mathrm{median}(e_\mathrm{old}), 10^{-4}) \text{ for } 0.5\,s

    The median is that of the last lap before the event. A controller that never compensates a load settles at once:
    read it only beside :func:`residual_excess` and the error itself.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_old: The same of the twin whose event never happens, shape (N,) [rad].
        error_new: The same of the twin that carries the new load from the start, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        lap: Duration of one lap [s].
        dt: Control period [s].

    Returns:
        The time [s]; infinite and censored if it does not recover before the next event; NaN if a sample is not
        finite, there is no whole lap before the event, or less than 0.5 s after it.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    return _settled(0.25, error, error_old, error_new, event, until, lap, dt)


recovery_time_settled_10 = variant(
    recovery_time_settled, "recovery_time_settled_10", "recovery, settled (10 %)", function=partial(_settled, 0.10)
)
recovery_time_settled_50 = variant(
    recovery_time_settled, "recovery_time_settled_50", "recovery, settled (50 %)", function=partial(_settled, 0.50)
)
recovery_time_settled_position = variant(
    recovery_time_settled,
    "recovery_time_settled_position",
    "recovery of the tool point, settled (25 %)",
    needs=POSITION,
    quantity=("rad", "m"),
)


@metric(
    unit="s",
    better="lower",
    family="resilience",
    needs=("error", "error_old", "event", "until", "lap", "dt"),
    source="excess over the old load's twin at most 25 % of the error before, for 0.5 s",
    label="recovery, as if nothing had happened",
    kind="twins",
    resolution=TICK,
)
def recovery_time_nominal(
    error: np.ndarray, error_old: np.ndarray, event: float, until: float, lap: float, dt: float
) -> float:
    """Time from an event until the error is as if nothing had happened.

    The threshold is that of :func:`recovery_time_settled`. It never comes if the new load costs more for good.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_old: The same of the twin whose event never happens, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        lap: Duration of one lap [s].
        dt: Control period [s].

    Returns:
        The time [s]; infinite and censored if it does not recover before the next event; NaN if a sample is not
        finite, there is no whole lap before the event, or less than 0.5 s after it.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    return _settled(0.25, error, error_old, error_old, event, until, lap, dt)


recovery_time_nominal_position = variant(
    recovery_time_nominal,
    "recovery_time_nominal_position",
    "recovery of the tool point, as if nothing had happened",
    needs=("position_error", "position_error_old", "event", "until", "lap", "dt"),
    quantity=("rad", "m"),
)
