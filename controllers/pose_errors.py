"""Pose errors and jacobians of many joint positions at once, as inverse kinematics needs them."""

import numpy as np
import pinocchio as pin

from .robot_model import RobotModel

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def pose_errors(model: RobotModel, q: np.ndarray, poses: np.ndarray, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a frame is from poses, and how the joints move it.

    Args:
        model: The arm.
        q: Joint positions, shape (k, n) [rad].
        poses: Where the frame should be, base frame, shape (k, 4, 4) [m].
        frame: ``model.tool_id`` or ``model.flange_id``.

    Returns:
        Errors as base-aligned twists, linear before angular, shape (k, 6) [m, rad], and jacobians of the frame in the
        same axes, shape (k, 6, n).
    """
    error, jacobian = np.empty((len(q), 6)), np.empty((len(q), 6, model.n))
    rotation = np.empty((len(q), 3, 3))
    arm, data = model.model, model.data
    reached = data.oMf[frame]
    for k, joints in enumerate(q):
        # Of a single joint Pinocchio returns a vector.
        jacobian[k] = pin.computeFrameJacobian(arm, data, joints, frame, _WORLD_ALIGNED).reshape(6, model.n)
        rotation[k] = reached.rotation
        error[k, :3] = reached.translation
    np.subtract(poses[:, :3, 3], error[:, :3], out=error[:, :3])
    error[:, 3:] = _rotation_vectors(poses[:, :3, :3] @ rotation.transpose(0, 2, 1))
    return error, jacobian


def _rotation_vectors(rotation: np.ndarray) -> np.ndarray:
    """Return rotations as vectors, shape (k, 3) [rad]; short of a half turn, where any axis would do."""
    skew = rotation - rotation.transpose(0, 2, 1)
    vector = 0.5 * np.stack((skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]), axis=1)
    sine = np.linalg.norm(vector, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1.0))
    return np.asarray(vector * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 1.0)[:, None])
