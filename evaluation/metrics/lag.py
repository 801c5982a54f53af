"""Lag: how much of an error is lateness alone."""

import math

import numpy as np

from .precision import FAILED_POSITION
from .registry import UNDEFINED, Censored, metric
from .shift import best_shift

RESTING_TOOL, RESTING_JOINTS = 1e-3, 1e-3
"""Spread below which a reference rests and a lag has no meaning [m, rad]."""


def joint_time_lags(q: np.ndarray, q_ref: np.ndarray, dt: float) -> np.ndarray:
    """Time lag of each joint by itself.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions, shape (N, n) [rad].
        dt: Control period [s].

    Returns:
        Shape (n,) [s], positive when late; NaN for a joint whose plan rests.
    """
    fits = (best_shift(q[:, [i]], q_ref[:, [i]], dt, RESTING_JOINTS) for i in range(q.shape[1]))
    return np.array([math.nan if fit is None else fit.lag for fit in fits])


@metric(
    unit="s",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "dt"),
    source="least squares over shifts of the reference",
    label="time lag of the tool",
)
def time_lag(p: np.ndarray, p_ref: np.ndarray, dt: float) -> float:
    """Time by which the tool is late: the shift of the reference that fits the tool's motion best.

    Least squares over whole ticks up to 0.2 s or an eighth of the window, whichever is less, then a parabola
    through the three lowest points.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].

    Returns:
        The lag [s], positive when late, negative when early; a bound (:class:`Censored`) at the longest shift; NaN if
        any sample is not finite, the reference rests (spread below 1 mm), or there are fewer than 16 ticks.

    Raises:
        EmptyWindow: If there is no sample.
    """
    fit = best_shift(p, p_ref, dt, RESTING_TOOL)
    if fit is None:
        return UNDEFINED
    return Censored(fit.lag) if fit.censored else fit.lag


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "dt"),
    source="root of the least square over shifts",
    label="RMS position error without the lag",
    fail_value=FAILED_POSITION,
)
def lag_free_error(p: np.ndarray, p_ref: np.ndarray, dt: float) -> float:
    """Root mean square position error that is left once the reference is shifted by :func:`time_lag`.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].

    Returns:
        The root mean square [m]; a bound at the longest shift; NaN as for :func:`time_lag`.

    Raises:
        EmptyWindow: If there is no sample.
    """
    fit = best_shift(p, p_ref, dt, RESTING_TOOL)
    if fit is None:
        return UNDEFINED
    return Censored(math.sqrt(fit.square)) if fit.censored else math.sqrt(fit.square)


@metric(
    unit="1",
    better="none",
    family="lag",
    needs=("p", "p_ref", "dt"),
    source="1 - (lag_free_error / RMS error)^2",
    label="share of the squared error that is lag",
)
def lag_share(p: np.ndarray, p_ref: np.ndarray, dt: float) -> float:
    """Share of the mean squared position error that a shift in time explains.

    Both squares are taken over the ticks at which every shift exists, so the share lies in [0, 1].

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].

    Returns:
        The share [1]; a bound at the longest shift; NaN as for :func:`time_lag`, and where there is no error.

    Raises:
        EmptyWindow: If there is no sample.
    """
    fit = best_shift(p, p_ref, dt, RESTING_TOOL)
    if fit is None or fit.unshifted == 0.0:
        return UNDEFINED
    share = 1.0 - fit.square / fit.unshifted
    return Censored(share) if fit.censored else share


@metric(
    unit="s",
    better="lower",
    family="lag",
    needs=("q", "q_ref", "dt"),
    source="least squares over shifts of the plan, all joints together",
    label="time lag of the joints",
)
def joint_time_lag(q: np.ndarray, q_ref: np.ndarray, dt: float) -> float:
    """Time by which all joints together are late; :func:`joint_time_lags` gives each joint.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions of the same ticks, shape (N, n) [rad].
        dt: Control period [s].

    Returns:
        The lag [s], positive when late; a bound at the longest shift; NaN if any sample is not finite, the plan rests
        (spread below 1 mrad), or there are fewer than 16 ticks.

    Raises:
        EmptyWindow: If there is no sample.
    """
    fit = best_shift(q, q_ref, dt, RESTING_JOINTS)
    if fit is None:
        return UNDEFINED
    return Censored(fit.lag) if fit.censored else fit.lag
