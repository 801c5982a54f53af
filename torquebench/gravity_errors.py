"""Joins rooms: how well the patterns that a run's cerebellum was given know gravity on the suite's motions."""

from collections.abc import Mapping
from functools import cache

import numpy as np

from .cbmc.controller import CbmcV3
from .cbmc.patterns import find_patterns
from .cbmc.point_payload import point_payload
from .cbmc.training import answers, evaluation_groups, gravity_torques
from .controllers import TorquebenchError, discovery
from .evaluation.metrics import gravity_torque_nrmse
from .scenarios.robots import load_robot
from .scenarios.specification import RunSpecification
from .training import joint_paths, load_centre


def gravity_errors_of(specification: RunSpecification) -> Mapping[str, Mapping[float, float]] | None:
    """Return motion to load of a pattern [kg] to the error of its torque, as a share of the gravity torque.

    The model's gravity with the load that the pattern was trained for is what is right.

    Args:
        specification: A run.

    Returns:
        None if its controller has no patterns, or they or its robot are no longer where it found them.
    """
    if specification.controller not in discovery.names("controllers"):
        return None
    factory = discovery.load("controllers", specification.controller)
    if not (isinstance(factory, type) and issubclass(factory, CbmcV3)):
        return None
    try:
        return _errors(specification.robot, str(specification.settings.get("patterns", "")))
    except TorquebenchError:
        # A report is often read where the runs were not made.
        return None


@cache
def _errors(robot: str, file: str) -> Mapping[str, Mapping[float, float]]:
    arm = load_robot(robot)
    model, centre = arm.model(), load_centre(arm)
    patterns = find_patterns(model, file)
    found: dict[str, dict[float, float]] = {}
    for motion, q in evaluation_groups(joint_paths(arm), np.empty((0, model.n))).items():
        if len(q):
            said = answers(patterns, q)
            right = [gravity_torques(model, q, point_payload(load, centre)) for load in patterns.loads]
            found[motion] = {
                load: gravity_torque_nrmse(said[:, index], right[index]) for index, load in enumerate(patterns.loads)
            }
    return found
