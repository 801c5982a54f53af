"""Computed torque with integral action: no knowledge of the load is needed to hold it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..controllers import Controller, DesignInertia, LedgerEntry, Observation, Target, Task
from .gains import triple_integrator_gains
from .integral import integrate_unless_limited
from .rest import tick_at_rest
from .settings import require_positive


@dataclass(kw_only=True)
class ComputedTorquePid(Controller):
    r"""Feedback linearisation with a PID outer law on acceleration level.

    .. math:: \tau = M(q) (\ddot q_d + k_d \dot e + k_p e + k_i z) + h(q, \dot q),
        \quad e = q_d - q, \quad z = \int e \, dt

    The integral is clamped per joint, and stands still while the joint's command is at a limit.
    Source: Siciliano et al., Robotics (2009), section 8.5.2 (inverse dynamics), with an integral state.

    Attributes:
        bandwidth: Place of the triple closed-loop pole [rad/s]; three times as stiff as the PD law of equal bandwidth.
        integral_limit: Largest magnitude of each joint's integral [rad s].
    """

    bandwidth: float = 20.0
    integral_limit: float = 0.2

    def __post_init__(self) -> None:
        """Check the settings."""
        require_positive("bandwidth", self.bandwidth)
        require_positive("integral_limit", self.integral_limit)

    def reset(self, task: Task) -> None:
        """Take the model, compute the gains and empty the integral for one episode."""
        self.robot, self.period = task.robot, task.period
        self.initial_q = task.initial_q.copy()
        self.integral_gain, self.stiffness, self.damping = triple_integrator_gains(self.bandwidth, task.period)
        n, rate = task.robot.n, task.actuation.torque_rate
        self._effort = task.actuation.effort.copy()
        self._step = np.full(n, np.inf) if rate is None else rate * task.period
        self.integral, self._previous = np.zeros(n), np.zeros(n)
        self._error, self._term, self._acceleration = np.zeros(n), np.zeros(n), np.zeros(n)
        self.compute(*tick_at_rest(task))
        self.integral[:] = 0.0
        # Not a number until a command is known: the first one has no rate.
        self._previous[:] = np.nan

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        error, term, acceleration = self._error, self._term, self._acceleration
        np.multiply(self.integral, self.integral_gain, out=acceleration)
        acceleration += target.ddq
        np.subtract(target.dq, observation.dq, out=term)
        term *= self.damping
        acceleration += term
        np.subtract(target.q, observation.q, out=error)
        np.multiply(error, self.stiffness, out=term)
        acceleration += term
        command, limit = observation.command, self.integral_limit
        integrate_unless_limited(
            self.integral, error, self.period, limit, command, self._previous, self._effort, self._step
        )
        return self.robot.inverse_dynamics(observation.q, observation.dq, acceleration)

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return the integral of the joint error, shape (n,) [rad s], every 10 ticks."""
        return {"integral": (self.integral, 10)}

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting and gain comes from."""
        rule = "discrete LQR with integral state, Q = diag(w^6, 3 w^4, 3 w^2), R = 1, w the bandwidth"
        held = "held while the joint's command is at its effort or rate limit"
        return (
            LedgerEntry(setting="bandwidth", value=self.bandwidth, source="chosen", note="[rad/s]"),
            LedgerEntry(setting="integral_limit", value=self.integral_limit, source="chosen", note=f"{held} [rad s]"),
            LedgerEntry(setting="integral_gain", value=self.integral_gain, source="rule", note=f"{rule} [1/s^3]"),
            LedgerEntry(setting="stiffness", value=self.stiffness, source="rule", note=f"{rule} [1/s^2]"),
            LedgerEntry(setting="damping", value=self.damping, source="rule", note=f"{rule} [1/s]"),
        )

    def design_inertia(self) -> DesignInertia:
        """Return the model's mass matrix at the start: the linearised joints are damped with it."""
        return DesignInertia(mass_matrix=self.robot.mass_matrix(self.initial_q), damping=self.damping)
