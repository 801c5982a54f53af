"""Payload knowledge: what ``task.robot`` is told about the load, for every model-based law alike."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .observation import Observation
from .robot_model import RobotModel
from .task import Actuation

STANDARD_LEVELS = ("none", "ft_estimate", "momentum_observer", "oracle")
"""Levels that a benchmark which names none runs; any other level, a plug-in's too, runs only where it is named."""


@dataclass(kw_only=True)
class PayloadTruth:
    """What the plant carries beyond the gripper, as the harness drew it; for the level ``oracle`` only.

    Attributes:
        parameters: Mass, first moments and inertia about the flange origin, shape (10,) [kg, kg m, kg m^2].
        revision: Grows when the load changes.
    """

    parameters: np.ndarray
    revision: int = 0


class KnowledgeProvider(Protocol):
    """Refreshes the model's payload or disturbance; its time counts as the controller's.

    A provider with settings may say where they come from by a method ``ledger``, as controllers do.
    """

    def reset(self, robot: RobotModel, actuation: Actuation, truth: PayloadTruth) -> None:
        """Set the model for the first tick."""
        ...

    def refresh(self, observation: Observation) -> None:
        """Set the model before one call of ``compute``."""
        ...


class NoKnowledge:
    """Arm and gripper only."""

    def reset(self, robot: RobotModel, actuation: Actuation, truth: PayloadTruth) -> None:
        """Clear payload and disturbance."""
        robot.set_payload(np.zeros(10))

    def refresh(self, observation: Observation) -> None:
        """Do nothing: nothing is known."""


class Oracle:
    """The true payload, known at the tick at which it changes; not the plant's friction or link errors."""

    def reset(self, robot: RobotModel, actuation: Actuation, truth: PayloadTruth) -> None:
        """Take the first load."""
        self.robot, self.truth = robot, truth
        robot.set_payload(truth.parameters)
        self.revision = truth.revision

    def refresh(self, observation: Observation) -> None:
        """Follow the load when it changed."""
        if self.revision != self.truth.revision:
            self.robot.set_payload(self.truth.parameters)
            self.revision = self.truth.revision
