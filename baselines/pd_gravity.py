"""PD with gravity compensation: springs and dampers at the joints of a weightless arm."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..controllers import Controller, DesignInertia, LedgerEntry, Observation, Target, Task
from ..controllers.ledger import Source
from .gains import smallest_effective_inertia
from .joint_gains import (
    EXAMPLE,
    EXAMPLE_DAMPING,
    EXAMPLE_STIFFNESS,
    checked_gains,
    damping_as_inertia,
    gain_entries,
    spring_and_damper,
    wrong_length,
)
from .settings import require_bool, require_positive

RULE_BANDWIDTH = 40.0
"""Bandwidth of the rule on arms for which nothing is published [rad/s]."""


@dataclass(kw_only=True)
class PdGravity(Controller):
    r"""Joint springs and dampers on top of the gravity torque; stable for any inertia, but it lags and droops.

    .. math:: \tau = K e + D (\beta \dot q_d - \dot q) + g(q), \quad e = q_d - q, \quad \beta \in \{0, 1\}

    On seven joints K and D are those of the RDK's joint torque control example, which damps the absolute velocity
    (beta = 0). Elsewhere, or where a bandwidth is given, they follow from the smallest effective inertia of each
    joint along the plan.
    Source: Takegaki, Arimoto, A new feedback method for dynamic control of manipulators, J. Dynamic Systems,
    Measurement, and Control 103 (1981).

    Attributes:
        stiffness: K, one value per joint [N m/rad]; None for the published or ruled one.
        damping: D, one value per joint [N m s/rad]; None for the published or ruled one.
        bandwidth: Natural frequency of the rule [rad/s]; None for the published gains where there are any.
        velocity_feedforward: Whether the damping acts on the velocity error (beta = 1).
    """

    stiffness: tuple[float, ...] | None = None
    damping: tuple[float, ...] | None = None
    bandwidth: float | None = None
    velocity_feedforward: bool = False

    def __post_init__(self) -> None:
        """Check the settings."""
        self.stiffness = checked_gains("stiffness", self.stiffness)
        self.damping = checked_gains("damping", self.damping)
        if self.bandwidth is not None:
            require_positive("bandwidth", self.bandwidth)
        require_bool("velocity_feedforward", self.velocity_feedforward)

    def supports(self, task: Task) -> str | None:
        """Refuse gains for another number of joints."""
        return wrong_length(task.robot.n, {"stiffness": self.stiffness, "damping": self.damping})

    def reset(self, task: Task) -> None:
        """Take the model and choose the gains for one plan."""
        self.robot, self.initial_q = task.robot, task.initial_q.copy()
        self.published = self.bandwidth is None and task.robot.n == len(EXAMPLE_STIFFNESS)
        ruled = (np.array(EXAMPLE_STIFFNESS), np.array(EXAMPLE_DAMPING))
        if not self.published:
            inertia = smallest_effective_inertia(task.robot, task.reference)
            ruled = spring_and_damper(inertia, self.bandwidth or RULE_BANDWIDTH)
        self.springs = ruled[0] if self.stiffness is None else np.array(self.stiffness)
        self.dampers = ruled[1] if self.damping is None else np.array(self.damping)
        self._share = float(self.velocity_feedforward)
        self._spring, self._damper = np.zeros(task.robot.n), np.zeros(task.robot.n)

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        torque, damper = self._spring, self._damper
        np.subtract(target.q, observation.q, out=torque)
        torque *= self.springs
        np.multiply(target.dq, self._share, out=damper)
        damper -= observation.dq
        damper *= self.dampers
        torque += damper
        torque += self.robot.gravity(observation.q)
        return torque

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting and gain comes from."""
        rule = "smallest 1 / (M^-1)_jj along the plan, damping ratio 0.7"
        origin: tuple[Source, str] = ("published", EXAMPLE) if self.published else ("rule", rule)
        fed = self.velocity_feedforward
        return (
            *gain_entries("stiffness", self.stiffness, self.springs, *origin, "[N m/rad]"),
            *gain_entries("damping", self.damping, self.dampers, *origin, "[N m s/rad]"),
            LedgerEntry(setting="bandwidth", value=self.bandwidth, source="chosen", note="of the rule [rad/s]"),
            LedgerEntry(
                setting="velocity_feedforward",
                value=fed,
                source="chosen" if fed else "published",
                note="damps the velocity error" if fed else f"{EXAMPLE}: it damps the absolute velocity",
            ),
        )

    def design_inertia(self) -> DesignInertia:
        """Return the joint damping at the start as inertia times its fastest rate."""
        return damping_as_inertia(self.dampers, self.robot.mass_matrix(self.initial_q))
