"""Computed torque of the plan, with a diagonal PD law around it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..controllers import Controller, DesignInertia, LedgerEntry, Observation, Target, Task
from .gains import double_integrator_gains, smallest_effective_inertia
from .settings import require_positive


@dataclass(kw_only=True)
class ComputedTorqueFeedforward(Controller):
    r"""Inverse dynamics of the plan plus joint springs and dampers.

    .. math:: \tau = M(q_d) \ddot q_d + h(q_d, \dot q_d) + I (k_p e + k_d \dot e), \quad e = q_d - q

    I is diagonal: the smallest effective inertia of each joint along the plan, so that the diagonal gains suit the
    coupled arm; with the payload that is known at reset. Measured positions and velocities enter the PD part only.
    Source: Siciliano et al., Robotics (2009), section 8.4.

    Attributes:
        bandwidth: Bandwidth of each joint on its effective inertia [rad/s]; the only tuning number.
    """

    bandwidth: float = 20.0

    def __post_init__(self) -> None:
        """Check the settings."""
        require_positive("bandwidth", self.bandwidth)

    def reset(self, task: Task) -> None:
        """Take the model and compute the gains for one plan."""
        self.robot = task.robot
        self.inertia = smallest_effective_inertia(task.robot, task.reference)
        stiffness, self.damping_rate = double_integrator_gains(self.bandwidth, task.period)
        self.stiffness, self.damping = stiffness * self.inertia, self.damping_rate * self.inertia
        self._spring, self._damper = np.zeros(task.robot.n), np.zeros(task.robot.n)

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        torque, damper = self._spring, self._damper
        np.subtract(target.q, observation.q, out=torque)
        np.subtract(target.dq, observation.dq, out=damper)
        torque *= self.stiffness
        damper *= self.damping
        torque += damper
        torque += self.robot.inverse_dynamics(target.q, target.dq, target.ddq)
        return torque

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting and gain comes from."""
        rule = "discrete LQR of the double integrator times the smallest effective inertia along the plan"
        return (
            LedgerEntry(setting="bandwidth", value=self.bandwidth, source="chosen", note="[rad/s]"),
            LedgerEntry(
                setting="inertia",
                value=self.inertia.tolist(),
                source="rule",
                note="smallest 1 / (M^-1)_jj along the plan [kg m^2]",
            ),
            LedgerEntry(setting="stiffness", value=self.stiffness.tolist(), source="rule", note=f"{rule} [N m/rad]"),
            LedgerEntry(setting="damping", value=self.damping.tolist(), source="rule", note=f"{rule} [N m s/rad]"),
        )

    def design_inertia(self) -> DesignInertia:
        """Return the diagonal inertia that scales the damping."""
        return DesignInertia(mass_matrix=np.diag(self.inertia), damping=self.damping_rate)
