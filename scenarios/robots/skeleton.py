"""An arm's chain as plain numbers: all that a program without a rigid-body library needs to draw it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..axes import rotation_from_rpy
from .capsules import capsules_between
from .robot import TOOL_LINK, Robot

ARM, TOOL = 0.05, 0.02
"""Radius of what is drawn of an arm without capsules of its own, and of what carries the tool point [m]."""
DIGITS = 9


@dataclass(frozen=True, kw_only=True)
class Skeleton:
    """Frames, each placed in an earlier one, and the capsules that hang on them; frame 0 is the base.

    Attributes:
        frames: For each frame after the base: number of its parent, pose in it at rest (row-major, shape (12,) of the
            upper 3 x 4 [m]), kind of its joint, axis in the frame, and which joint position moves it, -1 for none.
        capsules: For each capsule: number of its frame, start (3) and end (3) in the frame, radius [m].
        tool: Number of the frame of the tool point.
    """

    frames: tuple[tuple[int, tuple[float, ...], str, tuple[float, ...], int], ...]
    capsules: tuple[tuple[float, ...], ...]
    tool: int


def skeleton(robot: Robot) -> Skeleton:
    """Return the chain of an arm up to its tool point.

    Args:
        robot: The arm.
    """
    description = robot.equipped
    joints = sorted(description.joints, key=lambda joint: len(description.chain(joint.child)))
    base = next(link.name for link in description.links if description.carrier(link.name) is None)
    numbers = {base: 0} | {joint.child: index for index, joint in enumerate(joints, start=1)}
    moved = {joint.name: index for index, joint in enumerate(description.moving)}
    frames = []
    for joint in joints:
        pose = np.column_stack([rotation_from_rpy(np.array(joint.rpy)), joint.xyz])
        axis = tuple(float(x) for x in joint.axis)
        frames.append((numbers[joint.parent], _rounded(pose), joint.kind, axis, moved.get(joint.name, -1)))
    drawn = description.capsules or capsules_between(robot.description.joints, ARM)
    drawn += capsules_between((joint for joint in joints if joint.child == TOOL_LINK), TOOL)
    capsules = tuple((numbers[c.link], *_rounded(c.start), *_rounded(c.end), c.radius) for c in drawn)
    return Skeleton(frames=tuple(frames), capsules=capsules, tool=numbers[TOOL_LINK])


def _rounded(values: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    # A quarter turn leaves 6e-17 where 0 is meant; adding 0 takes the sign off a zero.
    return tuple(float(value) for value in np.round(np.ravel(np.asarray(values, dtype=float)), DIGITS) + 0.0)
