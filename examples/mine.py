"""A controller of one's own: joint PD with gravity compensation."""

import numpy as np


class Mine:
    """Torque from position and velocity error; the gravity of whatever load the task lets it know."""

    def __init__(self, stiffness=400.0, damping=40.0):
        self.stiffness, self.damping = stiffness, damping

    def reset(self, task):
        """Take the model; it carries the payload that the task's knowledge level grants."""
        self.robot = task.robot

    def compute(self, observation, target) -> np.ndarray:
        """Return the joint torque, shape (n,) [N m]."""
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        return self.stiffness * error + self.damping * error_rate + self.robot.gravity(observation.q)
