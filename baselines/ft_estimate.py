"""Payload from the force and torque sensor: a Kalman filter for mass, first moments and the sensor's own bias."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import ClassVar

import numpy as np
import pinocchio as pin

from ..controllers import Actuation, LedgerEntry, Observation, PayloadTruth, RobotModel
from ..controllers.kernels import bind
from .ft_filter import CENTRED, CONSTANTS, memory_dtype, weigh
from .settings import require_not_negative, require_positive

CHOSEN: dict[str, str] = {
    "corner": "two in a row, for regressor and wrench alike [Hz]",
    "force_noise": "twice the usual tier's, for what the filtered accelerations add [N]",
    "torque_noise": "four times the usual tier's, for the same reason [N m]",
    "force_bias": "the usual tier's spread [N]",
    "torque_bias": "the usual tier's spread [N m]",
    "mass_spread": "the heaviest content [kg]",
    "moment_spread": "about the expected centre [kg m]",
    "mass_drift": "so that the filter does not fall asleep [kg/sqrt(s)]",
    "moment_drift": "so that the filter does not fall asleep [kg m/sqrt(s)]",
    "jump": "squared innovation over its variance; finds 0.5 kg, not 0.2 kg",
    "jump_ticks": "in a row, so that one outlier is no step",
    "reopen": "until the second filter has settled [s]",
    "mass_limit": "bound on what the model is told [kg]",
    "reach": "bound on what the model is told, per axis [m]",
    "radius": "of the ball whose inertia stands for the load's, which is not seen [m]",
    "resolution": "the model is refreshed at once from here on [kg]",
    "interval": "between smaller corrections [s]",
    "period": "the harness's tick [s]",
    "inertia_spread": "about that of the ball [kg m^2]",
    "inertia_drift": "so that the filter does not fall asleep [kg m^2/sqrt(s)]",
    "thinnest": "extent of the load that is told, in any direction [m]",
}
"""What there is to say of each setting; all were chosen by hand."""


@dataclass(kw_only=True)
class FtEstimate:
    r"""Knowledge level that weighs the load with the flange's sensor.

    In flange axes, with the flange's acceleration less gravity :math:`a`, its angular velocity and acceleration
    :math:`\omega, \alpha`, and the sensor's bias :math:`b`, the sensor reads

    .. math:: w = b - w_{tool} - \begin{bmatrix} a & [\alpha]_\times + [\omega]_\times^2 \\ 0 & -[a]_\times
              \end{bmatrix} \begin{bmatrix} m \\ m c \end{bmatrix}

    A Kalman filter estimates m, m c and b, shape (10,). The load's rotational inertia is left out: on paths of
    constant orientation, where the data have rank four, it is not seen at all. It is supplied as that of a ball
    about the centre of mass, in the balance and in the ten parameters that the model is told, which so always belong
    to a real body.

    Motion: accelerations are differences of the flange's base-aligned velocity, from q and dq. Regressor and wrench
    pass the same two first-order filters, which leaves the equation exact and the two sides equally late. Less
    filtering would not only be noisier: noise in a regressor pulls the masses down.

    Bias: constant states with the settings' spread as prior, by default that of the usual tier. At rest a bias along
    gravity cannot be told from mass and the prior decides, that is, the bias stays in the mass (0.5 N are 0.05 kg);
    accelerations part them. A load step opens mass and moments again but keeps the bias that was learnt.

    Steps: when the normalised squared innovation exceeds ``jump`` for ``jump_ticks`` refreshes in a row, the load's
    covariance is held at its prior for ``reopen`` seconds, in which the estimate follows the first filter and the
    second settles; so every run begins. The prior couples moments to mass through the present centre of mass, before
    the first weighing the tool point: what is added is expected there.

    Source: Kubus, Kroeger, Wahl, On-line rigid object recognition and pose estimation based on inertial parameters
    (IROS 2007), for the regressor; the bias states and the reset are this project's.

    Attributes:
        corner: Corner of each of the two filters [Hz].
        force_noise: Standard deviation of a force, acceleration errors included [N].
        torque_noise: Standard deviation of a torque [N m].
        force_bias: Spread of the sensor's force bias, 0 if it has none [N].
        torque_bias: Spread of its torque bias [N m].
        mass_spread: Spread of the unknown mass [kg].
        moment_spread: Spread of the first moments about the expected centre [kg m].
        mass_drift: Random walk of the mass [kg/sqrt(s)].
        moment_drift: Random walk of the moments [kg m/sqrt(s)].
        jump: Normalised squared innovation that counts towards a step. On the usual tier a step of 0.5 kg is found;
            one of 0.2 kg is not, and is followed to 0.1 kg within 0.4 s.
        jump_ticks: How many in a row make one.
        reopen: How long the covariance stays open after a step [s].
        mass_limit: Largest mass told [kg].
        reach: Largest component of the centre of mass told [m].
        radius: Radius of the ball whose inertia is told [m].
        resolution: Mass change that is told at once [kg]; a tenth of it is told every ``interval``.
        interval: Time between two small corrections [s].
        period: Time between two refreshes [s].
        load: Number of the load's parameters that are estimated.
    """

    corner: float = 12.0
    force_noise: float = 0.2
    torque_noise: float = 0.02
    force_bias: float = 0.5
    torque_bias: float = 0.02
    mass_spread: float = 2.0
    moment_spread: float = 0.2
    mass_drift: float = 2e-3
    moment_drift: float = 2e-4
    jump: float = 60.0
    jump_ticks: int = 3
    reopen: float = 0.07
    mass_limit: float = 10.0
    reach: float = 0.5
    radius: float = 0.08
    resolution: float = 0.02
    interval: float = 0.010
    period: float = 1e-3
    load: ClassVar[int] = CENTRED

    def __post_init__(self) -> None:
        """Check the settings."""
        for name in ("force_bias", "torque_bias", "mass_drift", "moment_drift", "reopen", "resolution", "interval"):
            require_not_negative(name, getattr(self, name))
        for name in ("corner", "force_noise", "torque_noise", "mass_spread", "moment_spread", "jump", "jump_ticks"):
            require_positive(name, getattr(self, name))
        for name in ("mass_limit", "reach", "radius", "period"):
            require_positive(name, getattr(self, name))

    @property
    def estimate(self) -> np.ndarray:
        """Mass, first moments in flange axes and bias, shape (10,), a copy [kg, kg m, N, N m]."""
        return np.array(self._memory["estimate"][0])

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of :attr:`estimate`, shape (10, 10), a copy."""
        return np.array(self._memory["covariance"][0])

    @property
    def steps(self) -> int:
        """Number of load steps found since the reset."""
        return int(self._memory["steps"][0])

    def reset(self, robot: RobotModel, actuation: Actuation, truth: PayloadTruth) -> None:
        """Forget the load; what the plant carries is not looked at."""
        self.robot = robot
        robot.set_payload(np.zeros(10))
        self._model, self._data = robot.model, robot.model.createData()
        self._reading = np.zeros(6)
        self._payload = np.zeros(10)
        self._memory = np.zeros(1, memory_dtype(self.load))
        self._memory["centre"] = _tool_point(robot)
        bias = [self.force_bias**2] * 3 + [self.torque_bias**2] * 3
        self._memory["covariance"][0] = np.diag([0.0] * self.load + bias)
        self._memory["open"] = round(self.reopen / self.period) + 1
        self._update = bind(weigh, self._memory, self._constants(), self._motion(), self._reading, self._payload)

    def refresh(self, observation: Observation) -> None:
        """Weigh, and tell the model if the load has changed."""
        pin.forwardKinematics(self._model, self._data, observation.q, observation.dq)
        self._reading[:] = observation.wrench
        if self._update():
            self.robot.set_payload(self._told())

    def _told(self) -> np.ndarray:
        """Return the ten parameters to tell, those of a real body, shape (10,)."""
        return self._payload

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from."""
        return tuple(
            LedgerEntry(setting=field.name, value=getattr(self, field.name), source="chosen", note=CHOSEN[field.name])
            for field in fields(self)
        )

    def _motion(self) -> tuple[np.ndarray, ...]:
        """Return views of the carrying joint's rotation and velocity, and the flange's placement there."""
        flange = self._model.frames[self.robot.flange_id]
        joint = flange.parentJoint
        pin.forwardKinematics(self._model, self._data, np.zeros(self.robot.n), np.zeros(self.robot.n))
        velocity, placement = self._data.v[joint], flange.placement
        rotation = self._data.oMi[joint].rotation
        return rotation, velocity.linear, velocity.angular, placement.rotation.copy(), placement.translation.copy()

    def _constants(self) -> np.ndarray:
        """Return the record of settings as the kernel reads them, shape (1,)."""
        constants = np.zeros(1, CONSTANTS)
        for name in ("jump", "mass_spread", "moment_spread", "mass_limit", "reach", "radius", "resolution", "period"):
            constants[name] = getattr(self, name)
        constants["gain"] = 1.0 - np.exp(-2.0 * np.pi * self.corner * self.period)
        constants["noise"] = [self.force_noise**2] * 3 + [self.torque_noise**2] * 3
        constants["drift"][0, :4] = np.square([self.mass_drift, *[self.moment_drift] * 3]) * self.period
        constants["jump_ticks"] = self.jump_ticks
        constants["reopen"] = round(self.reopen / self.period)
        constants["interval"] = round(self.interval / self.period)
        constants["gravity"] = self._model.gravity.vector
        if self.robot.tool_mass:
            constants["tool"] = pin.Inertia.FromDynamicParameters(self.robot.tool_parameters).matrix()
        return constants


def _tool_point(robot: RobotModel) -> np.ndarray:
    """Return the tool point in flange axes, shape (3,) [m]."""
    frames = robot.model.frames
    offset = frames[robot.flange_id].placement.actInv(frames[robot.tool_id].placement)
    return np.array(offset.translation)
