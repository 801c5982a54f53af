"""Recovery judged from the error curves of several runs, averaged over the trajectories as the paper does."""

import numpy as np

from .curves import TICK, between, first_stay, last_cycles, moving_average
from .registry import UNDEFINED, metric

WIDENED = 0.10
"""By how much the paper-style band is wider than what the curve does in its last two laps."""


def phase_matched(cycle: np.ndarray, rows: int) -> np.ndarray:
    """Repeat a lap backwards, so that its end meets the end of a longer curve.

    Args:
        cycle: One lap, shape (L,).
        rows: Length of the curve.

    Returns:
        Shape (rows,).
    """
    return np.asarray(cycle[(np.arange(rows) - rows) % len(cycle)])


@metric(
    unit="s",
    better="lower",
    family="resilience",
    needs=("errors", "event", "until", "lap", "dt"),
    source="a reading of the paper: the mean curve stays for 0.5 s in the 10 % wider band of its last two laps",
    label="recovery, paper style",
    kind="table",
    resolution=TICK,
)
def recovery_time_paper_style(errors: np.ndarray, event: float, until: float, lap: float, dt: float) -> float:
    """Time from an event until the mean error does what it does in its last two laps before the next event.

    The band is the smaller and the larger of those two laps at each phase, made 10 % wider. Recovery is found by
    construction, however large the error stays: read it only beside :func:`last_cycle_error`.

    Args:
        errors: Norms of the joint error from time 0, one row for each trajectory, shape (paths, N) [rad].
        event: Time of the event [s]; 0 for the start.
        until: Time of the next event, or where the runs end [s]; may be infinite.
        lap: Duration of one lap, the same on all trajectories [s].
        dt: Time between samples [s].

    Returns:
        The time [s]; infinite and censored if the curve never stays that long; NaN if a sample is not finite or there
        are no two laps.

    Raises:
        EmptyWindow: If there is no trajectory.
    """
    curve = moving_average(between(errors.mean(axis=0), event, until, dt), 0.05, dt)
    two = last_cycles(curve, len(curve) * dt, lap, dt, laps=2)
    if len(two) == 0:
        return UNDEFINED
    first, second = two[: len(two) // 2], two[len(two) // 2 :]
    count = min(len(first), len(second))
    low = phase_matched(np.minimum(first[-count:], second[-count:]), len(curve)) * (1.0 - WIDENED)
    high = phase_matched(np.maximum(first[-count:], second[-count:]), len(curve)) * (1.0 + WIDENED)
    return first_stay((curve >= low) & (curve <= high), dt)


@metric(
    unit="s",
    better="lower",
    family="resilience",
    needs=("errors", "event", "until", "lap", "dt"),
    source="excess over the phase-matched last lap stays below max(20 % of its peak, 5 mrad); 100 ms average",
    label="recovery, cycle band (sigma was fitted with this)",
    kind="table",
    resolution=TICK,
)
def recovery_time_cycle_band(errors: np.ndarray, event: float, until: float, lap: float, dt: float) -> float:
    """Time from an event until the mean error stays near its last lap before the next event.

    The band is 20 % of the peak excess, at least 5 mrad. The one constant of the spiking controller's learning rule
    was fitted with this number, so for that controller it predicts nothing.

    Args:
        errors: Norms of the joint error from time 0, one row for each trajectory, shape (paths, N) [rad].
        event: Time of the event [s]; 0 for the start.
        until: Time of the next event, or where the runs end [s]; may be infinite.
        lap: Duration of one lap, the same on all trajectories [s].
        dt: Time between samples [s].

    Returns:
        The time [s], 0 if the excess is never beyond the band; NaN if a sample is not finite or there is no lap.

    Raises:
        EmptyWindow: If there is no trajectory.
    """
    curve = moving_average(between(errors.mean(axis=0), event, until, dt), 0.1, dt)
    cycle = last_cycles(curve, len(curve) * dt, lap, dt)
    if len(cycle) == 0:
        return UNDEFINED
    excess = curve - phase_matched(cycle, len(curve))
    beyond = np.flatnonzero(excess >= max(0.2 * float(excess.max()), 5e-3))
    return float((beyond[-1] + 1) * dt) if len(beyond) else 0.0


@metric(
    unit="rad",
    better="lower",
    family="resilience",
    needs=("errors", "event", "until", "dt"),
    source="largest mean error until the next event; 20 ms average",
    label="peak of the mean error",
    kind="table",
)
def error_peak_raw(errors: np.ndarray, event: float, until: float, dt: float) -> float:
    """Largest error between an event and the next one, averaged over the trajectories; no excess, the error itself.

    Args:
        errors: Norms of the joint error from time 0, one row for each trajectory, shape (paths, N) [rad].
        event: Time of the event [s]; 0 for the start.
        until: Time of the next event, or where the runs end [s]; may be infinite.
        dt: Time between samples [s].

    Returns:
        The peak of the 20 ms moving average [rad]; NaN if a sample is not finite or none follows the event.

    Raises:
        EmptyWindow: If there is no trajectory.
    """
    curve = moving_average(between(errors.mean(axis=0), event, until, dt), 0.02, dt)
    return float(curve.max()) if len(curve) else UNDEFINED


@metric(
    unit="rad",
    better="lower",
    family="resilience",
    needs=("errors", "event", "until", "lap", "dt"),
    source="mean error of the last lap before the next event",
    label="mean error, last lap before the next event",
    kind="table",
)
def last_cycle_error(errors: np.ndarray, event: float, until: float, lap: float, dt: float) -> float:
    """Mean error in the last lap before the next event: what a recovery arrives at.

    Args:
        errors: Norms of the joint error from time 0, one row for each trajectory, shape (paths, N) [rad].
        event: Time of the event [s]; 0 for the start.
        until: Time of the next event, or where the runs end [s]; may be infinite.
        lap: Duration of one lap, the same on all trajectories [s].
        dt: Time between samples [s].

    Returns:
        The mean [rad]; NaN if a sample is not finite or there is no lap.

    Raises:
        EmptyWindow: If there is no trajectory.
    """
    segment = between(errors.mean(axis=0), event, until, dt)
    cycle = last_cycles(segment, len(segment) * dt, lap, dt)
    return float(cycle.mean()) if len(cycle) else UNDEFINED


@metric(
    unit="1",
    better="lower",
    family="resilience",
    needs=("excess_integrals",),
    source="Theil-Sen slope of ln(integrated excess) against the number of the event",
    label="improvement from event to event",
    kind="table",
)
def improvement_rate(excess_integrals: np.ndarray) -> float:
    """How fast the cost of the same event shrinks with its repetition.

    Args:
        excess_integrals: Integrated excess of identical events at the same phase, in order, shape (events,) [rad s].

    Returns:
        The slope of the logarithm by event [1], negative if the arm improves; NaN if a sample is not finite, there
        are fewer than three events, or one of them cost nothing.

    Raises:
        EmptyWindow: If there is no event.
    """
    from scipy.stats import theilslopes

    if len(excess_integrals) < 3 or not (excess_integrals > 0.0).all():
        return UNDEFINED
    return float(theilslopes(np.log(excess_integrals)).slope)
