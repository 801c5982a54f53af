"""Pose errors in batches: what inverse kinematics steps by."""

import numpy as np
import pytest
from torquebench.controllers.pose_errors import pose_errors


@pytest.mark.parametrize("n", [2, 6, 7])
def test_a_small_joint_step_leaves_the_error_that_the_jacobian_says(arm_of, rng, n):
    """To first order error = J dq: the Newton step's whole reason."""
    arm = arm_of(n)
    q = rng.uniform(-1.0, 1.0, (5, n))
    step = 1e-6 * rng.normal(size=(5, n))
    poses = np.array([arm.forward_kinematics(joints) for joints in q + step])
    error, jacobian = pose_errors(arm, q, poses, arm.tool_id)
    assert error == pytest.approx(np.einsum("kij,kj->ki", jacobian, step), abs=1e-11)
    assert jacobian[0] == pytest.approx(arm.jacobian(q[0]))


def test_the_flange_may_be_asked_for_in_place_of_the_tool(arm_of, rng):
    """Training postures are flange poses, whatever tool hangs there."""
    arm = arm_of(6)
    q = rng.uniform(-1.0, 1.0, (3, 6))
    poses = np.array([arm.flange_pose(joints) for joints in q])
    error, _ = pose_errors(arm, q, poses, arm.flange_id)
    assert error == pytest.approx(np.zeros((3, 6)), abs=1e-12)


def test_a_turn_is_its_rotation_vector_in_base_axes(arm_of):
    """A known turn about a base axis, up to nearly half a turn."""
    arm = arm_of(6)
    q = np.array([[0.3, -0.4, 0.2, 0.5, -0.1, 0.6]])
    pose = arm.forward_kinematics(q[0])
    for angle in (1e-9, 0.5, 3.0):
        turned = pose.copy()
        c, s = np.cos(angle), np.sin(angle)
        turned[:3, :3] = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ pose[:3, :3]
        error, _ = pose_errors(arm, q, turned[None], arm.tool_id)
        assert error[0] == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.0, angle], rel=1e-6, abs=1e-12)
