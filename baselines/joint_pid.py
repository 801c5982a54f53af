"""Joint PID: no model at all, as most drives are delivered."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..controllers import Controller, DesignInertia, LedgerEntry, Observation, Target, Task
from ..controllers.ledger import Source
from .integral import integrate_unless_limited
from .joint_gains import EXAMPLE, EXAMPLE_DAMPING, EXAMPLE_STIFFNESS, checked_gains, gain_entries, wrong_length
from .rest import tick_at_rest
from .settings import require_positive

STIFFNESS_PER_EFFORT, DAMPING_PER_STIFFNESS = 12.0, 1.0 / 30.0
"""Gains of drives for which nothing is published: between those of the example's shoulder and wrist [1/rad, s]."""


@dataclass(kw_only=True)
class JointPid(Controller):
    r"""An independent PID law at every joint; gravity, coupling and load are left to the integral.

    .. math:: \tau = K e + D \dot e + z, \quad \dot z = K e / T_i, \quad e = q_d - q

    The integral starts at the torque that holds the arm (bumpless transfer), is clamped, and stands still while the
    joint's command is at a limit. On seven joints K and D are those of the RDK's joint torque control example,
    elsewhere a share of the torque limits.
    Source: Astrom, Hagglund, Advanced PID Control (2006), chapter 3; stable where K / T_i < K D / M, Arimoto,
    Miyazaki, Stability and robustness of PID feedback control for robot manipulators, ISRR 1 (1984).

    Attributes:
        stiffness: K, one value per joint [N m/rad]; None for the published or ruled one.
        damping: D, one value per joint [N m s/rad]; None for the published or ruled one.
        reset_time: T_i [s].
        integral_limit: Largest magnitude of the integral as a share of the torque limit.
    """

    uses_model: ClassVar[bool] = False

    stiffness: tuple[float, ...] | None = None
    damping: tuple[float, ...] | None = None
    reset_time: float = 0.25
    integral_limit: float = 0.9

    def __post_init__(self) -> None:
        """Check the settings."""
        self.stiffness = checked_gains("stiffness", self.stiffness)
        self.damping = checked_gains("damping", self.damping)
        require_positive("reset_time", self.reset_time)
        require_positive("integral_limit", self.integral_limit)

    def supports(self, task: Task) -> str | None:
        """Refuse gains for another number of joints, and the rule where the drives have no limits."""
        n = len(task.initial_q)
        if self.stiffness is None and n != len(EXAMPLE_STIFFNESS) and not np.all(np.isfinite(task.actuation.effort)):
            return "stiffness follows from the torque limits, and this arm has none: give one"
        return wrong_length(n, {"stiffness": self.stiffness, "damping": self.damping})

    def reset(self, task: Task) -> None:
        """Choose the gains for one arm."""
        n, rate = len(task.initial_q), task.actuation.torque_rate
        self._effort = task.actuation.effort.copy()
        self.published = n == len(EXAMPLE_STIFFNESS)
        springs = np.array(EXAMPLE_STIFFNESS) if self.published else STIFFNESS_PER_EFFORT * self._effort
        self.springs = springs if self.stiffness is None else np.array(self.stiffness)
        dampers = np.array(EXAMPLE_DAMPING) if self.published else DAMPING_PER_STIFFNESS * self.springs
        self.dampers = dampers if self.damping is None else np.array(self.damping)
        self._period, self._clamp = task.period, self.integral_limit * self._effort
        self._step = np.full(n, np.inf) if rate is None else rate * task.period
        self.integral, self._previous = np.zeros(n), np.zeros(n)
        self._torque, self._spring = np.zeros(n), np.zeros(n)
        self._started = False
        self.compute(*tick_at_rest(task))
        self._started = False

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        if not self._started:
            self._start(observation)
        spring, torque = self._spring, self._torque
        np.subtract(target.q, observation.q, out=spring)
        spring *= self.springs
        np.subtract(target.dq, observation.dq, out=torque)
        torque *= self.dampers
        torque += spring
        torque += self.integral
        spring /= self.reset_time
        command, previous, effort = observation.command, self._previous, self._effort
        integrate_unless_limited(self.integral, spring, self._period, np.inf, command, previous, effort, self._step)
        np.minimum(self.integral, self._clamp, out=self.integral)
        np.maximum(self.integral, -self._clamp, out=self.integral)
        return torque

    def _start(self, observation: Observation) -> None:
        """Begin with the torque that holds the arm; no command before it is known, so that it has no rate."""
        np.copyto(self.integral, observation.command)
        self._previous[:] = np.nan
        self._started = True

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return the integral's torque, shape (n,) [N m], every 10 ticks."""
        return {"integral": (self.integral, 10)}

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting and gain comes from."""
        springs: tuple[Source, str] = ("rule", "12 times the torque limit per rad")
        dampers: tuple[Source, str] = ("rule", "stiffness over 30 per s")
        if self.published:
            springs = dampers = ("published", EXAMPLE)
        held = "held while the joint's command is at its effort or rate limit; share of the torque limit"
        return (
            *gain_entries("stiffness", self.stiffness, self.springs, *springs, "[N m/rad]"),
            *gain_entries("damping", self.damping, self.dampers, *dampers, "[N m s/rad]"),
            LedgerEntry(setting="reset_time", value=self.reset_time, source="chosen", note="[s]"),
            LedgerEntry(setting="integral_limit", value=self.integral_limit, source="chosen", note=held),
        )

    def design_inertia(self) -> DesignInertia:
        r"""Return the inertia that the gains damp critically: there is no model, but damping it has.

        .. math:: D = \rho M_d, \quad \rho = 4 \max_j K_j / D_j
        """
        rate = float(np.max(4.0 * self.springs / self.dampers))
        return DesignInertia(mass_matrix=np.diag(self.dampers / rate), damping=rate)
