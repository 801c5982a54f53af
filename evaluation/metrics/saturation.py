"""Saturation: how often and how far a run leaned on the limits of the arm (strictly beyond; equality is not)."""

import numpy as np

from .registry import UNDEFINED, metric

ROUNDING = 1e-9
"""Relative excess over a rate limit that rounding can make; the limiter itself lands on the limit."""


def clip_fraction_by_joint(tau_cmd: np.ndarray, effort: np.ndarray) -> np.ndarray:
    """Share of ticks at which each joint's command exceeded its torque limit.

    Args:
        tau_cmd: Commands before the limiter, shape (N, n) [N m].
        effort: Torque limits, shape (n,) [N m].

    Returns:
        Shape (n,), in [0, 1].
    """
    return np.asarray((np.abs(tau_cmd) > effort).mean(axis=0))


@metric(
    unit="1",
    better="lower",
    family="saturation",
    needs=("tau_cmd", "effort"),
    source="share of ticks with any |tau_cmd| > effort",
    label="ticks beyond a torque limit",
)
def clip_fraction(tau_cmd: np.ndarray, effort: np.ndarray) -> float:
    """Share of ticks at which any joint's command exceeded its torque limit.

    Above 1 % a comparison is one of saturated systems. :func:`clip_fraction_by_joint` gives each joint.

    Args:
        tau_cmd: Commands before the limiter, shape (N, n) [N m].
        effort: Torque limits, shape (n,) [N m].

    Returns:
        The share [1]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float((np.abs(tau_cmd) > effort).any(axis=1).mean())


@metric(
    unit="N m s",
    better="lower",
    family="saturation",
    needs=("tau_cmd", "effort", "dt"),
    source="integral of max(|tau_cmd| - effort, 0), summed over joints",
    label="impulse beyond the torque limits",
)
def clip_impulse(tau_cmd: np.ndarray, effort: np.ndarray, dt: float) -> float:
    """Angular impulse that the torque limits cut off, summed over joints.

    Args:
        tau_cmd: Commands before the limiter, shape (N, n) [N m].
        effort: Torque limits, shape (n,) [N m].
        dt: Control period [s].

    Returns:
        The impulse [N m s]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.maximum(np.abs(tau_cmd) - effort, 0.0).sum() * dt)


@metric(
    unit="1",
    better="lower",
    family="saturation",
    needs=("tau_cmd", "tau_lim", "effort", "torque_rate", "dt"),
    source="share of ticks at which the rate limiter changed the command",
    label="ticks beyond a torque-rate limit",
)
def torque_rate_clip_fraction(
    tau_cmd: np.ndarray, tau_lim: np.ndarray, effort: np.ndarray, torque_rate: np.ndarray, dt: float
) -> float:
    """Share of ticks at which any joint's command asked for a faster change than the limit allows.

    The change is the one the rate limiter sees: from its last output to the command within the torque limits. A
    log without rate limits (``torque_rate`` is None) has no such metric.

    Args:
        tau_cmd: Commands before the limiter, shape (N, n) [N m].
        tau_lim: Commands after the limiter, shape (N, n) [N m].
        effort: Torque limits, shape (n,) [N m].
        torque_rate: Torque rate limits, shape (n,) [N m/s].
        dt: Control period [s].

    Returns:
        The share of the ticks after the first [1]; NaN if any sample is not finite or there is only one.

    Raises:
        EmptyWindow: If there is no sample.
    """
    if len(tau_cmd) < 2:
        return UNDEFINED
    change = np.abs(np.clip(tau_cmd[1:], -effort, effort) - tau_lim[:-1])
    margin = ROUNDING * (torque_rate * dt + np.abs(tau_lim[:-1]))
    return float((change > torque_rate * dt + margin).any(axis=1).mean())


@metric(
    unit="1",
    better="lower",
    family="saturation",
    needs=("dq", "velocity"),
    source="share of ticks with any |dq| > velocity",
    label="ticks beyond a velocity limit",
)
def velocity_limit_fraction(dq: np.ndarray, velocity: np.ndarray) -> float:
    """Share of ticks at which any joint was faster than its limit.

    Args:
        dq: Joint velocities, shape (N, n) [rad/s].
        velocity: Velocity limits, shape (n,) [rad/s].

    Returns:
        The share [1]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float((np.abs(dq) > velocity).any(axis=1).mean())


@metric(
    unit="rad",
    better="higher",
    family="saturation",
    needs=("q", "lower", "upper"),
    source="least distance to a position limit",
    label="least margin to a position limit",
)
def position_limit_margin_min(q: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """Least distance that any joint ever had to one of its position limits.

    Args:
        q: Joint positions, shape (N, n) [rad].
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].

    Returns:
        The margin [rad], negative beyond a limit; NaN if any sample is not finite or no joint has a limit.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.minimum(q.min(axis=0) - lower, upper - q.max(axis=0)).min())
