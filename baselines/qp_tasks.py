r"""The matrices of the whole-body program: tasks become a Hessian, limits become rows.

The unknowns are counted in the roots of the joints' own inertias, :math:`y_j = \sqrt{M_{jj}} \, d_j`: in them an arm's
shoulder and its wrist weigh the same, and the solver needs no preconditioner.
"""

import numba
import numpy as np

from .quadratic_program import UNLIMITED
from .rotation import rotation_error

_UNLIMITED = UNLIMITED


@numba.njit(cache=True)
def acceleration_gains(
    pose: np.ndarray, goal: np.ndarray, gains: np.ndarray, inertia: np.ndarray, spring: np.ndarray, damping: np.ndarray
) -> None:
    r"""Write spring wrench and damping that give the tool's error the same dynamics everywhere.

    .. math:: \Lambda (k_p e + k_d \dot e), \quad D = k_d \Lambda

    so that the free tool obeys :math:`\ddot e + k_d \dot e + k_p e = 0`; its stiffness is that of its inertia.

    Args:
        pose: Tool pose in the base frame, shape (4, 4) [m].
        goal: Its goal, shape (4, 4) [m].
        gains: k_p and k_d, shape (2,) [1/s^2, 1/s].
        inertia: Lambda, shape (6, 6) [kg, kg m, kg m^2].
        spring: Receives the wrench of the error, shape (6,) [N, N m].
        damping: Receives D, shape (6, 6) [N s/m, N s, N m s].
    """
    error = np.empty(6)
    rotation_error(pose[:3, :3], goal[:3, :3], error[3:])
    for i in range(3):
        error[i] = goal[i, 3] - pose[i, 3]
    for r in range(6):
        spring[r] = 0.0
        for c in range(6):
            spring[r] += gains[0] * inertia[r, c] * error[c]
            damping[r, c] = gains[1] * inertia[r, c]


@numba.njit(cache=True)
def free_acceleration(mass_matrix: np.ndarray, bias: np.ndarray, torque: np.ndarray, acceleration: np.ndarray) -> None:
    r"""Write the joint acceleration of a torque that no limit touches.

    .. math:: \ddot q = M^{-1} (\tau - h)

    Args:
        mass_matrix: M, positive definite, shape (n, n) [kg m^2].
        bias: h, shape (n,) [N m].
        torque: tau, shape (n,) [N m].
        acceleration: Receives the acceleration, shape (n,) [rad/s^2].
    """
    n = bias.shape[0]
    factor = np.empty((n, n))
    for i in range(n):
        rest = torque[i] - bias[i]
        for j in range(i + 1):
            entry = mass_matrix[i, j]
            for k in range(j):
                entry -= factor[i, k] * factor[j, k]
            factor[i, j] = np.sqrt(entry) if i == j else entry / factor[j, j]
        for k in range(i):
            rest -= factor[i, k] * acceleration[k]
        acceleration[i] = rest / factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            acceleration[i] -= factor[k, i] * acceleration[k]
        acceleration[i] /= factor[i, i]


@numba.njit(cache=True)
def task_matrices(
    mass_matrix: np.ndarray,
    jacobian: np.ndarray,
    inertia: np.ndarray,
    torque: np.ndarray,
    weights: np.ndarray,
    hessian: np.ndarray,
    gradient: np.ndarray,
) -> None:
    r"""Write the objective in d, the joint acceleration beyond the free one.

    .. math:: H = w_n M + w_p J^T \Lambda J + w_e M M, \quad g = w_e M \tau_0

    Both tasks are at their optimum at d = 0, so that only the effort has a slope there. Each joint's slack costs
    :math:`w_s M_{jj}`. All of it is divided by the root of the slack's weight, which moves no optimum: posture and
    slack then lie evenly about 1, and the solver's one tolerance is fair to rows and gradient.

    Args:
        mass_matrix: M, shape (n, n) [kg m^2].
        jacobian: J, shape (6, n).
        inertia: Lambda, shape (6, 6) [kg, kg m, kg m^2].
        torque: The free torque, shape (n,) [N m].
        weights: Posture w_n, pose w_p, effort w_e, slack w_s, shape (4,) [1, 1, 1/(kg m^2), 1].
        hessian: Receives H in scaled unknowns, then the slacks' costs, shape (2 n, 2 n).
        gradient: Receives g in scaled unknowns, then zeros, shape (2 n,).
    """
    n, even = torque.shape[0], 1.0 / np.sqrt(weights[3])
    product = np.empty((6, n))
    for r in range(6):
        for j in range(n):
            total = 0.0
            for c in range(6):
                total += inertia[r, c] * jacobian[c, j]
            product[r, j] = total
    for i in range(n):
        gradient[i] = 0.0
        for j in range(n):
            tool, effort = 0.0, 0.0
            for r in range(6):
                tool += jacobian[r, i] * product[r, j]
            for k in range(n):
                effort += mass_matrix[i, k] * mass_matrix[k, j]
            entry = weights[0] * mass_matrix[i, j] + weights[1] * tool + weights[2] * effort
            hessian[i, j] = even * entry / np.sqrt(mass_matrix[i, i] * mass_matrix[j, j])
            gradient[i] += even * weights[2] * mass_matrix[i, j] * torque[j] / np.sqrt(mass_matrix[i, i])
        hessian[n + i, n + i] = even * weights[3]
    for i in range(n):
        for j in range(i):
            # The solver reads one triangle, and rounding must not depend on which.
            hessian[i, j] = hessian[j, i]


@numba.njit(cache=True)
def torque_limits(
    command: np.ndarray, effort: np.ndarray, step: np.ndarray, least: np.ndarray, most: np.ndarray
) -> bool:
    r"""Write what the limiter lets through in this tick, and return whether effort and rate agree at all.

    .. math:: \max(-\tau_{max}, \tau_{k-1} - \Delta) \le \tau \le \min(\tau_{max}, \tau_{k-1} + \Delta)

    Where they do not agree, the rate wins, as it does in the limiter.

    Args:
        command: Last command after the limiter, shape (n,) [N m].
        effort: Torque limits, shape (n,) [N m].
        step: Largest change in one tick, infinite without a rate limit, shape (n,) [N m].
        least: Receives the lower limits, shape (n,) [N m].
        most: Receives the upper limits, shape (n,) [N m].
    """
    agree = True
    for i in range(command.shape[0]):
        low, high = command[i] - step[i], command[i] + step[i]
        least[i], most[i] = min(max(-effort[i], low), high), max(min(effort[i], high), low)
        agree = agree and -effort[i] <= high and effort[i] >= low
    return agree


@numba.njit(cache=True)
def limit_rows(
    mass_matrix: np.ndarray,
    torque: np.ndarray,
    acceleration: np.ndarray,
    torque_bounds: np.ndarray,
    acceleration_bounds: np.ndarray,
    rows: np.ndarray,
    bounds: np.ndarray,
) -> None:
    r"""Write the limits as rows in d and the slacks s: torque hard, acceleration soft.

    .. math:: \tau_{min} - \tau_0 \le M d \le \tau_{max} - \tau_0, \quad
        \ddot q_{min} - \ddot q_0 \le d + s \le \ddot q_{max} - \ddot q_0

    A torque row is divided by the root of its joint's inertia, an acceleration row multiplied by it.

    Args:
        mass_matrix: M, shape (n, n) [kg m^2].
        torque: The free torque, shape (n,) [N m].
        acceleration: The free acceleration, shape (n,) [rad/s^2].
        torque_bounds: Lower and upper, shape (2, n) [N m].
        acceleration_bounds: Lower and upper, shape (2, n) [rad/s^2].
        rows: Receives the scaled M in its upper left block, shape (2 n, 2 n); its lower blocks are identities already.
        bounds: Receives scaled lower and upper bounds, shape (2, 2 n).
    """
    n = torque.shape[0]
    for i in range(n):
        for j in range(n):
            rows[i, j] = mass_matrix[i, j] / np.sqrt(mass_matrix[i, i] * mass_matrix[j, j])
        root = np.sqrt(mass_matrix[i, i])
        for side in range(2):
            hard, soft = torque_bounds[side, i] - torque[i], acceleration_bounds[side, i] - acceleration[i]
            bounds[side, i] = min(max(hard / root, -_UNLIMITED), _UNLIMITED)
            bounds[side, n + i] = min(max(soft * root, -_UNLIMITED), _UNLIMITED)


@numba.njit(cache=True)
def limited_torque(
    mass_matrix: np.ndarray, torque: np.ndarray, beyond: np.ndarray, torque_bounds: np.ndarray, result: np.ndarray
) -> None:
    r"""Write the torque of a solution, without the solver's tolerance at the limits.

    .. math:: \tau = \mathrm{clip}(\tau_0 + M d, \tau_{min}, \tau_{max})

    Args:
        mass_matrix: M, shape (n, n) [kg m^2].
        torque: The free torque, shape (n,) [N m].
        beyond: d in scaled unknowns, followed by anything, shape (n,) or longer.
        torque_bounds: Lower and upper, shape (2, n) [N m].
        result: Receives the torque, shape (n,) [N m].
    """
    for i in range(torque.shape[0]):
        total = torque[i]
        for j in range(torque.shape[0]):
            total += mass_matrix[i, j] * beyond[j] / np.sqrt(mass_matrix[j, j])
        result[i] = min(max(total, torque_bounds[0, i]), torque_bounds[1, i])
