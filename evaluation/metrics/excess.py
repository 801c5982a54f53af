"""What a load event costs beyond the error that would have been there anyway."""

import numpy as np

from .curves import PEAK_WINDOW, between, last_cycles
from .registry import UNDEFINED, metric, variant


@metric(
    unit="rad",
    better="lower",
    family="resilience",
    needs=("error", "error_old", "event", "until", "lap", "dt"),
    source="mean excess over the old load's twin in the last lap before the next event",
    label="excess that never came back",
    kind="twins",
)
def residual_excess(
    error: np.ndarray, error_old: np.ndarray, event: float, until: float, lap: float, dt: float
) -> float:
    """Mean excess over the run without the event, in the last lap before the next one: what never came back.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_old: The same of the twin whose event never happens, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        lap: Duration of one lap [s].
        dt: Control period [s].

    Returns:
        The mean [rad], negative if the event did good; NaN if a sample is not finite or there is no whole lap.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    after = between(error - error_old, event, until, dt)
    cycle = last_cycles(after, len(after) * dt, lap, dt)
    return float(cycle.mean()) if len(cycle) else UNDEFINED


residual_excess_position = variant(
    residual_excess,
    "residual_excess_position",
    "excess of the tool point that never came back",
    needs=("position_error", "position_error_old", "event", "until", "lap", "dt"),
    quantity=("rad", "m"),
)


@metric(
    unit="rad s",
    better="lower",
    family="resilience",
    needs=("error", "error_new", "event", "until", "dt"),
    source="sum of |excess over the new load's twin| dt until the next event",
    label="excess, integrated",
    kind="twins",
)
def excess_integral(error: np.ndarray, error_new: np.ndarray, event: float, until: float, dt: float) -> float:
    """Integral of the excess over the run that always had the new load, from the event to the next one.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_new: The same of the twin that carries the new load from the start, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        dt: Control period [s].

    Returns:
        The sum of magnitudes times the period [rad s]; NaN if a sample is not finite or none follows the event.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    excess = between(error - error_new, event, until, dt)
    return float(np.abs(excess).sum() * dt) if len(excess) else UNDEFINED


excess_integral_position = variant(
    excess_integral,
    "excess_integral_position",
    "excess of the tool point, integrated",
    needs=("position_error", "position_error_new", "event", "until", "dt"),
    quantity=("rad", "m"),
)


@metric(
    unit="rad",
    better="lower",
    family="resilience",
    needs=("error", "error_old", "event", "until", "dt"),
    source="largest excess over the old load's twin within 2.5 s",
    label="excess, peak",
    kind="twins",
)
def excess_peak(error: np.ndarray, error_old: np.ndarray, event: float, until: float, dt: float) -> float:
    """Largest excess over the run without the event, in the 2.5 s after it.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_old: The same of the twin whose event never happens, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        dt: Control period [s].

    Returns:
        The largest excess [rad]; NaN if a sample is not finite or none follows the event.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    excess = between(error - error_old, event, min(until, event + PEAK_WINDOW), dt)
    return float(excess.max()) if len(excess) else UNDEFINED


excess_peak_position = variant(
    excess_peak,
    "excess_peak_position",
    "excess of the tool point, peak",
    needs=("position_error", "position_error_old", "event", "until", "dt"),
    quantity=("rad", "m"),
)


@metric(
    unit="s",
    better="none",
    family="resilience",
    needs=("error", "error_old", "event", "until", "dt"),
    source="when the excess over the old load's twin is largest, within 2.5 s",
    label="time of the peak",
    kind="twins",
)
def excess_peak_time(error: np.ndarray, error_old: np.ndarray, event: float, until: float, dt: float) -> float:
    """Time from the event to the largest excess in the 2.5 s after it.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_old: The same of the twin whose event never happens, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        dt: Control period [s].

    Returns:
        The time [s]; NaN if a sample is not finite, none follows the event, or there is no excess.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    excess = between(error - error_old, event, min(until, event + PEAK_WINDOW), dt)
    return float(excess.argmax() * dt) if len(excess) and excess.max() > 0.0 else UNDEFINED


@metric(
    unit="rad s/kg",
    better="lower",
    family="resilience",
    needs=("error", "error_new", "event", "until", "mass_change", "dt"),
    source="integrated excess by change of mass",
    label="integrated excess by mass",
    kind="twins",
)
def event_excess_per_kg(
    error: np.ndarray, error_new: np.ndarray, event: float, until: float, mass_change: float, dt: float
) -> float:
    """Integral of the excess, divided by how much the load changed.

    Args:
        error: Norm of the error at each tick from time 0, shape (N,) [rad].
        error_new: The same of the twin that carries the new load from the start, shape (N,) [rad].
        event: Time of the event [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        mass_change: New load less old load [kg].
        dt: Control period [s].

    Returns:
        The quotient [rad s/kg]; NaN if a sample is not finite, none follows the event, or the mass does not change.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the twins hold different numbers of ticks.
    """
    total = excess_integral.function(error, error_new, event, until, dt)
    return total / abs(mass_change) if mass_change else UNDEFINED
