"""Generalised momentum observer: the torque that acts on the joints besides the drives', without accelerations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
import pinocchio as pin

from ..controllers import Actuation, LedgerEntry, Observation, PayloadTruth, RobotModel
from ..controllers.kernels import bind
from .settings import require_positive


@dataclass(kw_only=True)
class MomentumObserver:
    r"""Knowledge level that tells the model which torque it does not explain, whatever its origin.

    With the momentum :math:`p = M(q) \dot q` of arm and gripper,

    .. math:: r = K \Big( p - p_0 - \int (\tau + C^T \dot q - g + r) \, dt \Big), \quad \dot r = K (\tau_{ext} - r)

    so that r, shape (n,) [N m], follows the unknown torque as a first-order filter of time constant 1/K. It is told
    to the model as its disturbance, with the same sign: what acts on the arm besides the command. A load at rest
    gives :math:`J^T f`, minus its gravity torque.

    The residual cannot tell a load from anything else: it holds the drives' friction and every error of the model
    too, and the load's inertia only as the torque that it costs at the moment. No payload is ever set.

    In discrete time the residual moves by :math:`1 - e^{-K h}` of its error, which is stable for every gain; the
    drives' torque passes the velocity sensor's published filter, so that both sides of the balance are equally late.
    What is compensated from the residual closes a loop through drives and sensors, and the encoders' noise grows with
    the gain: on the usual tier Cartesian impedance with full feed-forward holds at 85 1/s and fails at 100 1/s.

    Source: De Luca, Albu-Schaeffer, Haddadin, Hirzinger, Collision detection and safe reaction with the DLR-III
    lightweight manipulator arm (IROS 2006).

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
        return self._residual.copy()

    def reset(self, robot: RobotModel, actuation: Actuation, truth: PayloadTruth) -> None:
        """Forget everything; what the plant carries is not looked at."""
        robot.set_payload(np.zeros(10))
        n, self.robot = robot.n, robot
        self._model, self._data = robot.model, robot.model.createData()
        self._dq, self._torque, self._residual = np.zeros(n), np.zeros(n), np.zeros(n)
        # Rows: the momentum, the drive before the filter and after it, as the last refresh left them.
        self._memory, self._begun = np.zeros((3, n)), np.zeros(1, np.int64)
        corner = actuation.velocity_filter_hz
        filter_gain = 1.0 if corner is None else 1.0 - float(np.exp(-2.0 * np.pi * corner * self.period))
        constants = (1.0 - float(np.exp(-self.gain * self.period)), filter_gain, self.period)
        dynamics = (self._data.M, self._data.C, self._data.g)
        state = (self._dq, self._torque, self._memory, self._begun)
        self._update = bind(_observe, dynamics, state, constants, self._residual)

    def refresh(self, observation: Observation) -> None:
        """Take one tick into account and tell the model."""
        model, data, q = self._model, self._data, observation.q
        pin.computeCoriolisMatrix(model, data, q, observation.dq)
        pin.computeGeneralizedGravity(model, data, q)
        pin.crba(model, data, q)
        np.copyto(self._dq, observation.dq)
        np.copyto(self._torque, observation.torque)
        self._update()
        self.robot.set_disturbance(self._residual)

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from."""
        stable = "impedance with full feed-forward holds at 85 and fails at 100 on the usual tier [1/s]"
        return (
            LedgerEntry(setting="gain", value=self.gain, source="chosen", note=stable),
            LedgerEntry(setting="period", value=self.period, source="chosen", note="the harness's tick [s]"),
        )


@numba.njit(cache=True)
def _observe(dynamics, state, constants, residual):  # type: ignore[no-untyped-def]
    """Move the residual by one tick.

    Args:
        dynamics: Mass matrix, Coriolis matrix, gravity torque at the state that was measured.
        state: Velocity, torque that acted in the last tick, memory, whether there is a last tick.
        constants: Shares by which residual and drive approach their aims in a tick, period [s].
        residual: Unexplained torque, refilled, shape (n,) [N m].
    """
    mass, coriolis, gravity = dynamics
    dq, torque, memory, begun = state
    share, filter_share, period = constants
    for i in range(dq.shape[0]):
        momentum, passive = 0.0, -gravity[i]
        for j in range(dq.shape[0]):
            momentum += mass[i, j] * dq[j]
            passive += coriolis[j, i] * dq[j]
        if begun[0]:
            # The torque acted between two readings: what else drives the arm is their mean.
            drive = torque[i] + 0.5 * (passive + memory[1, i])
            memory[2, i] += filter_share * (drive - memory[2, i])
            residual[i] += share * ((momentum - memory[0, i]) / period - memory[2, i] - residual[i])
        memory[0, i], memory[1, i] = momentum, passive
    begun[0] = 1
