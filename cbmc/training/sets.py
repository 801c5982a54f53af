"""What the patterns are trained on: postures, of which gravity gives the labels.

``workspace`` never sees a path of the benchmark: the tool points straight down, anywhere in front of the arm or to its
left. ``tube`` adds the neighbourhood of given paths. ``paper`` is the paper's own, two circles and nothing else.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...controllers import InvalidInput, RobotModel, UnknownName
from .postures import closest_postures

SETS = ("workspace", "tube", "paper")
"""Names of the sets."""
TOOL_DOWN = np.diag([-1.0, 1.0, -1.0])
"""Rotation of the flange in the base frame on all of the benchmark's paths: axis down, one yaw."""
RADIUS = (0.36, 0.80)
"""Horizontal distance of the flange from the first axis, in arm lengths: 0.38 to 0.84 m of the Rizon."""
HEIGHT = (-0.60, 0.33)
"""Height of the flange above the shoulder, in arm lengths: -0.26 to 0.71 m above the Rizon's base."""
AZIMUTH = (-0.75, np.pi / 2.0 + 0.85)
"""Directions of the flange [rad]: from in front of the arm to its left side, where the paths lie."""
FACING = 0.35
"""Largest angle between a point and the centre of the path that may lead through it, which the arm faces [rad]."""
SPREAD = 0.1
"""Half width of the noise around a workspace posture, each joint [rad]."""
TUBE = 0.2
"""Half width of the noise around a path, each joint [rad]."""
DRAWS = 12_000
"""Flange points that are tried."""
ENOUGH = 0.05
"""Share of points that must be reachable; an arm that reaches fewer cannot hold its tool down."""
BOX = 1.0
"""Half width around home of the postures of such an arm [rad]."""

Facing = Callable[[np.ndarray], np.ndarray]
"""Returns the posture, shape (n,) [rad], in which an arm faces a point, shape (3,) [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Workspace:
    """An arm and how it is used.

    Attributes:
        model: Arm and gripper.
        home: Home position, shape (n,) [rad].
        facing: The posture in which it faces a point.
        paths: Joint paths by name, each of shape (N, n) [rad]; trained on by ``tube`` only.
        circles: The paper's two training circles, in the same form.
    """

    model: RobotModel
    home: np.ndarray
    facing: Facing
    paths: Mapping[str, np.ndarray]
    circles: Mapping[str, np.ndarray]


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainingSet:
    """Postures to learn from.

    Attributes:
        name: One of :data:`SETS`.
        parts: Postures, each of shape (N_i, n) [rad]; a recipe that trains path after path keeps them apart.
        held_out: Workspace postures of which none is in ``parts``, shape (2000, n) [rad].
    """

    name: str
    parts: tuple[np.ndarray, ...]
    held_out: np.ndarray

    @property
    def q(self) -> np.ndarray:
        """All postures, shape (N, n) [rad]."""
        return np.concatenate(self.parts)


def training_set(name: str, arm: Workspace, *, samples: int, rng: np.random.Generator) -> TrainingSet:
    """Return a training set.

    Args:
        name: One of :data:`SETS`.
        arm: The arm and its paths.
        samples: Number of postures; ``paper`` takes its circles as they are.
        rng: Where all draws come from.

    Raises:
        UnknownName: If there is no such set.
        InvalidInput: If the set needs paths and the arm can follow none of them.
    """
    if name not in SETS:
        raise UnknownName("training set", name, SETS)
    postures = workspace_postures(arm, rng, draws=min(DRAWS, samples))
    # Whole base postures are held out, not only other noise around the ones that training sees.
    held, base = postures[: len(postures) // 10], postures[len(postures) // 10 :]
    held_out = _around([held], 2000, SPREAD, rng)
    if name == "paper":
        return TrainingSet(name=name, parts=_given(arm.circles, name), held_out=held_out)
    if name == "workspace":
        return TrainingSet(name=name, parts=(_around([base], samples, SPREAD, rng),), held_out=held_out)
    half = samples // 2
    tube = _around(_given(arm.paths, name), half, TUBE, rng)
    return TrainingSet(name=name, parts=(tube, _around([base], samples - half, SPREAD, rng)), held_out=held_out)


def workspace_postures(arm: Workspace, rng: np.random.Generator, *, draws: int = DRAWS) -> np.ndarray:
    """Return postures with the tool down, spread evenly over radius, height and azimuth of the flange.

    Radius and height are shares of the arm's length (:func:`arm_length`), counted from its shoulder. Each posture is
    the closest to one that faces a point near by, as on a path that leads through it. An arm that reaches hardly any
    of the points, for example one of fewer than six joints, gets postures from a box around home instead.

    Args:
        arm: The arm.
        rng: Where the points come from.
        draws: Number of points that are tried.
    """
    model = arm.model
    shoulder, length = arm_length(model)
    low, high = np.array([RADIUS, HEIGHT, AZIMUTH]).T
    radius, height, azimuth = rng.uniform(low, high, size=(draws, 3)).T
    faced = azimuth + rng.uniform(-FACING, FACING, size=draws)
    if model.n >= 6:
        poses = np.tile(np.eye(4), (draws, 1, 1))
        poses[:, :3, :3] = TOOL_DOWN
        poses[:, :3, 3] = _cylindrical(length * radius, azimuth, shoulder + length * height)
        targets = _cylindrical(length * radius, faced, shoulder + length * height)
        q, reached = closest_postures(model, poses, np.array([arm.facing(target) for target in targets]))
        if np.mean(reached) >= ENOUGH:
            return np.asarray(q[reached])
    low, high = np.maximum(arm.home - BOX, model.lower), np.minimum(arm.home + BOX, model.upper)
    return rng.uniform(low, high, size=(draws, model.n))


def arm_length(model: RobotModel) -> tuple[float, float]:
    """Return the height of the shoulder, the second joint, and the length of all links from there to the flange [m].

    The length is the sum of the distances between neighbouring frames: 1.05 m for the Rizon 4s.
    """
    placements = [np.array(placement.translation) for placement in model.model.jointPlacements][1:]
    flange = np.array(model.model.frames[model.flange_id].placement.translation)
    shoulder = sum(float(placement[2]) for placement in placements[:2])
    return shoulder, float(sum(np.linalg.norm(offset) for offset in [*placements[2:], flange]))


def _cylindrical(radius: np.ndarray, azimuth: np.ndarray, height: np.ndarray) -> np.ndarray:
    return np.stack((radius * np.cos(azimuth), radius * np.sin(azimuth), height), axis=1)


def _around(paths: Sequence[np.ndarray], count: int, spread: float, rng: np.random.Generator) -> np.ndarray:
    """Return random postures of random paths with uniform noise, shape (count, n) [rad]."""
    which = rng.integers(len(paths), size=count)
    place = rng.random(count)
    base = np.array([paths[i][int(u * len(paths[i]))] for i, u in zip(which, place, strict=True)])
    return base + rng.uniform(-spread, spread, size=base.shape)


def _given(paths: Mapping[str, np.ndarray], name: str) -> tuple[np.ndarray, ...]:
    if not paths:
        raise InvalidInput("the arm can follow none of the paths that it needs", f"training set {name!r}")
    return tuple(paths.values())
