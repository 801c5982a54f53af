"""Model predictive control with a disturbance state: an unknown load leaves no offset behind."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..controllers import Observation, Target, Task
from .momentum_residual import MomentumResidual
from .mpc import Mpc
from .settings import require_positive


@dataclass(kw_only=True)
class MpcOffsetFree(Mpc):
    r"""The same law with the torque that its model does not explain as a further state.

    .. math:: \tau = M(q) u + h(q, \dot q) - d, \quad \dot d = K (\tau_{ext} - d)

    The disturbance d is held over the horizon, enters the torque rows of every plan and is compensated at every tick.
    Its observer is :class:`torquebench.baselines.momentum_residual.MomentumResidual` on the model that the law was
    given, so that with a known load it holds what is left: friction and model error.
    Source: Pannocchia, Rawlings, Disturbance models for offset-free model-predictive control, AIChE J. 49 (2003).

    Attributes:
        observer_gain: K [1/s].
    """

    observer_gain: float = 50.0

    estimates_load: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        require_positive("observer_gain", self.observer_gain)

    def reset(self, task: Task) -> None:
        """Compile or load the model's equations, and allocate for one episode."""
        self._actuation = task.actuation
        super().reset(task)

    def _begin(self) -> None:
        super()._begin()
        self._residual = MomentumResidual(self.robot, self._actuation, gain=self.observer_gain, period=self.period)
        self._disturbance = self._residual.torque

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        self._residual.update(observation)
        torque = super().compute(observation, target)
        torque -= self._residual.torque
        return torque
