"""Joint accelerations from which an arm can still stop before its limits: a one-step bound cannot promise it."""

import numba
import numpy as np

from ..controllers import Reference, RobotModel

LARGEST_ACCELERATION = 1000.0
"""Acceleration that counts as unlimited [rad/s^2]."""

SMALLEST_ACCELERATION = 1.0
"""Deceleration that a joint is trusted with even where gravity takes all of its torque [rad/s^2]."""


def acceleration_limits(
    robot: RobotModel, reference: Reference, effort: np.ndarray, share: float
) -> tuple[np.ndarray, np.ndarray]:
    r"""Return what each joint can reach at all, and what it can brake with anywhere on the plan.

    .. math:: \ddot q_{max,j} = \min_t \frac{\tau_{max,j}}{M_{jj}(q_d(t))}, \quad
        \ddot q_{brake,j} = s \min_t \frac{\tau_{max,j} - |g_j(q_d(t))|}{M_{jj}(q_d(t))}

    Braking with more than the torque that gravity leaves is not possible when it is needed, so that a bound built on it
    would be an empty promise; but a plan may well need more where gravity helps, so that it does not bound the
    acceleration itself. The share s leaves torque for the couplings.

    Args:
        robot: The model with the payload that is known.
        reference: The plan, of which one lap is read.
        effort: Torque limits, shape (n,) [N m].
        share: Share s of the torque left.

    Returns:
        Reachable and braking accelerations, shape (n,) each [rad/s^2].
    """
    inertia = np.stack([np.diag(robot.mass_matrix(q)) for q in reference.q])
    left = effort - np.abs([robot.gravity(q) for q in reference.q])
    reach, brake = np.min(effort / inertia, axis=0), share * np.min(left / inertia, axis=0)
    reach = np.clip(reach, SMALLEST_ACCELERATION, LARGEST_ACCELERATION)
    return reach, np.clip(brake, SMALLEST_ACCELERATION, reach)


@numba.njit(cache=True)
def viable_accelerations(
    q: np.ndarray,
    dq: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    velocity: np.ndarray,
    reach: np.ndarray,
    brake: np.ndarray,
    period: float,
    least: np.ndarray,
    most: np.ndarray,
) -> None:
    r"""Write the accelerations that keep position and velocity inside their limits, now and for ever.

    The upper bound is the smallest of what one tick allows in position and velocity, the limit itself, and the largest
    acceleration after which full braking still stops at the limit; the lower bound is its mirror image:

    .. math::
        \ddot q &\le \frac{q_{max} - q - h \dot q}{h^2}, \quad \ddot q \le \frac{\dot q_{max} - \dot q}{h},
            \quad \ddot q \le \ddot q_{max} \\
        (\dot q + h \ddot q)^2 &\le 2 \ddot q_{brake} (q_{max} - q - h \dot q - h^2 \ddot q / 2)
            \quad \text{where} \quad \dot q + h \ddot q > 0

    Outside the limits both bounds shrink to full reach, back towards the inside; they never cross.
    Source: Del Prete, Joint position and velocity bounds in discrete-time acceleration/torque control of robot
    manipulators, IEEE Robotics and Automation Letters 3 (2018).

    Args:
        q: Joint positions, shape (n,) [rad].
        dq: Joint velocities, shape (n,) [rad/s].
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].
        velocity: Velocity limits, shape (n,) [rad/s].
        reach: Largest accelerations, shape (n,) [rad/s^2].
        brake: Accelerations that braking can count on, at most those, shape (n,) [rad/s^2].
        period: Control period h [s].
        least: Receives the lower bounds, shape (n,) [rad/s^2].
        most: Receives the upper bounds, shape (n,) [rad/s^2].
    """
    for i in range(q.shape[0]):
        highest = _largest(upper[i] - q[i], dq[i], velocity[i], reach[i], brake[i], period)
        lowest = -_largest(q[i] - lower[i], -dq[i], velocity[i], reach[i], brake[i], period)
        if lowest > highest:
            # Two limits ask for opposite things: neither can be had in full.
            lowest = highest = 0.5 * (lowest + highest)
        least[i], most[i] = lowest, highest


@numba.njit(cache=True)
def _largest(room: float, speed: float, velocity: float, reach: float, brake: float, period: float) -> float:
    """Return the largest viable acceleration towards a limit that is some room away, at a speed towards it."""
    step = period * speed
    bound = min(reach, (velocity - speed) / period, (room - step) / period**2)
    # The quadratic of the braking parabola in the acceleration; no real root means that it is too late for it.
    b = 2.0 * step + brake * period**2
    discriminant = b * b - 4.0 * period**2 * (speed * speed - 2.0 * brake * (room - step))
    stop = -speed / period
    viable = stop if discriminant < 0.0 else max((-b + np.sqrt(discriminant)) / (2.0 * period**2), stop)
    return max(min(bound, viable), -reach)
