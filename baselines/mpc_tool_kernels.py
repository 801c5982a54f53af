"""The arithmetic of a cost on the tool's pose: its slope and curvature, and coordinates without curvature."""

import numba
import numpy as np

from .rotation import rotation_error


@numba.njit(cache=True)
def tool_slopes(
    position: np.ndarray,
    rotation: np.ndarray,
    jacobian: np.ndarray,
    goal: np.ndarray,
    weights: np.ndarray,
    slopes: np.ndarray,
    curvatures: np.ndarray,
) -> None:
    r"""Write slope and Gauss-Newton curvature of the tool's cost in the joint positions, knot by knot.

    .. math:: \tfrac12 e^T W e, \quad e = (p - p_d, -e_R), \quad f = J^T W e, \quad G = J^T W J

    Args:
        position: Of the tool, shape (N, 3) [m].
        rotation: Of the tool, by column, shape (N, 3, 3).
        jacobian: By column, shape (N, n, 6).
        goal: Tool poses of the reference, shape (N, 4, 4) [m].
        weights: Diagonal of W at each knot, shape (N, 6).
        slopes: Receives f, shape (N, n).
        curvatures: Receives G, shape (N, n, n).
    """
    error, turn, actual = np.empty(6), np.empty(3), np.empty((3, 3))
    n = jacobian.shape[1]
    for k in range(position.shape[0]):
        for r in range(3):
            for c in range(3):
                actual[r, c] = rotation[k, c, r]
        rotation_error(actual, goal[k, :3, :3], turn)
        for r in range(3):
            error[r], error[3 + r] = position[k, r] - goal[k, r, 3], -turn[r]
        for i in range(n):
            slopes[k, i] = 0.0
            for r in range(6):
                slopes[k, i] += jacobian[k, i, r] * weights[k, r] * error[r]
            for j in range(i + 1):
                total = 0.0
                for r in range(6):
                    total += jacobian[k, i, r] * weights[k, r] * jacobian[k, j, r]
                curvatures[k, i, j] = curvatures[k, j, i] = total


@numba.njit(cache=True)
def add_tool_cost(
    slopes: np.ndarray, curvatures: np.ndarray, position: np.ndarray, gradient: np.ndarray, hessian: np.ndarray
) -> None:
    """Add slope and curvature in the joint positions to those in the accelerations of the blocks.

    Args:
        slopes: At the knots 1 to N, shape (N, n).
        curvatures: At the knots 1 to N, shape (N, n, n).
        position: Gamma^q at the knots 0 to N, shape (N + 1, b) [s^2].
        gradient: Is added to, block after block, shape (b n,).
        hessian: Its upper triangle is added to, shape (b n, b n).
    """
    n, blocks = slopes.shape[1], position.shape[1]
    for k in range(slopes.shape[0]):
        for b in range(blocks):
            share = position[k + 1, b]
            # A block that begins later does not move the knot.
            if share == 0.0:
                continue
            for i in range(n):
                gradient[b * n + i] += share * slopes[k, i]
            for c in range(b, blocks):
                both = share * position[k + 1, c]
                for i in range(n):
                    for j in range(n):
                        hessian[b * n + i, c * n + j] += both * curvatures[k, i, j]


@numba.njit(cache=True)
def factorise(matrix: np.ndarray) -> bool:
    r"""Replace the upper triangle of a matrix by its factor, and return whether it is positive definite.

    .. math:: H = U^T U

    Args:
        matrix: Its upper triangle is read and replaced, shape (v, v).
    """
    v = matrix.shape[0]
    for j in range(v):
        if not matrix[j, j] > 0.0:
            return False
        pivot = np.sqrt(matrix[j, j])
        for k in range(j, v):
            matrix[j, k] /= pivot
        for i in range(j + 1, v):
            scale = matrix[j, i]
            for k in range(i, v):
                matrix[i, k] -= scale * matrix[j, k]
    return True


@numba.njit(cache=True)
def whiten(factor: np.ndarray, columns: np.ndarray) -> None:
    r"""Replace rows by what they are in coordinates y = U x: the solution Z of Z U = C.

    Args:
        factor: U in its upper triangle, shape (v, v).
        columns: C by column, replaced, shape (v, r).
    """
    v, count = columns.shape
    for j in range(v):
        pivot = factor[j, j]
        for r in range(count):
            columns[j, r] /= pivot
        for k in range(j + 1, v):
            scale = factor[j, k]
            for r in range(count):
                columns[k, r] -= columns[j, r] * scale


@numba.njit(cache=True)
def unwhiten(factor: np.ndarray, vector: np.ndarray) -> None:
    """Replace a vector y by x with U x = y.

    Args:
        factor: U in its upper triangle, shape (v, v).
        vector: Replaced, shape (v,).
    """
    for i in range(vector.shape[0] - 1, -1, -1):
        for k in range(i + 1, vector.shape[0]):
            vector[i] -= factor[i, k] * vector[k]
        vector[i] /= factor[i, i]
