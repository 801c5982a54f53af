"""The log of a run, as metrics want it: true states, plan and torques on bare arrays."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class RunLog:
    """One run, row k: the true state before torque k acts, and the plan of tick k.

    Attributes:
        t: Time since the end of the lead-in, shape (N,) [s].
        q: True joint positions, shape (N, n) [rad].
        dq: True joint velocities, shape (N, n) [rad/s].
        q_ref: Planned joint positions, shape (N, n) [rad].
        dq_ref: Planned joint velocities, shape (N, n) [rad/s].
        ddq_ref: Planned joint accelerations, shape (N, n) [rad/s^2].
        tau_cmd: What the controller returned, shape (N, n) [N m].
        tau_lim: What the limiter made of it, shape (N, n) [N m].
        tau: What acted at the joints, shape (N, n) [N m]; where they are elastic, what the springs gave to the links.
        p: True tool positions in the base frame, shape (N, 3) [m].
        p_ref: Planned tool positions, shape (N, 3) [m].
        quat: True tool attitudes, xyzw, shape (N, 4).
        quat_ref: Planned tool attitudes, xyzw, shape (N, 4).
        twist: True tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Planned tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        wrench: True load on the flange, flange axes, shape (N, 6) [N, N m].
        call_time: Wall time of each call of the controller, shape (N,) [s]; no part of the result.
        dt: Control period [s].
        lap: Duration of one lap [s].
        effort: Torque limits, shape (n,) [N m].
        torque_rate: Torque rate limits, shape (n,), None if the tier has none [N m/s].
        velocity: Velocity limits, shape (n,) [rad/s].
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].
        mass: Gripper and load together, None if they change during the run [kg].
    """

    t: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    q_ref: np.ndarray
    dq_ref: np.ndarray
    ddq_ref: np.ndarray
    tau_cmd: np.ndarray
    tau_lim: np.ndarray
    tau: np.ndarray
    p: np.ndarray
    p_ref: np.ndarray
    quat: np.ndarray
    quat_ref: np.ndarray
    twist: np.ndarray
    twist_ref: np.ndarray
    wrench: np.ndarray
    call_time: np.ndarray
    dt: float
    lap: float
    effort: np.ndarray
    torque_rate: np.ndarray | None
    velocity: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    mass: float | None


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """Return the quaternions of rotation matrices.

    Args:
        rotations: Shape (N, 3, 3).

    Returns:
        Unit quaternions xyzw, shape (N, 4).
    """
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotations).as_quat())
