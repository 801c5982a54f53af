"""The skeleton of an arm: without a rigid-body library it must put the tool point where Pinocchio puts it."""

from dataclasses import replace

import numpy as np
import pytest
from torquebench.scenarios.robots import rizon4s, skeleton
from torquebench.scenarios.robots.skeleton import ARM


def poses_of(bones, q):
    """Evaluate a skeleton as its description says, frame by frame."""
    found = [np.eye(4)]
    for parent, rest, kind, axis, joint in bones.frames:
        pose = np.eye(4)
        pose[:3] = np.reshape(rest, (3, 4))
        moved = np.eye(4)
        if joint >= 0 and kind == "prismatic":
            moved[:3, 3] = q[joint] * np.array(axis)
        elif joint >= 0:
            x, y, z = axis
            cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            moved[:3, :3] = np.eye(3) + np.sin(q[joint]) * cross + (1 - np.cos(q[joint])) * cross @ cross
        found.append(found[parent] @ pose @ moved)
    return found


def test_the_tool_point_is_where_the_rigid_body_library_puts_it():
    """A replay that bends another way than the arm did would be believed."""
    robot = rizon4s()
    bones, model = skeleton(robot), robot.model()
    rng = np.random.default_rng(3)
    for q in rng.uniform(robot.lower, robot.upper, (20, robot.n)):
        assert poses_of(bones, q)[bones.tool] == pytest.approx(model.forward_kinematics(q), abs=1e-8)


def test_frames_come_after_what_carries_them():
    """Whoever draws goes through them once."""
    bones = skeleton(rizon4s())
    assert all(parent <= number for number, (parent, *_) in enumerate(bones.frames))
    assert sorted(frame[4] for frame in bones.frames if frame[4] >= 0) == list(range(7))
    assert all(0 <= frame <= len(bones.frames) for frame, *_ in bones.capsules)


def test_an_arm_without_capsules_gets_some_between_its_joints():
    """A bare URDF has no shape, and a replay of nothing shows nothing."""
    robot = rizon4s()
    bare = replace(robot, description=replace(robot.description, capsules=()))
    bones = skeleton(bare)
    assert len(bones.capsules) >= robot.n - 2
    assert bones.capsules[0][-1] == ARM
