r"""Postures that hold the flange at many poses at once, each the one closest to a posture of its own.

.. math:: q = \arg\min_q |q - q_r|^2 \quad \text{subject to} \quad FK(q) = X

The rule by which the benchmark's paths choose among the solutions of a redundant arm, so that what is learnt here
lies where the arm will be. Newton steps :math:`\Delta q = J^+ e + (I - J^+ J)(q_r - q)` for all poses together; a
tolerance far below the spread that training adds is enough.
Source: Siciliano et al., Robotics (2009), section 3.5.1.
"""

import numpy as np

from ...controllers import RobotModel
from ...controllers.pose_errors import pose_errors

STEP_LIMIT = 0.3
"""Largest norm of one step [rad]."""
POSE_TOLERANCE = 1e-5
"""Pose error at which a pose counts as reached [m, rad]."""
CLOSENESS = 1e-3
"""Step within the redundancy at which a posture counts as closest [rad]."""
STEPS = 80
DAMPING = 1e-6
"""Added to the diagonal of J J^T: a pose out of reach must not end the search for all others."""


def closest_postures(model: RobotModel, poses: np.ndarray, wishes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return joint positions that reach flange poses, closest to wished postures.

    Args:
        model: The arm.
        poses: Flange poses in the base frame, shape (k, 4, 4) [m].
        wishes: Posture to stay close to for each pose, shape (k, n) [rad].

    Returns:
        Joint positions, shape (k, n) [rad], and whether each reaches its pose within the joint limits, shape (k,).
    """
    q = np.array(wishes, dtype=float)
    reached = np.zeros(len(q), dtype=bool)
    active = np.arange(len(q))
    for _ in range(STEPS):
        error, jacobian = pose_errors(model, q[active], poses[active], model.flange_id)
        wish = wishes[active] - q[active]
        null = wish - _least_norm(jacobian, np.einsum("kij,kj->ki", jacobian, wish))
        settled = (np.abs(error).max(axis=1) < POSE_TOLERANCE) & (np.abs(null).max(axis=1) < CLOSENESS)
        reached[active[settled]] = True
        move = (_least_norm(jacobian, error) + null)[~settled]
        active = active[~settled]
        if not len(active):
            break
        length = np.linalg.norm(move, axis=1, keepdims=True)
        q[active] += move * np.minimum(1.0, STEP_LIMIT / np.maximum(length, STEP_LIMIT))
    inside = np.all((q >= model.lower) & (q <= model.upper), axis=1)
    return q, reached & inside


def _least_norm(jacobian: np.ndarray, task: np.ndarray) -> np.ndarray:
    """Return the shortest joint steps for task steps of shape (k, 6), shape (k, n)."""
    transpose = jacobian.transpose(0, 2, 1)
    square = jacobian @ transpose + DAMPING * np.eye(6)
    return np.asarray((transpose @ np.linalg.solve(square, task[..., None]))[..., 0])
