"""One tick at rest, so that compiled laws load during reset and not in the first timed call."""

import numpy as np

from ..controllers import Observation, Target, Task


def tick_at_rest(task: Task) -> tuple[Observation, Target]:
    """Return observation and target of the arm at rest where the episode starts, read-only as the harness's are.

    Args:
        task: The episode.
    """
    n, q = task.robot.n, _fixed(task.initial_q)
    still, wrench = _fixed(np.zeros(n)), _fixed(np.zeros(6))
    gravity, pose = _fixed(task.robot.gravity(q)), _fixed(task.robot.forward_kinematics(q))
    observation = Observation(time=0.0, q=q, dq=still, wrench=wrench, command=gravity, torque=gravity)
    target = Target(q=q, dq=still, ddq=still, pose=pose, twist=wrench, acceleration=wrench, reference=task.reference)
    return observation, target


def _fixed(array: np.ndarray) -> np.ndarray:
    copy = np.array(array, dtype=float)
    copy.flags.writeable = False
    return copy
