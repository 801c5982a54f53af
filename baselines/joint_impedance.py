"""Joint impedance: springs with feed-forward of the plan, damped by the arm's own inertia."""

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np

from ..controllers import Controller, DesignInertia, LedgerEntry, Observation, Target, Task
from ..controllers.ledger import Source
from .gains import smallest_effective_inertia
from .joint_gains import checked_gains, damping_as_inertia, gain_entries, spring_and_damper, wrong_length
from .rest import tick_at_rest
from .settings import require_positive

SEVEN_JOINT_STIFFNESS = (2000.0, 2000.0, 1000.0, 1000.0, 300.0, 300.0, 100.0)
"""A soft seven-joint arm [N m/rad]; the maker's nominal joint stiffness is not public."""

RULE_BANDWIDTH = 30.0
"""Bandwidth of the rule on arms of another number of joints [rad/s]."""


@dataclass(kw_only=True)
class JointImpedance(Controller):
    r"""A spring and a damper at every joint around the plan; the desired inertia is the arm's own.

    .. math:: \tau = M(q) \ddot q_d + h(q, \dot q) + K e + D(q) \dot e, \quad e = q_d - q

    As the inertia is not shaped, no external torque needs to be measured: it meets
    :math:`M \ddot e + D \dot e + K e`.
    Source: Ott, Cartesian Impedance Control of Redundant and Flexible-Joint Robots (2008), section 3.2; damping:
    Albu-Schaeffer, Ott, Frese, Hirzinger, ICRA 2003.

    Attributes:
        stiffness: K, one value per joint [N m/rad]; None for a soft seven-joint arm's, elsewhere by rule.
        damping_ratio: Damping ratio of every mode.
    """

    stiffness: tuple[float, ...] | None = None
    damping_ratio: float = 0.7

    def __post_init__(self) -> None:
        """Check the settings."""
        self.stiffness = checked_gains("stiffness", self.stiffness)
        require_positive("damping_ratio", self.damping_ratio)

    def supports(self, task: Task) -> str | None:
        """Refuse gains for another number of joints."""
        return wrong_length(task.robot.n, {"stiffness": self.stiffness})

    def reset(self, task: Task) -> None:
        """Take the model and choose the stiffness for one plan."""
        self.robot, self.initial_q = task.robot, task.initial_q.copy()
        n = task.robot.n
        self.ruled = n != len(SEVEN_JOINT_STIFFNESS)
        self.springs = np.array(self.stiffness or SEVEN_JOINT_STIFFNESS)
        if self.stiffness is None and self.ruled:
            self.springs, _ = spring_and_damper(smallest_effective_inertia(task.robot, task.reference), RULE_BANDWIDTH)
        self._damping, self._torque = np.zeros((n, n)), np.zeros(n)
        self.compute(*tick_at_rest(task))

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        q, dq, damping, torque = observation.q, observation.dq, self._damping, self._torque
        state = self.robot.at(q, dq)
        joint_damping(state.mass_matrix, self.springs, self.damping_ratio, damping)
        goal = target.q, target.dq, target.ddq
        impedance_torque(state.mass_matrix, state.bias, q, dq, goal, self.springs, damping, torque)
        return torque

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting and gain comes from."""
        origin: tuple[Source, str] = ("chosen", "the maker's nominal joint stiffness is not public")
        if self.ruled:
            origin = ("rule", "30 rad/s on the smallest 1 / (M^-1)_jj along the plan")
        published = self.damping_ratio == 0.7
        source: Source = "published" if published else "chosen"
        note = "Flexiv RDK, default of joint impedance; D by the square-root design, every tick"
        return (
            *gain_entries("stiffness", self.stiffness, self.springs, *origin, "[N m/rad]"),
            LedgerEntry(setting="damping_ratio", value=self.damping_ratio, source=source, note=note),
        )

    def design_inertia(self) -> DesignInertia:
        """Return the joint damping at the start as inertia times its fastest rate."""
        mass = self.robot.mass_matrix(self.initial_q)
        joint_damping(mass, self.springs, self.damping_ratio, self._damping)
        return damping_as_inertia(self._damping, mass)


@numba.njit(cache=True)
def joint_damping(mass_matrix: np.ndarray, stiffness: np.ndarray, ratio: float, damping: np.ndarray) -> None:
    r"""Write the damping whose factors are the square roots of inertia and stiffness.

    .. math:: D = \zeta (M^{1/2} K^{1/2} + K^{1/2} M^{1/2})

    For one joint this is the familiar :math:`2 \zeta \sqrt{K M}`.

    Args:
        mass_matrix: M, positive definite, shape (n, n) [kg m^2].
        stiffness: Diagonal of K, shape (n,) [N m/rad].
        ratio: Damping ratio zeta.
        damping: Receives D, symmetric, shape (n, n) [N m s/rad].
    """
    n = mass_matrix.shape[0]
    values, vectors = np.linalg.eigh(mass_matrix)
    root = np.sqrt(stiffness)
    damping[:] = 0.0
    for i in range(n):
        weight = ratio * np.sqrt(values[i])
        for r in range(n):
            for c in range(n):
                damping[r, c] += weight * vectors[r, i] * vectors[c, i] * (root[r] + root[c])


@numba.njit(cache=True)
def impedance_torque(
    mass_matrix: np.ndarray,
    bias: np.ndarray,
    q: np.ndarray,
    dq: np.ndarray,
    goal: tuple[np.ndarray, np.ndarray, np.ndarray],
    stiffness: np.ndarray,
    damping: np.ndarray,
    torque: np.ndarray,
) -> None:
    r"""Write :math:`M \ddot q_d + h + K e + D \dot e`.

    Args:
        mass_matrix: M, shape (n, n) [kg m^2].
        bias: h, shape (n,) [N m].
        q: Joint positions, shape (n,) [rad].
        dq: Joint velocities, shape (n,) [rad/s].
        goal: The plan's positions, velocities and accelerations, each of shape (n,).
        stiffness: Diagonal of K, shape (n,) [N m/rad].
        damping: D, shape (n, n) [N m s/rad].
        torque: Receives the torque, shape (n,) [N m].
    """
    n = q.shape[0]
    for i in range(n):
        torque[i] = bias[i] + stiffness[i] * (goal[0][i] - q[i])
        for j in range(n):
            torque[i] += mass_matrix[i, j] * goal[2][j] + damping[i, j] * (goal[1][j] - dq[j])
