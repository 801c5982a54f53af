"""mine.py: feedback linearisation with a PD outer law."""

from dataclasses import dataclass

import numpy as np
from torquebench import Controller, Observation, Target, Task


@dataclass(kw_only=True)
class Mine(Controller):
    stiffness: float = 400.0  # [1/s^2]
    damping: float = 40.0  # [1/s]

    def reset(self, task: Task) -> None:
        self.robot = task.robot

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        acceleration = target.ddq + self.stiffness * error + self.damping * error_rate
        return self.robot.inverse_dynamics(observation.q, observation.dq, acceleration)
