"""Cartesian impedance: a spring and a damper between tool and plan, with a posture task behind them."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numba
import numpy as np

from ..controllers import Controller, DesignInertia, LedgerEntry, Observation, Target, Task
from .damping import DAMPING_DESIGNS, tool_mobility
from .rest import tick_at_rest
from .rotation import rotation_error
from .settings import require_bool, require_not_negative, require_one_of, require_positive

RDK = "RDK header robot.hpp, v1.5"
PUBLISHED: dict[str, tuple[object, str]] = {
    "linear_stiffness": (10000.0, "maintainer's answer in flexiv_rdk issue 133: nominal of the Rizon 4 [N/m]"),
    "damping_ratio": (0.7, f"{RDK}: default damping ratio"),
    "velocity_feedforward": (False, f"{RDK}: default argument of the streamed motion command"),
    "acceleration_feedforward": (False, f"{RDK}: default argument of the streamed motion command"),
}
"""Settings with a published value, and where it stands; any other value is chosen."""

CHOSEN: dict[str, str] = {
    "linear_stiffness": "the nominal of the Rizon 4 is 10000 [N/m]",
    "angular_stiffness": "1500 stands in one public configuration; the maker's figures disagree [N m/rad]",
    "damping_ratio": "the RDK's default is 0.7, its range 0.3 to 0.8",
    "damping_design": "with the model's apparent inertia; the double diagonalisation floors frequencies at 8 rad/s",
    "velocity_feedforward": "the interface accepts it",
    "acceleration_feedforward": "the interface accepts it",
    "posture_stiffness": "in the null space [1/s^2]",
    "posture_damping": "in the null space, critical with the stiffness [1/s]",
    "force_limit": "per axis of the spring's force, so that the damping survives; None is no limit [N]",
    "moment_limit": "per axis of the spring's moment; None is no limit [N m]",
}
"""What there is to say of the other values."""


@dataclass(kw_only=True)
class CartesianImpedance(Controller):
    r"""Tool wrench of a spring and a damper, joint torque from its transpose, posture in the null space.

    .. math::
        F &= K e + \beta D (\dot x_d - \dot x) - (1 - \beta) D \dot x + \alpha \Lambda (\ddot x_d - \dot J \dot q) \\
        \tau &= J^T F + h + N^T M a_0, \quad a_0 = \ddot q_d + k_n (q_d - q) + d_n (\dot q_d - \dot q)

    with e the position error before the rotation vector of the orientation error, in base axes at the tool point,
    alpha and beta 1 or 0 by the two feed-forward settings, :math:`\Lambda = (J M^{-1} J^T)^{-1}`, and the dynamically
    consistent projector :math:`N^T = I - J^T \Lambda J M^{-1}`, so that the posture never moves the tool. Without
    velocity feed-forward the damping acts on the absolute velocity and the tool lags by about 2 zeta / omega.
    Sources: Albu-Schaeffer, Ott, Frese, Hirzinger, ICRA 2003 (impedance, damping); Khatib, IEEE J. Robotics and
    Automation 3 (1987) (projector).

    Attributes:
        linear_stiffness: Stiffness of the tool's position [N/m].
        angular_stiffness: Stiffness of the tool's orientation [N m/rad].
        damping_ratio: Share of critical damping.
        damping_design: A name in :data:`torquebench.baselines.damping.DAMPING_DESIGNS`.
        velocity_feedforward: Whether the damper acts on the velocity error instead of the velocity (beta).
        acceleration_feedforward: Whether the planned acceleration is fed forward (alpha).
        posture_stiffness: Stiffness towards the planned posture, k_n [1/s^2].
        posture_damping: Damping towards the planned joint velocity, d_n [1/s].
        force_limit: Largest force of the spring per axis, None without limit [N].
        moment_limit: Largest moment of the spring per axis, None without limit [N m].
    """

    linear_stiffness: float = 10000.0
    angular_stiffness: float = 1500.0
    damping_ratio: float = 0.7
    damping_design: str = "square_root"
    velocity_feedforward: bool = False
    acceleration_feedforward: bool = False
    posture_stiffness: float = 25.0
    posture_damping: float = 10.0
    force_limit: float | None = None
    moment_limit: float | None = None

    def __post_init__(self) -> None:
        """Check the settings."""
        require_positive("linear_stiffness", self.linear_stiffness)
        require_positive("angular_stiffness", self.angular_stiffness)
        require_positive("damping_ratio", self.damping_ratio)
        require_one_of("damping_design", self.damping_design, DAMPING_DESIGNS)
        require_bool("velocity_feedforward", self.velocity_feedforward)
        require_bool("acceleration_feedforward", self.acceleration_feedforward)
        require_not_negative("posture_stiffness", self.posture_stiffness)
        require_not_negative("posture_damping", self.posture_damping)
        for name in ("force_limit", "moment_limit"):
            if getattr(self, name) is not None:
                require_positive(name, getattr(self, name))

    def reset(self, task: Task) -> None:
        """Take the model and allocate for one episode."""
        self.robot = task.robot
        self.initial_q = task.initial_q.copy()
        self._design = DAMPING_DESIGNS[self.damping_design]
        self._ratio = float(self.damping_ratio)
        self._stiffness = np.repeat([float(self.linear_stiffness), float(self.angular_stiffness)], 3)
        limits = [np.inf if limit is None else float(limit) for limit in (self.force_limit, self.moment_limit)]
        self._limit = np.repeat(limits, 3)
        self._feedforward = np.array([self.velocity_feedforward, self.acceleration_feedforward], dtype=float)
        self._posture = np.array([self.posture_stiffness, self.posture_damping], dtype=float)
        self._mobility, self._damping, self._inertia = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        self._spring, self._torque = np.zeros(6), np.zeros(task.robot.n)
        self.compute(*tick_at_rest(task))

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        q, dq, torque = observation.q, observation.dq, self._torque
        state = self.robot.at(q, dq)
        tool_mobility(state.mass_matrix, state.jacobian, self._mobility)
        self._design(self._mobility, self._stiffness, self._ratio, self._damping, self._inertia)
        spring_wrench(state.pose, target.pose, self._stiffness, self._limit, self._spring)
        posture_acceleration(q, dq, target.q, target.dq, target.ddq, self._posture, torque)
        impedance_torque(
            state.mass_matrix,
            state.bias,
            state.jacobian,
            state.jacobian_bias,
            dq,
            target.twist,
            target.acceleration,
            self._spring,
            self._damping,
            self._inertia,
            self._feedforward,
            torque,
        )
        return torque

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from."""
        return tuple(_entry(field.name, getattr(self, field.name)) for field in fields(self))

    def design_inertia(self) -> DesignInertia:
        r"""Return the joint damping at the start as inertia times its fastest rate.

        .. math:: B = J^T D J + d_n N^T M, \quad \tau = -B \dot q + \dots
        """
        state = self.robot.at(self.initial_q, np.zeros(self.robot.n))
        mass, jacobian = state.mass_matrix, state.jacobian
        tool_mobility(mass, jacobian, self._mobility)
        self._design(self._mobility, self._stiffness, self._ratio, self._damping, self._inertia)
        posture = mass - jacobian.T @ self._inertia @ jacobian
        joint_damping = jacobian.T @ self._damping @ jacobian + self.posture_damping * posture
        rate = float(np.max(np.linalg.eigvals(np.linalg.solve(mass, joint_damping)).real))
        return DesignInertia(mass_matrix=joint_damping / rate, damping=rate)


@numba.njit(cache=True)
def spring_wrench(
    pose: np.ndarray, goal: np.ndarray, stiffness: np.ndarray, limit: np.ndarray, wrench: np.ndarray
) -> None:
    r"""Write the wrench of the spring between tool and goal.

    .. math:: F_i = \mathrm{clip}(K_i e_i, -F_{max,i}, F_{max,i}), \quad e = (p_d - p, \log(R_d R^T))

    Args:
        pose: Tool pose in the base frame, shape (4, 4) [m].
        goal: Its goal, shape (4, 4) [m].
        stiffness: Diagonal of K, shape (6,) [N/m, N m/rad].
        limit: Largest magnitudes, shape (6,) [N, N m].
        wrench: Receives F in base axes at the tool point, force before moment, shape (6,) [N, N m].
    """
    rotation_error(pose[:3, :3], goal[:3, :3], wrench[3:])
    for i in range(3):
        wrench[i] = goal[i, 3] - pose[i, 3]
    for i in range(6):
        wrench[i] = min(max(stiffness[i] * wrench[i], -limit[i]), limit[i])


@numba.njit(cache=True)
def posture_acceleration(
    q: np.ndarray,
    dq: np.ndarray,
    q_ref: np.ndarray,
    dq_ref: np.ndarray,
    ddq_ref: np.ndarray,
    gains: np.ndarray,
    acceleration: np.ndarray,
) -> None:
    r"""Write the joint acceleration that follows the planned posture.

    .. math:: a_0 = \ddot q_d + k_n (q_d - q) + d_n (\dot q_d - \dot q)

    Args:
        q: Joint positions, shape (n,) [rad].
        dq: Joint velocities, shape (n,) [rad/s].
        q_ref: Planned positions, shape (n,) [rad].
        dq_ref: Planned velocities, shape (n,) [rad/s].
        ddq_ref: Planned accelerations, shape (n,) [rad/s^2].
        gains: k_n and d_n, shape (2,) [1/s^2, 1/s].
        acceleration: Receives a_0, shape (n,) [rad/s^2].
    """
    for i in range(q.shape[0]):
        acceleration[i] = ddq_ref[i] + gains[0] * (q_ref[i] - q[i]) + gains[1] * (dq_ref[i] - dq[i])


@numba.njit(cache=True)
def impedance_torque(
    mass_matrix: np.ndarray,
    bias: np.ndarray,
    jacobian: np.ndarray,
    jacobian_bias: np.ndarray,
    dq: np.ndarray,
    twist_ref: np.ndarray,
    acceleration_ref: np.ndarray,
    spring: np.ndarray,
    damping: np.ndarray,
    inertia: np.ndarray,
    feedforward: np.ndarray,
    torque: np.ndarray,
) -> None:
    r"""Turn the posture's acceleration into the torque of the whole law.

    As :math:`N^T M a_0 = M a_0 - J^T \Lambda J a_0`, the law needs no inverse of M and one product with J^T:

    .. math:: \tau = h + M a_0 + J^T [K e + D (\beta \dot x_d - \dot x)
        + \Lambda (\alpha (\ddot x_d - \dot J \dot q) - J a_0)]

    Args:
        mass_matrix: M, shape (n, n) [kg m^2].
        bias: h, shape (n,) [N m].
        jacobian: J, base axes at the tool point, linear before angular, shape (6, n).
        jacobian_bias: Time derivative of J times dq, shape (6,) [m/s^2, rad/s^2].
        dq: Joint velocities, shape (n,) [rad/s].
        twist_ref: Planned tool twist, shape (6,) [m/s, rad/s].
        acceleration_ref: Planned tool acceleration, shape (6,) [m/s^2, rad/s^2].
        spring: K e, shape (6,) [N, N m].
        damping: D, shape (6, 6) [N s/m, N s, N m s].
        inertia: The tool's inertia, shape (6, 6) [kg, kg m, kg m^2].
        feedforward: beta and alpha, shape (2,).
        torque: a_0 on entry [rad/s^2], the torque on return [N m], shape (n,).
    """
    n = torque.shape[0]
    slip, push, posture = np.empty(6), np.empty(6), torque.copy()
    for r in range(6):
        twist, along = 0.0, 0.0
        for j in range(n):
            twist += jacobian[r, j] * dq[j]
            along += jacobian[r, j] * posture[j]
        slip[r] = feedforward[0] * twist_ref[r] - twist
        push[r] = feedforward[1] * (acceleration_ref[r] - jacobian_bias[r]) - along
    for i in range(n):
        torque[i] = bias[i]
        for j in range(n):
            torque[i] += mass_matrix[i, j] * posture[j]
    for r in range(6):
        wrench = spring[r]
        for c in range(6):
            wrench += damping[r, c] * slip[c] + inertia[r, c] * push[c]
        for i in range(n):
            torque[i] += jacobian[r, i] * wrench


def _entry(setting: str, value: object) -> LedgerEntry:
    """Return the origin of one setting: published if it has the published value."""
    published, note = PUBLISHED.get(setting, (None, ""))
    if setting in PUBLISHED and value == published:
        return LedgerEntry(setting=setting, value=value, source="published", note=note)
    return LedgerEntry(setting=setting, value=value, source="chosen", note=CHOSEN.get(setting, ""))
