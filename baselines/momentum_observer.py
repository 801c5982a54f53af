"""Generalised momentum observer: the torque that acts on the joints besides the drives', as a knowledge level."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..controllers import Actuation, LedgerEntry, Observation, PayloadTruth, RobotModel
from .momentum_residual import MomentumResidual
from .settings import require_positive


@dataclass(kw_only=True)
class MomentumObserver:
    r"""Tells the model which torque it does not explain, whatever its origin: the momentum residual of arm and gripper.

    The residual is told to the model as its disturbance, with the same sign: what acts on the arm besides the command.
    A load at rest gives :math:`J^T f`, minus its gravity torque. See
    :class:`~torquebench.baselines.momentum_residual.MomentumResidual` for its law and source.

    The residual cannot tell a load from anything else: it holds the drives' friction and every error of the model
    too, and the load's inertia only as the torque that it costs at the moment. No payload is ever set.

    What is compensated from the residual closes a loop through drives and sensors, and the encoders' noise grows with
    the gain: on the usual tier Cartesian impedance with full feed-forward holds at 85 1/s and fails at 100 1/s.

    Attributes:
        gain: K, the inverse of the residual's time constant [1/s].
        period: Time between two refreshes [s].
    """

    gain: float = 50.0
    period: float = 1e-3

    def __post_init__(self) -> None:
        """Check the settings."""
        require_positive("gain", self.gain)
        require_positive("period", self.period)

    @property
    def residual(self) -> np.ndarray:
        """Unexplained torque, shape (n,), a copy [N m]."""
        return self._residual.torque.copy()

    def reset(self, robot: RobotModel, actuation: Actuation, truth: PayloadTruth) -> None:
        """Forget everything; what the plant carries is not looked at."""
        robot.set_payload(np.zeros(10))
        self.robot = robot
        self._residual = MomentumResidual(robot, actuation, gain=self.gain, period=self.period)

    def refresh(self, observation: Observation) -> None:
        """Take one tick into account and tell the model."""
        self._residual.update(observation)
        self.robot.set_disturbance(self._residual.torque)

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from."""
        stable = "impedance with full feed-forward holds at 85 and fails at 100 on the usual tier [1/s]"
        return (
            LedgerEntry(setting="gain", value=self.gain, source="chosen", note=stable),
            LedgerEntry(setting="period", value=self.period, source="chosen", note="the harness's tick [s]"),
        )
