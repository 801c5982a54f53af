"""Computed torque: feedback linearisation with a PD outer law."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..controllers import Controller, DesignInertia, LedgerEntry, Observation, Target, Task
from .gains import double_integrator_gains
from .settings import require_positive


@dataclass(kw_only=True)
class ComputedTorque(Controller):
    r"""Joint torque that makes every joint a critically damped double integrator.

    .. math:: \tau = M(q) (\ddot q_d + k_d \dot e + k_p e) + h(q, \dot q), \quad e = q_d - q

    The model carries whatever payload knowledge the task grants, refreshed before each tick.
    Source: Siciliano et al., Robotics (2009), section 8.5.2.

    Attributes:
        bandwidth: Place of the double closed-loop pole [rad/s]; the only tuning number.
    """

    bandwidth: float = 20.0

    def __post_init__(self) -> None:
        """Check the settings."""
        require_positive("bandwidth", self.bandwidth)

    def reset(self, task: Task) -> None:
        """Take the model and compute the gains for one episode."""
        self.robot = task.robot
        self.initial_q = task.initial_q.copy()
        self.stiffness, self.damping = double_integrator_gains(self.bandwidth, task.period)
        self._error, self._error_rate = np.zeros(task.robot.n), np.zeros(task.robot.n)
        self._acceleration = np.zeros(task.robot.n)

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        error, error_rate, acceleration = self._error, self._error_rate, self._acceleration
        np.subtract(target.q, observation.q, out=error)
        np.subtract(target.dq, observation.dq, out=error_rate)
        error *= self.stiffness
        error_rate *= self.damping
        np.add(target.ddq, error, out=acceleration)
        acceleration += error_rate
        return self.robot.inverse_dynamics(observation.q, observation.dq, acceleration)

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting and gain comes from."""
        rule = "discrete LQR of the double integrator with Q = diag(w^4, 2 w^2), R = 1, w the bandwidth"
        return (
            LedgerEntry(setting="bandwidth", value=self.bandwidth, source="chosen", note="[rad/s]"),
            LedgerEntry(setting="stiffness", value=self.stiffness, source="rule", note=f"{rule} [1/s^2]"),
            LedgerEntry(setting="damping", value=self.damping, source="rule", note=f"{rule} [1/s]"),
        )

    def design_inertia(self) -> DesignInertia:
        """Return the model's mass matrix at the start: the linearised joints are damped with it."""
        return DesignInertia(mass_matrix=self.robot.mass_matrix(self.initial_q), damping=self.damping)
