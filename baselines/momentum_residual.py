"""The torque that a model does not explain, from its generalised momentum: no accelerations needed."""

import numba
import numpy as np
import pinocchio as pin

from ..controllers import Actuation, Observation, RobotModel
from ..controllers.kernels import bind


class MomentumResidual:
    r"""The unexplained torque as a first-order filter of time constant 1/K follows it.

    With the momentum :math:`p = M(q) \dot q` of what the model knows,

    .. math:: r = K \Big( p - p_0 - \int (\tau + C^T \dot q - g + r) \, dt \Big), \quad \dot r = K (\tau_{ext} - r)

    In discrete time the residual moves by :math:`1 - e^{-K h}` of its error, which is stable for every gain; the
    drives' torque passes the velocity sensor's published filter, so that both sides of the balance are equally late.
    Source: De Luca, Albu-Schaeffer, Haddadin, Hirzinger, Collision detection and safe reaction with the DLR-III
    lightweight manipulator arm (IROS 2006).

    Attributes:
        torque: r, refilled by each update, shape (n,) [N m].
    """

    def __init__(self, robot: RobotModel, actuation: Actuation, *, gain: float, period: float) -> None:
        """Allocate, with nothing unexplained.

        Args:
            robot: The model, with whatever payload it knows.
            actuation: The tier's published facts.
            gain: K [1/s].
            period: Time between two updates [s].
        """
        self._robot, self._model, self._data = robot, robot.model, robot.model.createData()
        n = robot.n
        self._dq, self._drive, self.torque = np.zeros(n), np.zeros(n), np.zeros(n)
        # Rows: the momentum, the drive before the filter and after it, as the last update left them.
        self._memory, self._begun = np.zeros((3, n)), np.zeros(1, np.int64)
        self._payload = robot.payload.copy()
        corner = actuation.velocity_filter_hz
        filter_gain = 1.0 if corner is None else 1.0 - float(np.exp(-2.0 * np.pi * corner * period))
        constants = (1.0 - float(np.exp(-gain * period)), filter_gain, period)
        dynamics = (self._data.M, self._data.C, self._data.g)
        state = (self._dq, self._drive, self._memory, self._begun)
        self._observe = bind(_observe, dynamics, state, constants, self.torque)

    def update(self, observation: Observation) -> None:
        """Take one tick into account.

        Args:
            observation: What was measured in it.
        """
        model, data, q = self._model, self._data, observation.q
        if not np.array_equal(self._payload, self._robot.payload):
            # Another payload has another momentum at the same velocity, which no torque has made.
            np.copyto(self._payload, self._robot.payload)
            self._begun[0] = 0
        pin.computeCoriolisMatrix(model, data, q, observation.dq)
        pin.computeGeneralizedGravity(model, data, q)
        pin.crba(model, data, q)
        np.copyto(self._dq, observation.dq)
        np.copyto(self._drive, observation.torque)
        self._observe()


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
