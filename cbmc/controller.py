"""CBMC-V3 as a controller like any other: builds the stack at reset and hands it every tick's measurements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..controllers import Controller, InvalidInput, LedgerEntry, Observation, Target, Task
from .brainstem import Brainstem, BrainstemTable
from .cerebellum import Cerebellum
from .cerebral_cortex import CerebralCortex
from .diagnostics import ledger, live_arrays
from .guard import Caps, gain_caps
from .learning import FeedbackError, Rule
from .online_network import OnlineNetwork
from .operations import count_operations
from .pathways import Ascending, Descending
from .patterns import Patterns, find_patterns
from .raster import Raster, listen_to_cerebellum, listen_to_network
from .spinal_cord import RateEncoder, SpinalCord, SpinalCordTable
from .stack import FirstOrder, Mixture, Regulation, Schedule, Stack, ThirdOrder
from .thalamus import Thalamus, ThalamusTable

STARTS = ("warm", "cold")
REST_STIFFNESS, REST_DAMPING = 200.0, 20.0
"""Gains before the brainstem has answered for the first time: what it gives at rest, a u and b u with u = 10."""


@dataclass(kw_only=True)
class CbmcV3(Controller):
    """Five spiking modules on three levels that learn online.

    The paper's framework with the readings of the page "Reading the paper"; the modules' own files hold its tables
    and equations. The known model enters twice only: it finds the patterns, and it tells the guard how light the
    joints are. An ablation or a null control replaces what one of the underscored methods builds.

    Attributes:
        start: ``"warm"`` runs all levels once before the first tick; ``"cold"`` starts without gravity torque.
        sensitivity: Of joint position to torque, in the learning rule [rad/(N m)].
        force_scale: What forces [N] and torques [N m] are divided by before the thalamus.
        biases: Whether the online networks have biases.
        patterns: File of trained patterns; empty for those that fit the robot.
        stiffness_range: Clamp on K_P [N m/rad].
        damping_range: Clamp on K_V [N m s/rad].
        raster: Most spikes that are kept for each layer, for full traces; 0 for none.
    """

    uses_model: ClassVar[bool] = False
    thalamus: ClassVar[type[Thalamus]] = Thalamus

    start: str = "warm"
    sensitivity: float = 0.2
    force_scale: tuple[float, float] = (50.0, 10.0)
    biases: bool = True
    patterns: str = ""
    stiffness_range: tuple[float, float] = (50.0, 2000.0)
    damping_range: tuple[float, float] = (2.0, 60.0)
    raster: int = 0

    def __post_init__(self) -> None:
        """Check what needs no robot."""
        if self.start not in STARTS:
            raise InvalidInput(f"start = {self.start!r}", "setting 'start'", f"one of {', '.join(STARTS)}")
        if not self.sensitivity > 0.0:
            raise InvalidInput(f"sensitivity = {self.sensitivity:g}", "setting 'sensitivity'", "a positive number")

    def supports(self, task: Task) -> str | None:
        """Return None, or that the arm has no patterns and how to train them."""
        try:
            self._patterns(task)
        except InvalidInput as reason:
            return str(reason)
        return None

    def reset(self, task: Task) -> None:
        """Build the stack from the task's seed; nothing of an earlier episode remains."""
        patterns = self._patterns(task)
        joints = task.robot.n
        self.up, self.down = Ascending.of(joints), Descending.of(joints, patterns.count)
        seeds = np.random.SeedSequence(task.seed).spawn(3)
        thalamus, brainstem, spinal = (np.random.default_rng(seed) for seed in seeds)
        self.cortex = CerebralCortex()
        self.cortex.connect(self.up)
        self.caps = self._caps(task)
        self.stack = Stack(
            ascending=self.up,
            descending=self.down,
            cerebellum=self._cerebellum(task, patterns),
            thalamus=self._thalamus(task, patterns, thalamus),
            brainstem=self._brainstem(task, brainstem),
            spinal_cord=self._spinal_cord(task, spinal),
            rule=self._rule(),
            schedule=self._schedule(),
        )
        self.waiting = self.start == "warm"
        self.spikes = Raster(self.raster)
        if self.raster:
            self._listen()
        self.loads = patterns.loads
        self.notes = patterns.notes

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        up = self.up
        up.q[:] = observation.q
        up.dq[:] = observation.dq
        up.wrench[:] = observation.wrench
        self.cortex.replay(target)
        if self.waiting:
            self.stack.settle()
            self.waiting = False
        self.stack.tick()
        return self.down.torque

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return weights, gains, torques, spikes, losses and counters with their periods."""
        return live_arrays(self.stack, self._schedule())

    def operations(self) -> Mapping[str, int]:
        """Return the cumulative operation counts."""
        stack = self.stack
        return count_operations(stack.cerebellum, stack.thalamus, stack.brainstem, stack.spinal_cord)

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from, and the guard's caps."""
        return ledger(self, self.caps, self.notes)

    def events(self) -> Mapping[str, np.ndarray]:
        """Return the spike rasters that the setting ``raster`` asked for."""
        return self.spikes.events()

    def snapshot(self) -> Mapping[str, np.ndarray]:
        """Return the learnt parameters of the online networks by module."""
        return {name: network.parameters.copy() for name, network in self._networks().items()}

    def _networks(self) -> Mapping[str, OnlineNetwork]:
        """Return the networks that learn, by module; a stand-in has none."""
        modules = {"thalamus": self.stack.thalamus, "brainstem": self.stack.brainstem}
        return {name: module.network for name, module in modules.items() if hasattr(module, "network")}

    def _listen(self) -> None:
        """Let a raster listen to the modules that spike."""
        stack, spikes = self.stack, self.spikes
        if isinstance(stack.cerebellum, Cerebellum):
            stack.cerebellum.compensate = listen_to_cerebellum(spikes, stack.cerebellum, self.up)  # type: ignore[method-assign]
        if isinstance(stack.thalamus, Thalamus):
            weigh = listen_to_network(spikes, "thalamus", stack.thalamus.network, stack.thalamus.weigh)
            stack.thalamus.weigh = weigh  # type: ignore[method-assign]
        if isinstance(stack.brainstem, Brainstem):
            gains = listen_to_network(spikes, "brainstem", stack.brainstem.network, stack.brainstem.gains)
            stack.brainstem.gains = gains  # type: ignore[method-assign]

    def _patterns(self, task: Task) -> Patterns:
        """Return the patterns that the cerebellum holds."""
        return find_patterns(task.robot, self.patterns)

    def _caps(self, task: Task) -> Caps:
        """Return the guard's caps on the gains."""
        membrane, period = SpinalCordTable().membrane.tau_mb, self._schedule().first * task.period
        return gain_caps(task.robot, task.initial_q, task.actuation, period=period, membrane=membrane)

    def _cerebellum(self, task: Task, patterns: Patterns) -> ThirdOrder:
        cerebellum = Cerebellum(patterns)
        cerebellum.connect(self.up, self.down)
        return cerebellum

    def _thalamus(self, task: Task, patterns: Patterns, rng: np.random.Generator) -> Mixture:
        scale, table = self.force_scale, ThalamusTable()
        thalamus = self.thalamus(task.robot.n, patterns.count, table, rng, force_scale=scale, biases=self.biases)
        thalamus.connect(self.up, self.down)
        return thalamus

    def _brainstem(self, task: Task, rng: np.random.Generator) -> Regulation:
        brainstem = Brainstem(task.robot.n, BrainstemTable(), rng, biases=self.biases)
        brainstem.stiffness_range[:] = capped_range(self.stiffness_range, self.caps.stiffness)
        brainstem.damping_range[:] = capped_range(self.damping_range, self.caps.damping)
        self.down.stiffness[:] = np.minimum(REST_STIFFNESS, brainstem.stiffness_range[1])
        self.down.damping[:] = np.minimum(REST_DAMPING, brainstem.damping_range[1])
        brainstem.connect(self.up, self.down)
        return brainstem

    def _spinal_cord(self, task: Task, rng: np.random.Generator) -> FirstOrder:
        table = self._spinal_table()
        spinal_cord = SpinalCord(task.robot.n, table, RateEncoder(task.robot.n, table, rng))
        spinal_cord.connect(self.up, self.down)
        return spinal_cord

    def _spinal_table(self) -> SpinalCordTable:
        return SpinalCordTable()

    def _rule(self) -> Rule | None:
        return FeedbackError(sensitivity=self.sensitivity)

    def _schedule(self) -> Schedule:
        return Schedule()


def capped_range(clamp: tuple[float, float], caps: np.ndarray) -> np.ndarray:
    """Return the range of a gain: the cap wins over the clamp, at its floor too.

    Args:
        clamp: Floor and ceiling.
        caps: Cap of each joint, infinite for none, shape (n,).

    Returns:
        Floors and ceilings, shape (2, n).
    """
    return np.array([np.minimum(bound, caps) for bound in clamp])
