"""What a controller's calls cost: wall times, which belong to a machine and never stand among the results.

Time the update alone, on one thread, without garbage collection, and drop the first :data:`WARM_UP` calls.
"""

import numpy as np

from .registry import UNDEFINED, metric

WARM_UP = 500
"""Calls at the start of a run that fill caches and are not counted; a multiple of every stride below."""


def tick_times_by_stride(call_time: np.ndarray, strides: tuple[int, ...] = (1, 10, 50)) -> np.ndarray:
    """Median time of the calls in which just so many levels of a controller run.

    Args:
        call_time: Duration of each call, shape (N,) [s]; calls are counted from 1.
        strides: Periods of the levels in calls, each a multiple of the one before.

    Returns:
        For each stride the median of the calls that are its multiples and not the next one's, shape (strides,) [s];
        NaN without such a call.
    """
    number = np.arange(1, len(call_time) + 1)
    classes = np.max([np.where(number % stride == 0, stride, 0) for stride in strides], axis=0)
    found = [call_time[classes == stride] for stride in strides]
    return np.array([np.median(times) if len(times) else np.nan for times in found])


@metric(
    unit="s",
    better="lower",
    family="computing",
    needs=("call_time",),
    source="median",
    label="time of a call, median",
    kind="timing",
)
def tick_time_median(call_time: np.ndarray) -> float:
    """Median time of a call.

    Args:
        call_time: Duration of each call, shape (N,) [s].

    Returns:
        The median [s]; NaN if any is not finite.

    Raises:
        EmptyWindow: If there is no call.
    """
    return float(np.median(call_time))


@metric(
    unit="s",
    better="lower",
    family="computing",
    needs=("call_time",),
    source="99th percentile",
    label="time of a call, 99th percentile",
    kind="timing",
)
def tick_time_p99(call_time: np.ndarray) -> float:
    """Time that 99 % of the calls stay within (linear interpolation).

    A level that runs every 50th call is 2 % of all: the 95th percentile misses it, this one is its median.

    Args:
        call_time: Duration of each call, shape (N,) [s].

    Returns:
        The percentile [s]; NaN if any is not finite.

    Raises:
        EmptyWindow: If there is no call.
    """
    return float(np.percentile(call_time, 99.0))


@metric(
    unit="s",
    better="lower",
    family="computing",
    needs=("call_time",),
    source="99.9th percentile",
    label="time of a call, 99.9th percentile",
    kind="timing",
)
def tick_time_p999(call_time: np.ndarray) -> float:
    """Time that 99.9 % of the calls stay within (linear interpolation).

    Args:
        call_time: Duration of each call, shape (N,) [s].

    Returns:
        The percentile [s]; NaN if any is not finite.

    Raises:
        EmptyWindow: If there is no call.
    """
    return float(np.percentile(call_time, 99.9))


@metric(
    unit="s",
    better="lower",
    family="computing",
    needs=("call_time",),
    source="largest",
    label="time of a call, largest",
    kind="timing",
)
def tick_time_max(call_time: np.ndarray) -> float:
    """Longest call.

    Args:
        call_time: Duration of each call, shape (N,) [s].

    Returns:
        The maximum [s]; NaN if any is not finite.

    Raises:
        EmptyWindow: If there is no call.
    """
    return float(call_time.max())


@metric(
    unit="s",
    better="lower",
    family="computing",
    needs=("call_time",),
    source="median over every tenth call, less every fiftieth",
    label="time of a call that is a multiple of 10, median",
    kind="timing",
)
def tick_time_every_10(call_time: np.ndarray) -> float:
    """Median time of the calls 10, 20, 30, 40, 60 and so on: the second level of a controller at 1, 10 and 50 ticks.

    Args:
        call_time: Duration of each call, counted from 1, shape (N,) [s].

    Returns:
        The median [s]; NaN if any is not finite or there is no such call.

    Raises:
        EmptyWindow: If there is no call.
    """
    return float(tick_times_by_stride(call_time)[1])


@metric(
    unit="s",
    better="lower",
    family="computing",
    needs=("call_time",),
    source="median over every fiftieth call",
    label="time of a call that is a multiple of 50, median",
    kind="timing",
)
def tick_time_every_50(call_time: np.ndarray) -> float:
    """Median time of the calls 50, 100 and so on: all levels of a controller at 1, 10 and 50 ticks.

    Args:
        call_time: Duration of each call, counted from 1, shape (N,) [s].

    Returns:
        The median [s]; NaN if any is not finite or there is no such call.

    Raises:
        EmptyWindow: If there is no call.
    """
    return float(tick_times_by_stride(call_time)[2])


@metric(
    unit="1",
    better="lower",
    family="computing",
    needs=("call_time", "dt"),
    source="share of calls with call_time > dt",
    label="calls longer than the period",
    kind="timing",
)
def deadline_miss_fraction(call_time: np.ndarray, dt: float) -> float:
    """Share of the calls that took longer than a control period.

    Args:
        call_time: Duration of each call, shape (N,) [s].
        dt: Control period [s].

    Returns:
        The share [1]; NaN if any is not finite or the period is not.

    Raises:
        EmptyWindow: If there is no call.
    """
    return float((call_time > dt).mean()) if np.isfinite(dt) else UNDEFINED
