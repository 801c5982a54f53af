r"""How stiff a joint's velocity loop may become: a cap on the gains where the sampled loop would be near its limit.

The loop of one joint, with position gain zero: velocity filter, spinal membrane, delay, torque lag, inertia.

.. math::
    f_k &= f_{k-1} + g (v_k - f_{k-1}), \quad u_k = u_{k-1} + (-k_v f_k - u_{k-1}) / \tau_{sp} \\
    a_k &= a_{k-1} + l (u_{k-d} - a_{k-1}), \quad v_{k+1} = v_k + h a_k / M

Without filter, delay and lag it is stable below :math:`k_v = 6 M / h` for a membrane constant of 2.
"""

from dataclasses import dataclass

import numpy as np

from ..controllers import Actuation, RobotModel

CRITICAL = 25.0
"""Joints whose limit is below this get caps [N m s/rad]: gains of about 20 are where the brainstem starts."""
MARGIN = 0.6
"""Share of the limit that a capped joint's damping may reach."""
STIFFNESS_RATIO = 10.0
"""Largest stiffness of a capped joint, in units of its damping cap [1/s]."""
_SEARCHED = 1e5


@dataclass(frozen=True, kw_only=True, eq=False)
class Caps:
    """Caps on the gains of each joint, infinite where there is none.

    Attributes:
        limit: Largest stable damping, shape (n,) [N m s/rad].
        stiffness: Cap on K_P, shape (n,) [N m/rad].
        damping: Cap on K_V, shape (n,) [N m s/rad].
    """

    limit: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray


def gain_caps(robot: RobotModel, q: np.ndarray, actuation: Actuation, *, period: float, membrane: float) -> Caps:
    """Return the caps at a posture.

    Args:
        robot: The known model.
        q: Joint positions, shape (n,) [rad].
        actuation: What the tier publishes of drives and sensors.
        period: Control period [s].
        membrane: Membrane constant of the spinal output neuron [ticks].
    """
    inertia = 1.0 / np.diag(np.linalg.inv(robot.mass_matrix(q)))
    limit = np.array([damping_limit(m, actuation, period=period, membrane=membrane) for m in inertia])
    damping = np.where(limit < CRITICAL, MARGIN * limit, np.inf)
    return Caps(limit=limit, stiffness=STIFFNESS_RATIO * damping, damping=damping)


def damping_limit(inertia: float, actuation: Actuation, *, period: float, membrane: float) -> float:
    """Return the largest damping gain at which one joint's sampled loop is stable.

    Args:
        inertia: What the joint feels when the others are free [kg m^2].
        actuation: What the tier publishes of drives and sensors.
        period: Control period [s].
        membrane: Membrane constant of the spinal output neuron [ticks].

    Returns:
        The limit [N m s/rad].
    """
    low, high = 0.0, _SEARCHED
    while high - low > 1e-6 * max(high, 1.0):
        middle = 0.5 * (low + high)
        loop = _loop(middle, inertia, actuation, period, membrane)
        # At gain zero the velocity itself is an integrator: its eigenvalue 1 must move inwards.
        stable = float(np.max(np.abs(np.linalg.eigvals(loop)))) < 1.0
        low, high = (middle, high) if stable else (low, middle)
    return low


def _loop(damping: float, inertia: float, actuation: Actuation, period: float, membrane: float) -> np.ndarray:
    """Return the loop's matrix for the state (v, filtered v, torque that acts, u of this tick and the ones before)."""
    hz = actuation.velocity_filter_hz
    filter_gain = 1.0 - np.exp(-2.0 * np.pi * hz * period) if hz else 1.0
    lag_gain = 1.0 - np.exp(-period / actuation.torque_lag) if actuation.torque_lag > 0.0 else 1.0
    delay = actuation.delay_ticks
    size = 4 + delay
    columns = []
    for state in np.eye(size):
        velocity, filtered, acting, commands = state[0], state[1], state[2], state[3:]
        filtered = filtered + filter_gain * (velocity - filtered)
        newest = commands[0] + (-damping * filtered - commands[0]) / membrane
        commands = np.concatenate(([newest], commands[:-1]))
        acting = acting + lag_gain * (commands[delay] - acting)
        velocity = velocity + period * acting / inertia
        columns.append(np.concatenate(([velocity, filtered, acting], commands)))
    return np.array(columns).T
