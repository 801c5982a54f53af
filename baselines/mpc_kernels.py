"""The arithmetic of one plan: roll-out, gradient, torque rows, and the state between knots."""

import numba
import numpy as np


@numba.njit(cache=True)
def roll_out(
    start: np.ndarray,
    accelerations: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    selection: np.ndarray,
    interval: float,
    q: np.ndarray,
    dq: np.ndarray,
    ddq: np.ndarray,
) -> None:
    """Write the states at the knots and the accelerations between them.

    Args:
        start: Position and velocity at knot 0, shape (2, n) [rad, rad/s].
        accelerations: Of the blocks, shape (b, n) [rad/s^2].
        position: Gamma^q, shape (N + 1, b) [s^2].
        velocity: Gamma^v, shape (N + 1, b) [s].
        selection: S, shape (N, b).
        interval: Time between two knots [s].
        q: Receives positions at the knots 0 to N, shape (N + 1, n) [rad].
        dq: Receives velocities, shape (N + 1, n) [rad/s].
        ddq: Receives accelerations from the knots 0 to N - 1 on, shape (N, n) [rad/s^2].
    """
    knots, blocks = selection.shape
    for k in range(knots + 1):
        for i in range(start.shape[1]):
            q[k, i], dq[k, i] = start[0, i] + k * interval * start[1, i], start[1, i]
        for b in range(blocks):
            for i in range(start.shape[1]):
                q[k, i] += position[k, b] * accelerations[b, i]
                dq[k, i] += velocity[k, b] * accelerations[b, i]
    for k in range(knots):
        for i in range(start.shape[1]):
            ddq[k, i] = 0.0
            for b in range(blocks):
                ddq[k, i] += selection[k, b] * accelerations[b, i]


@numba.njit(cache=True)
def reference_accelerations(dq: np.ndarray, interval: float, ddq: np.ndarray) -> None:
    """Write the mean accelerations of a plan between knots.

    Args:
        dq: Velocities at the knots 0 to N, shape (N + 1, n) [rad/s].
        interval: Time between two knots [s].
        ddq: Receives the accelerations, shape (N, n) [rad/s^2].
    """
    for k in range(ddq.shape[0]):
        for i in range(ddq.shape[1]):
            ddq[k, i] = (dq[k + 1, i] - dq[k, i]) / interval


@numba.njit(cache=True)
def tracking_gradient(
    q_error: np.ndarray,
    dq_error: np.ndarray,
    ddq_error: np.ndarray,
    weights: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    selection: np.ndarray,
    gradient: np.ndarray,
) -> None:
    r"""Write the slope of the tracking cost in the accelerations of the blocks.

    .. math:: g = \sum_{k=1}^N \Gamma_k^T Q_k (x_k - r_k) + \sum_{k=0}^{N-1} S_k^T (u_k - u^r_k)

    Args:
        q_error: Position less reference at the knots 0 to N, shape (N + 1, n) [rad].
        dq_error: Velocity less reference, shape (N + 1, n) [rad/s].
        ddq_error: Acceleration less reference from the knots 0 to N - 1 on, shape (N, n) [rad/s^2].
        weights: Q at the knots 1 to N, shape (N, 2, 2).
        position: Gamma^q, shape (N + 1, b); or another basis of the same.
        velocity: Gamma^v, shape (N + 1, b).
        selection: S, shape (N, b).
        gradient: Receives the slope, block after block, shape (b n,).
    """
    knots, blocks = selection.shape
    n = q_error.shape[1]
    gradient[:] = 0.0
    for k in range(knots):
        a, c, d = weights[k, 0, 0], weights[k, 0, 1], weights[k, 1, 1]
        for b in range(blocks):
            for i in range(n):
                by_position = a * q_error[k + 1, i] + c * dq_error[k + 1, i]
                by_velocity = c * q_error[k + 1, i] + d * dq_error[k + 1, i]
                gradient[b * n + i] += (
                    position[k + 1, b] * by_position
                    + velocity[k + 1, b] * by_velocity
                    + selection[k, b] * ddq_error[k, i]
                )


@numba.njit(cache=True)
def torque_columns(
    derivatives: np.ndarray, position: np.ndarray, velocity: np.ndarray, selection: np.ndarray, columns: np.ndarray
) -> None:
    r"""Write how the torques at the knots depend on the accelerations of the blocks.

    .. math:: C_k = \frac{\partial \tau}{\partial q} \Gamma^q_k + \frac{\partial \tau}{\partial \dot q} \Gamma^v_k
        + M S_k

    Args:
        derivatives: Of the torque by q, dq and ddq at the knots 0 to N - 1, shape (N, 3 n, n), by column.
        position: Gamma^q, shape (N + 1, b); or another basis of the same.
        velocity: Gamma^v, shape (N + 1, b).
        selection: S, shape (N, b).
        columns: Receives C by column, one for each joint of each block, shape (b n, N n).
    """
    knots, blocks = selection.shape
    n = derivatives.shape[2]
    for k in range(knots):
        for b in range(blocks):
            by_q, by_dq, by_ddq = position[k, b], velocity[k, b], selection[k, b]
            for j in range(n):
                for i in range(n):
                    columns[b * n + j, k * n + i] = (
                        by_q * derivatives[k, j, i]
                        + by_dq * derivatives[k, n + j, i]
                        + by_ddq * derivatives[k, 2 * n + j, i]
                    )


@numba.njit(cache=True)
def torque_room(
    torque: np.ndarray, disturbance: np.ndarray, limit: np.ndarray, least: np.ndarray, most: np.ndarray
) -> None:
    """Write by how much the torques at the knots may fall and rise.

    Args:
        torque: At the knots, without the disturbance, shape (N, n) [N m].
        disturbance: What acts on the arm besides the command, shape (n,) [N m].
        limit: Largest torque, shape (n,) [N m].
        least: Receives the lower bounds, knot after knot, shape (N n,) [N m].
        most: Receives the upper bounds, shape (N n,) [N m].
    """
    knots, n = torque.shape
    for k in range(knots):
        for i in range(n):
            planned = torque[k, i] - disturbance[i]
            least[k * n + i] = -limit[i] - planned
            most[k * n + i] = limit[i] - planned


@numba.njit(cache=True)
def shift(accelerations: np.ndarray, knots: float, selection: np.ndarray, shifted: np.ndarray) -> None:
    """Write the accelerations of a plan's blocks as seen from a later start; its end goes on.

    Args:
        accelerations: Between the knots of the plan, shape (N, n) [rad/s^2].
        knots: By how many intervals the new start is later.
        selection: S, shape (N, b).
        shifted: Receives the mean acceleration of each block, shape (b, n) [rad/s^2].
    """
    count, blocks = selection.shape
    shifted[:] = 0.0
    for b in range(blocks):
        size = 0.0
        for k in range(count):
            if selection[k, b] > 0.0:
                size += 1.0
                source = min(int(k + 0.5 + knots), count - 1)
                for i in range(shifted.shape[1]):
                    shifted[b, i] += accelerations[source, i]
        for i in range(shifted.shape[1]):
            shifted[b, i] /= size


@numba.njit(cache=True)
def planned_state(
    q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, interval: float, elapsed: float, state: np.ndarray
) -> bool:
    """Write what a plan is at a time after its start, exactly, and return whether it reaches that far.

    Args:
        q: Positions at the knots 0 to N, shape (N + 1, n) [rad].
        dq: Velocities, shape (N + 1, n) [rad/s].
        ddq: Accelerations from the knots 0 to N - 1 on, shape (N, n) [rad/s^2].
        interval: Time between two knots [s].
        elapsed: Time since the plan's start [s].
        state: Receives position, velocity, acceleration, shape (3, n) [rad, rad/s, rad/s^2].
    """
    # A tick's time carries the rounding of its decimal digits: on a knot it must give the knot.
    k = int(np.floor(elapsed / interval + 1e-6))
    if k < 0 or k >= ddq.shape[0]:
        return False
    since = elapsed - k * interval
    for i in range(q.shape[1]):
        state[0, i] = q[k, i] + since * (dq[k, i] + 0.5 * since * ddq[k, i])
        state[1, i] = dq[k, i] + since * ddq[k, i]
        state[2, i] = ddq[k, i]
    return True
