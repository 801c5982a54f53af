"""What training needs to know of robots, loads and paths; joins the rooms that do not know each other."""

import hashlib

import numpy as np

from .cbmc.training import PRESETS, Lesson, Workspace
from .controllers import InvalidInput
from .scenarios.materials import SAND_DENSITY, sand
from .scenarios.robots import Robot
from .scenarios.trajectories import Plan, suite
from .scenarios.trajectories.kinematics import facing_posture

CIRCLES = ("S1", "S2")
"""The paper's training circles: horizontal and inclined."""
CONTENT = 2.0
"""Content whose centre stands for that of all loads, if the container holds it [kg]."""


def workspace_of(robot: Robot) -> Workspace:
    """Return an arm with the paths of the suite that it can follow.

    Args:
        robot: The arm.
    """
    model = robot.model()
    paths = joint_paths(robot)
    return Workspace(
        model=model,
        home=robot.home,
        facing=lambda point: facing_posture(model, robot.home, (float(point[0]), float(point[1]), float(point[2]))),
        paths=paths,
        circles={name: paths[name] for name in CIRCLES if name in paths},
    )


def joint_paths(robot: Robot) -> dict[str, np.ndarray]:
    """Return the joint paths of the suite's motions that an arm can follow, each of shape (N, n) [rad].

    Args:
        robot: The arm.
    """
    paths = {}
    for name, path in suite().items():
        try:
            paths[name] = Plan.build(robot, path, lead_in=1.0).q
        except InvalidInput:
            # An arm of another size or fewer joints: it is judged on what it can do.
            continue
    return paths


def load_centre(robot: Robot) -> float:
    """Return where a load's centre is taken to be along z of the flange: where the content sits [m].

    Args:
        robot: Whose container.
    """
    content = min(CONTENT, SAND_DENSITY * robot.container.volume)
    return round(float(sand(content, robot.container).com[2]), 4)


def lesson_for(robot: Robot, *, loads: tuple[float, ...], training_set: str, preset: str, seed: int) -> Lesson:
    """Return what is to be learnt for a robot.

    Args:
        robot: The arm.
        loads: Masses beyond the gripper [kg].
        training_set: Name of the set; empty for the preset's own.
        preset: Name of the recipe.
        seed: Seed of everything that is drawn.
    """
    own = "paper" if preset in PRESETS and PRESETS[preset].optimiser == "sgd" else "workspace"
    return Lesson(
        robot=robot.name,
        urdf_digest=hashlib.sha256(robot.urdf.encode()).hexdigest(),
        loads=loads,
        load_centre=load_centre(robot),
        training_set=training_set or own,
        preset=preset,
        seed=seed,
    )
