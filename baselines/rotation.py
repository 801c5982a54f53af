"""The orientation error as a rotation vector."""

import numba
import numpy as np


@numba.njit(cache=True)
def rotation_error(rotation: np.ndarray, desired: np.ndarray, error: np.ndarray) -> None:
    r"""Write the rotation vector, in base axes, that turns one orientation into another.

    .. math:: e_R = R \log(R^T R_d) = \log(R_d R^T)

    Goes through the unit quaternion by its largest component, so that no digits are lost near 0, where the cosine is
    flat, and near pi, where the skew part vanishes.
    Source: Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978).

    Args:
        rotation: R, the orientation in the base frame, shape (3, 3).
        desired: R_d, shape (3, 3).
        error: Receives e_R, of length at most pi, shape (3,) [rad].
    """
    turn = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            turn[i, j] = (
                desired[i, 0] * rotation[j, 0] + desired[i, 1] * rotation[j, 1] + desired[i, 2] * rotation[j, 2]
            )
    w = _unit_quaternion(turn, error)
    sine = np.sqrt(error[0] ** 2 + error[1] ** 2 + error[2] ** 2)
    # The quaternion's sign is free: the one with w >= 0 is the shorter way round.
    scale = 2.0 if sine < 1e-12 else 2.0 * np.arctan2(sine, abs(w)) / sine
    if w < 0.0:
        scale = -scale
    for i in range(3):
        error[i] *= scale


@numba.njit(cache=True)
def _unit_quaternion(turn: np.ndarray, vector: np.ndarray) -> float:
    """Write the vector part of the quaternion of a rotation and return its scalar part."""
    trace = turn[0, 0] + turn[1, 1] + turn[2, 2]
    i = int(np.argmax(np.diag(turn)))
    if trace > turn[i, i]:
        w = 0.5 * float(np.sqrt(1.0 + trace))
        for k in range(3):
            vector[k] = (turn[(k + 2) % 3, (k + 1) % 3] - turn[(k + 1) % 3, (k + 2) % 3]) / (4.0 * w)
        return w
    j, k = (i + 1) % 3, (i + 2) % 3
    largest = 0.5 * float(np.sqrt(1.0 + turn[i, i] - turn[j, j] - turn[k, k]))
    vector[i] = largest
    vector[j] = (turn[j, i] + turn[i, j]) / (4.0 * largest)
    vector[k] = (turn[k, i] + turn[i, k]) / (4.0 * largest)
    return float(turn[k, j] - turn[j, k]) / (4.0 * largest)
