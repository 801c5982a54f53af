"""Effort and mechanical energy at the joints; losses of rotors, gears and electronics are in none of them.

The torque is held over a tick, so the work of tick k is ``tau(k) (q(k+1) - q(k))``, exact for a simulator; torque
times the velocity of the same row is not. What a window has N rows of, it has N - 1 steps of work of.
"""

import math

import numpy as np

from .registry import UNDEFINED, metric
from .shared import shared

RESTING_PATH = 1e-3
"""Path below which nothing was moved anywhere [m]."""


@shared
def joint_work(tau: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Work of each joint in each tick.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        q: Joint positions before they acted, shape (N, n) [rad].

    Returns:
        Shape (N - 1, n) [J].
    """
    return np.asarray(tau[:-1] * np.diff(q, axis=0))


@metric(
    unit="N2 m2 s",
    better="lower",
    family="effort",
    needs=("tau", "dt"),
    source="integral of tau^2, summed over joints",
    label="squared torque",
)
def effort_torque_sq(tau: np.ndarray, dt: float) -> float:
    """Time integral of the squared torques: what copper loss is proportional to, if all motors were alike.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        dt: Control period [s].

    Returns:
        The integral [N2 m2 s]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.einsum("kn,kn->", tau, tau) * dt)


@metric(
    unit="s",
    better="lower",
    family="effort",
    needs=("tau", "effort", "dt"),
    source="integral of (tau / effort)^2, summed over joints",
    label="squared torque by torque limit",
)
def effort_torque_sq_weighted(tau: np.ndarray, effort: np.ndarray, dt: float) -> float:
    """Time integral of the squared torques, each as a share of its joint's limit: small motors count as much.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        effort: Torque limits, shape (n,) [N m].
        dt: Control period [s].

    Returns:
        The integral [s]: seconds at the limit of one joint; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float((np.einsum("kn,kn->n", tau, tau) / effort**2).sum() * dt)


@metric(
    unit="J",
    better="lower",
    family="effort",
    needs=("tau", "q"),
    source="sum of max(tau dq, 0), joint by joint",
    label="work put in",
)
def energy_positive(tau: np.ndarray, q: np.ndarray) -> float:
    """Work that the joints put in: what an arm needs that cannot take energy back.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        q: Joint positions before they acted, shape (N, n) [rad].

    Returns:
        The work [J]; NaN if any sample is not finite or there is only one.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    return float(np.maximum(joint_work(tau, q), 0.0).sum()) if len(q) > 1 else UNDEFINED


@metric(
    unit="J",
    better="none",
    family="effort",
    needs=("tau", "q"),
    source="sum of tau dq",
    label="work, net",
)
def energy_net(tau: np.ndarray, q: np.ndarray) -> float:
    """Work put in less work taken back: over whole laps what friction turned into heat.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        q: Joint positions before they acted, shape (N, n) [rad].

    Returns:
        The work [J]; NaN if any sample is not finite or there is only one.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    return float(joint_work(tau, q).sum()) if len(q) > 1 else UNDEFINED


@metric(
    unit="J",
    better="lower",
    family="effort",
    needs=("tau", "q"),
    source="sum of |tau dq|, joint by joint",
    label="work put in and taken out",
)
def energy_abs(tau: np.ndarray, q: np.ndarray) -> float:
    """Work put in plus work taken out: what an arm needs whose brakes cost as much as its drives.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        q: Joint positions before they acted, shape (N, n) [rad].

    Returns:
        The work [J]; NaN if any sample is not finite or there is only one.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    return float(np.abs(joint_work(tau, q)).sum()) if len(q) > 1 else UNDEFINED


@metric(
    unit="J/(m kg)",
    better="lower",
    family="effort",
    needs=("tau", "q", "p", "mass"),
    source="energy_positive / (path of the tool x mass beyond the flange)",
    label="work by path and mass",
)
def energy_per_path(tau: np.ndarray, q: np.ndarray, p: np.ndarray, mass: float) -> float:
    """Work put in for each metre that the tool went and each kilogram that it carried.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        q: Joint positions before they acted, shape (N, n) [rad].
        p: Tool positions, base frame, shape (N, 3) [m].
        mass: What was moved beyond the flange, the same in the whole run [kg].

    Returns:
        The work [J/(m kg)]; NaN if any sample is not finite, the tool rests (below 1 mm) or carries nothing.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    steps = np.diff(p, axis=0)
    path = float(np.sqrt(np.einsum("kd,kd->k", steps, steps)).sum())
    if not (path > RESTING_PATH and math.isfinite(mass) and mass > 0.0):
        return UNDEFINED
    return float(np.maximum(joint_work(tau, q), 0.0).sum()) / (path * mass)
