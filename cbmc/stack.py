"""The three levels and their schedule: Algorithm 1 of the paper, one tick at a time."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .learning import Gradients, Rule
from .pathways import Ascending, Descending


class ThirdOrder(Protocol):
    """Gives the patterns' gravity torques; the cerebellum, or what stands in for it."""

    def compensate(self) -> None:
        """Fill ``descending.compensation`` from ``ascending.q``."""
        ...


class Mixture(Protocol):
    """Weighs and filters the patterns; the thalamus, or what stands in for it."""

    def weigh(self) -> None:
        """Fill ``descending.weights``."""
        ...

    def combine(self) -> None:
        """Move ``descending.gravity_torque`` one step towards the mixture."""
        ...

    def settle(self) -> None:
        """Set ``descending.gravity_torque`` to the mixture."""
        ...

    def learn(self, weight_gradient: np.ndarray) -> None:
        """Take dL/dw, shape (patterns,)."""
        ...


class Regulation(Protocol):
    """Gives the feedback gains; the brainstem, or what stands in for it."""

    def gains(self) -> None:
        """Fill ``descending.stiffness`` and ``descending.damping``."""
        ...

    def learn(self, gain_gradient: np.ndarray) -> None:
        """Take dL/dK_P before dL/dK_V, shape (2 n,)."""
        ...


class FirstOrder(Protocol):
    """Encodes errors and drives the muscles; the spinal cord.

    Attributes:
        encoded_position: Decoded position error of the last call, shape (n,) [rad].
        encoded_velocity: Decoded velocity error of the last call, shape (n,) [rad/s].
    """

    encoded_position: np.ndarray
    encoded_velocity: np.ndarray

    def act(self) -> None:
        """Fill ``descending.torque``."""
        ...

    def settle(self, torque: np.ndarray) -> None:
        """Set ``descending.torque``, shape (n,) [N m]."""
        ...


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """Periods of the levels in ticks; the paper's T1, T2, T3 are 1, 10 and 50 ms at 1 kHz."""

    first: int = 1
    second: int = 10
    third: int = 50


class Stack:
    """Modules on three levels, joined by the two pathways.

    Attributes:
        ascending: What the modules read; the controller fills it before every tick.
        descending: What they write.
        gradients: What the learning rule said last.
        ticks: Ticks since the start.
    """

    def __init__(
        self,
        *,
        ascending: Ascending,
        descending: Descending,
        cerebellum: ThirdOrder,
        thalamus: Mixture,
        brainstem: Regulation,
        spinal_cord: FirstOrder,
        rule: Rule | None,
        schedule: Schedule,
    ) -> None:
        """Join modules that are connected to the pathways already.

        Args:
            ascending: The ascending pathway.
            descending: The descending pathway.
            cerebellum: Third order.
            thalamus: Second order.
            brainstem: Second order.
            spinal_cord: First order.
            rule: Learning rule of the second order, None for none.
            schedule: When each level runs.
        """
        self.ascending, self.descending = ascending, descending
        self.cerebellum, self.thalamus, self.brainstem, self.spinal_cord = cerebellum, thalamus, brainstem, spinal_cord
        self._rule, self._schedule = rule, schedule
        patterns, joints = descending.compensation.shape
        self.gradients = Gradients(weights=np.zeros(patterns), gains=np.zeros(2 * joints), losses=np.zeros(2))
        if rule is not None:
            encoded = (spinal_cord.encoded_position, spinal_cord.encoded_velocity)
            rule.connect(ascending, descending, encoded, self.gradients)
        self.ticks = 0

    def settle(self) -> None:
        """Start warm: run all levels once on what ascends now, and put both membranes where they would end."""
        self.cerebellum.compensate()
        self.brainstem.gains()
        self.thalamus.weigh()
        self.thalamus.settle()
        self.spinal_cord.settle(self.descending.gravity_torque)

    def tick(self) -> None:
        """Run the levels that are due, in the order of Algorithm 1: sub-threads 1, 2, 3, 4."""
        self.ticks += 1
        schedule, ticks = self._schedule, self.ticks
        if ticks % schedule.first == 0:
            self.spinal_cord.act()
        if ticks % schedule.second == 0:
            self._second_order()
        if ticks % schedule.third == 0:
            self.cerebellum.compensate()

    def _second_order(self) -> None:
        """Brainstem and thalamus: answer, then learn from the error of the same tick (Algorithms 3 and 4)."""
        self.brainstem.gains()
        self.thalamus.weigh()
        self.thalamus.combine()
        if self._rule is not None:
            self._rule.evaluate()
            self.brainstem.learn(self.gradients.gains)
            self.thalamus.learn(self.gradients.weights)
