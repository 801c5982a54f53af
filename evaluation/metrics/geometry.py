"""Distances and angles, tick by tick, that the metrics reduce to numbers."""

import math

import numpy as np

from .shared import shared_series


@shared_series
def distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the Euclidean distance of corresponding rows.

    Args:
        a: Shape (N, d), any unit.
        b: Shape (N, d), the same unit.

    Returns:
        Shape (N,), the same unit.
    """
    difference = a - b
    return np.asarray(np.sqrt(np.einsum("kd,kd->k", difference, difference)))


@shared_series
def rotation_angles(quat: np.ndarray, quat_ref: np.ndarray) -> np.ndarray:
    r"""Return the geodesic angle between corresponding attitudes.

    .. math:: \theta = 2\,\mathrm{atan2}(\lVert q_v \rVert, |q_w|), \quad q = q_{ref}^{-1} \otimes q

    Resolves 1e-9 rad, where the arc cosine of the trace returns 0; q and -q are the same attitude.

    Args:
        quat: Attitudes xyzw, shape (N, 4); the common length of a pair's quaternions cancels.
        quat_ref: Attitudes xyzw, shape (N, 4).

    Returns:
        Angles in [0, pi], shape (N,) [rad].
    """
    vector, scalar = _relative(quat, quat_ref)
    return np.asarray(2.0 * np.arctan2(np.sqrt(np.einsum("dk,dk->k", vector, vector)), np.abs(scalar)))


def rotation_vectors(quat: np.ndarray, quat_ref: np.ndarray) -> np.ndarray:
    """Return the rotation from each reference attitude to its attitude, as axis times angle.

    Args:
        quat: Attitudes xyzw, shape (N, 4); the common length of a pair's quaternions cancels.
        quat_ref: Attitudes xyzw, shape (N, 4).

    Returns:
        Vectors in the axes of the reference attitude, at most pi long, shape (N, 3) [rad].
    """
    vector, scalar = _relative(quat, quat_ref)
    size = np.sqrt(np.einsum("dk,dk->k", vector, vector))
    angle = np.where(scalar < 0.0, -2.0, 2.0) * np.arctan2(size, np.abs(scalar))
    return np.asarray((vector * np.divide(angle, size, out=np.zeros_like(size), where=size > 0.0)).T)


def _relative(quat: np.ndarray, quat_ref: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return vector, shape (3, N), and scalar, shape (N,), of the quaternion from reference to attitude."""
    x, y, z, w = quat.T
    rx, ry, rz, rw = quat_ref.T
    vx = rw * x - w * rx - (ry * z - rz * y)
    vy = rw * y - w * ry - (rz * x - rx * z)
    vz = rw * z - w * rz - (rx * y - ry * x)
    return np.stack([vx, vy, vz]), rw * w + rx * x + ry * y + rz * z


def roll_pitch_yaw(quat: np.ndarray) -> np.ndarray:
    """Return the angles about the fixed axes x, then y, then z.

    Args:
        quat: Unit quaternions xyzw, shape (N, 4).

    Returns:
        Roll and yaw in [-pi, pi], pitch in [-pi/2, pi/2], shape (N, 3) [rad].
    """
    x, y, z, w = quat.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=1)


def root_mean_square(series: np.ndarray) -> float:
    """Return the root mean square of a series.

    Args:
        series: Shape (N,), any unit.

    Returns:
        A number in the same unit.
    """
    return math.sqrt(float(np.mean(series * series)))
