"""Rotations and principal axes: how an inertia tensor is written so that every engine reads it exactly."""

import numpy as np


def rotation_from_quaternion(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation of a quaternion.

    Args:
        quaternion: Order w, x, y, z, of any length above zero, shape (4,).

    Returns:
        Rotation matrix, shape (3, 3).
    """
    w, x, y, z = np.asarray(quaternion, dtype=float) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotation_from_rpy(rpy: np.ndarray) -> np.ndarray:
    r"""Return the rotation :math:`R_z(y) R_y(p) R_x(r)` of URDF's roll, pitch, yaw.

    Args:
        rpy: Roll, pitch, yaw, shape (3,) [rad].

    Returns:
        Rotation matrix, shape (3, 3).
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_from_rotation(rotation: np.ndarray) -> np.ndarray:
    """Return URDF's roll, pitch, yaw of a rotation.

    Args:
        rotation: Rotation matrix, shape (3, 3).

    Returns:
        Roll, pitch, yaw, shape (3,) [rad].
    """
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    pitch = np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0]))
    # Roll is read after yaw is taken out: exact at a pitch of 90 degrees too, where yaw alone has no meaning.
    sine, cosine = np.sin(yaw), np.cos(yaw)
    roll = np.arctan2(sine * rotation[0, 2] - cosine * rotation[1, 2], cosine * rotation[1, 1] - sine * rotation[0, 1])
    return np.array([roll, pitch, yaw])


def principal_axes(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""Return moments and axes of a tensor, :math:`I = R \, \mathrm{diag}(m) \, R^T`.

    Args:
        inertia: Symmetric tensor, shape (3, 3) [kg m^2].

    Returns:
        Principal moments, shape (3,) [kg m^2], and the right-handed rotation R from principal axes, shape (3, 3).
        A diagonal tensor keeps its order and the identity.
    """
    moments = np.diag(inertia).copy()
    if np.array_equal(inertia, np.diag(moments)):
        return moments, np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return moments, axes


def parallel_axis(mass: float, com: np.ndarray) -> np.ndarray:
    r"""Return what Steiner's theorem adds, :math:`m (c^T c \, 1 - c c^T)`.

    Args:
        mass: Mass [kg].
        com: Centre of mass from the point of reference, shape (3,) [m].

    Returns:
        Tensor, shape (3, 3) [kg m^2].
    """
    return np.asarray(mass * (np.dot(com, com) * np.eye(3) - np.outer(com, com)))
