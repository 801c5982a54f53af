"""Null controls: plain arithmetic with CBMC-V3's own mean gains, to show what the networks add."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..controllers import Controller, InvalidInput, LedgerEntry, Observation, Target, Task
from .configurations import NoEncoder
from .learning import Rule
from .mean_gains import LEARNT, MeanGains, mean_gains
from .patterns import Patterns
from .stack import Mixture, Regulation
from .stand_ins import FixedGains, ForceMass, WeightIntegrator


@dataclass(kw_only=True)
class PdOracle(Controller):
    r"""PD with the mean gains and the true gravity: the best that any weighing of patterns could do.

    .. math:: \tau = K_P (q_d - q) + K_V (\dot q_d - \dot q) + g(q)
    """

    knowledge_levels: ClassVar[tuple[str, ...] | None] = ("oracle",)

    def supports(self, task: Task) -> str | None:
        """Return None, or that the tier has no mean gains and how to measure them."""
        return _gains_missing(task)

    def reset(self, task: Task) -> None:
        """Take the model and the gains of the tier."""
        self.robot = task.robot
        self.gains = mean_gains(task.actuation.tier, task.robot.n)

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        feedback = self.gains.stiffness * (target.q - observation.q)
        feedback += self.gains.damping * (target.dq - observation.dq)
        return np.asarray(feedback + self.robot.gravity(observation.q))

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where the gains come from."""
        return (_gains_entry(self.gains),)


@dataclass(kw_only=True)
class MeanGainsLoop(NoEncoder):
    """The stack of CBMC-V3 without encoder and without networks: mean gains, and plain arithmetic for the weights."""

    def supports(self, task: Task) -> str | None:
        """Return None, or what is missing: patterns of the arm, or mean gains of the tier."""
        return super().supports(task) or _gains_missing(task)

    def _brainstem(self, task: Task, rng: np.random.Generator) -> Regulation:
        self.gains = mean_gains(task.actuation.tier, task.robot.n)
        return FixedGains(self.down, self.gains.stiffness, self.gains.damping)

    def _rule(self) -> Rule | None:
        return None

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where gains and patterns come from."""
        return (*super().ledger(), _gains_entry(self.gains))


@dataclass(kw_only=True)
class WeightIntegratorLoop(MeanGainsLoop):
    """One line that integrates the error, in place of the thalamus."""

    def _thalamus(self, task: Task, patterns: Patterns, rng: np.random.Generator) -> Mixture:
        _two(patterns)
        return WeightIntegrator(self.up, self.down)


@dataclass(kw_only=True)
class ForceMassLoop(MeanGainsLoop):
    """The load read off the force sensor, in place of the thalamus."""

    def _thalamus(self, task: Task, patterns: Patterns, rng: np.random.Generator) -> Mixture:
        _two(patterns)
        light, heavy = patterns.loads
        return ForceMass(self.up, self.down, tool_mass=task.robot.tool_mass, loads=(light, heavy))


def _gains_missing(task: Task) -> str | None:
    try:
        mean_gains(task.actuation.tier, task.robot.n)
    except InvalidInput as reason:
        return str(reason)
    return None


def _two(patterns: Patterns) -> None:
    if patterns.count != 2:
        raise InvalidInput(f"{patterns.count} patterns", "null control", "it mixes a light and a heavy one")


def _gains_entry(gains: MeanGains) -> LedgerEntry:
    value = {"stiffness": gains.stiffness.tolist(), "damping": gains.damping.tolist()}
    return LedgerEntry(setting="gains", value=value, source="rule", note="copied from CBMC-V3", learnt_before=LEARNT)
