"""Every named configuration beside :class:`CbmcV3` itself: each replaces one part of the stack and says which."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..controllers import Observation, Target, Task
from .controller import CbmcV3
from .learning import FeedbackError, LossWeights, Rule
from .patterns import ARRAYS, Patterns
from .point_payload import point_payload
from .spinal_cord import ExactEncoder, SpinalCord, SpinalCordTable
from .stack import FirstOrder, Mixture, Regulation, Schedule, ThirdOrder
from .stand_ins import FixedGains, FixedWeights, HeldCompensation, ModelPatterns, NumbThalamus, UnfilteredThalamus
from .thalamus import Thalamus

LIGHT, HEAVY = 0, -1


@dataclass(kw_only=True)
class LightOnly(CbmcV3):
    """CBMC-V3 with the light pattern alone: what the cerebellum does without the thalamus's choice."""

    pattern: ClassVar[int] = LIGHT

    def _patterns(self, task: Task) -> Patterns:
        return single(super()._patterns(task), self.pattern)


@dataclass(kw_only=True)
class HeavyOnly(LightOnly):
    """CBMC-V3 with the heavy pattern alone."""

    pattern: ClassVar[int] = HEAVY


@dataclass(kw_only=True)
class NoBrainstemLearning(CbmcV3):
    """CBMC-V3 with the gains that the brainstem gives at rest, for ever."""

    def _brainstem(self, task: Task, rng: np.random.Generator) -> Regulation:
        super()._brainstem(task, rng)
        return FixedGains(self.down, self.down.stiffness.copy(), self.down.damping.copy())


@dataclass(kw_only=True)
class NoThalamusLearning(CbmcV3):
    """CBMC-V3 with equal weights of the patterns, for ever."""

    def _thalamus(self, task: Task, patterns: Patterns, rng: np.random.Generator) -> Mixture:
        return FixedWeights(self.down, np.full(patterns.count, 1.0 / patterns.count))


@dataclass(kw_only=True)
class NoLearning(NoBrainstemLearning, NoThalamusLearning):
    """CBMC-V3 with neither: fixed gains, equal weights."""

    def _rule(self) -> Rule | None:
        return None


@dataclass(kw_only=True)
class FixedCerebellumTorque(CbmcV3):
    """CBMC-V3 whose cerebellum answers once, at the start, and holds that torque."""

    def _cerebellum(self, task: Task, patterns: Patterns) -> ThirdOrder:
        return HeldCompensation(super()._cerebellum(task, patterns))


@dataclass(kw_only=True)
class NoEncoder(CbmcV3):
    """CBMC-V3 whose spinal cord sees the errors exactly instead of as spikes."""

    def _spinal_cord(self, task: Task, rng: np.random.Generator) -> FirstOrder:
        spinal_cord = SpinalCord(task.robot.n, SpinalCordTable(), ExactEncoder(task.robot.n))
        spinal_cord.connect(self.up, self.down)
        return spinal_cord


@dataclass(kw_only=True)
class NoForce(CbmcV3):
    """CBMC-V3 whose thalamus does not feel the load: the pathway of F_ef is cut."""

    thalamus: ClassVar[type[Thalamus]] = NumbThalamus


@dataclass(kw_only=True)
class NoFilter(CbmcV3):
    """CBMC-V3 whose mixture of patterns goes down as it is; the learning rule stays that of the filtered one."""

    thalamus: ClassVar[type[Thalamus]] = UnfilteredThalamus


@dataclass(kw_only=True)
class OneRate(CbmcV3):
    """CBMC-V3 whose levels all have the period of the second: no level is faster than another."""

    def _schedule(self) -> Schedule:
        second = super()._schedule().second
        return Schedule(first=second, second=second, third=second)


@dataclass(kw_only=True)
class NoTorquePenalty(CbmcV3):
    """CBMC-V3 whose brainstem does not pay for torque: the printed loss without its last term."""

    def _rule(self) -> Rule | None:
        return FeedbackError(sensitivity=self.sensitivity, loss=LossWeights(torque=0.0))


@dataclass(kw_only=True)
class ExactPatterns(CbmcV3):
    """CBMC-V3 whose patterns are the model's own gravity torques: what is left is the loop's.

    Attributes:
        loads: Load beyond the gripper of the patterns [kg].
        centre: Its centre of mass on the flange's z axis [m].
    """

    loads: tuple[float, ...] = (0.0, 3.0)
    centre: float = 0.2646

    def _cerebellum(self, task: Task, patterns: Patterns) -> ThirdOrder:
        models = []
        for load in self.loads:
            model = task.robot.copy()
            model.set_payload(point_payload(load, self.centre))
            models.append(model)
        return ModelPatterns(self.up, self.down, tuple(models))


@dataclass(kw_only=True)
class Feedforward(CbmcV3):
    """CBMC-V3 with the plan's inertial torque added to the command: not the paper, but what its figures would need."""

    uses_model: ClassVar[bool] = True

    def reset(self, task: Task) -> None:
        """Take the model of arm and gripper beside the stack."""
        super().reset(task)
        self.robot = task.robot
        self.still = np.zeros(task.robot.n)
        self.command = np.zeros(task.robot.n)

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the stack's torque plus M(q_d) ddq_d, shape (n,) [N m]."""
        np.copyto(self.command, super().compute(observation, target))
        robot = self.robot
        self.command += robot.inverse_dynamics(target.q, self.still, target.ddq)
        self.command -= robot.inverse_dynamics(target.q, self.still, self.still)
        return self.command


@dataclass(kw_only=True)
class Carried(CbmcV3):
    """CBMC-V3 that keeps what it has learnt over the repetitions of the protocol ``carried``."""

    carry_over: ClassVar[bool] = True

    def reset(self, task: Task) -> None:
        """Build a new stack and, after the first repetition, put the learnt parameters into it."""
        learnt = self.snapshot() if task.repetition > 0 and hasattr(self, "stack") else {}
        super().reset(task)
        for name, network in self._networks().items():
            if name in learnt:
                network.parameters[:] = learnt[name]


def single(patterns: Patterns, index: int) -> Patterns:
    """Return one of several patterns alone; -1 is the last."""
    row = slice(index, index + 1 or None)
    arrays = {name: getattr(patterns, name)[row] for name in ARRAYS}
    return replace(patterns, **arrays, loads=patterns.loads[row])
