"""One run: sensors, target, controller, limiter, plant, log, a thousand times a second of simulated time."""

import faulthandler
import gc
import os
import signal
import threading
import time
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ..controllers import KnowledgeProvider, Observation, PayloadTruth, Reference, Target, hook
from ..controllers.kernels import bind
from .disturbance import Disturbance
from .plants.plant import Plant
from .tick import (
    DIVERGED,
    NOT_FINITE,
    OVERSPEED,
    POSITION_LIMIT,
    RUNNING,
    begin_tick,
    end_tick,
    frame_dtype,
    memory_dtype,
    start_memory,
    target_dtype,
)

CALL_LIMIT = 10.0
"""Longest wall time that one call of a controller may take [s]."""

DOUBLE = np.dtype(np.float64)
"""What laws return; anything else is converted with care, which takes longer."""

CAUSES = {
    NOT_FINITE: "nan torque",
    POSITION_LIMIT: "limit violation",
    OVERSPEED: "divergence",
    DIVERGED: "divergence",
}


class RunFailure(Exception):
    """What ended a run early: a cause from a short list and one line for a person."""

    def __init__(self, cause: str, reason: str) -> None:
        self.cause, self.reason = cause, reason
        super().__init__(reason)


class ControllerLike(Protocol):
    """The part of the contract that the loop needs."""

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick."""
        ...


@dataclass(frozen=True, kw_only=True)
class Episode:
    """Everything one run needs, built and reset.

    Attributes:
        controller: Reset already.
        provider: Payload knowledge, reset already.
        plant: At the initial state, with the first load.
        reference: The plan.
        table: The plan of every tick, record of :func:`~.tick.target_dtype`, shape (ticks,).
        times: Time of every tick, shape (ticks,) [s].
        constants: Record of :func:`~.tick.run_constants`, shape (1,).
        nominal_gravity: Gravity torque of arm and gripper at the start, shown at the first tick, shape (n,) [N m].
        noise: Force sensor noise, shape (ticks, 6), or (1, 6) of zeros [N, N m].
        loads: Tick to the slots' switches, for every change after the first.
        truth: The payload as ``oracle`` may see it; follows the plant.
        untold: Parameters of the load that the truth leaves out, shape (10,).
        disturbance: What disturbs sensors and commands, None for nothing.
    """

    controller: ControllerLike
    provider: KnowledgeProvider
    plant: Plant
    reference: Reference
    table: np.ndarray
    times: np.ndarray
    constants: np.ndarray
    nominal_gravity: np.ndarray
    noise: np.ndarray
    loads: Mapping[int, Sequence[bool]]
    truth: PayloadTruth
    untold: np.ndarray
    disturbance: Disturbance | None = None


@dataclass(kw_only=True)
class Outcome:
    """What a run left behind.

    Attributes:
        log: Finished ticks, record of :func:`~.tick.frame_dtype`.
        memory: Counters of the limiter and of velocity limits.
        diagnostics: Name to rows that the controller showed, and their period in ticks.
        failure: What ended the run early, or None.
        wall_time: Duration of the loop [s].
    """

    log: np.ndarray
    memory: np.ndarray
    diagnostics: dict[str, tuple[np.ndarray, int]] = field(default_factory=dict)
    failure: RunFailure | None = None
    wall_time: float = 0.0


def run_episode(episode: Episode) -> Outcome:
    """Run one episode to its end or to its failure.

    Args:
        episode: What to run; its controller, provider and plant are used up.

    Returns:
        The outcome; a failure of the controller is part of it, not an exception.
    """
    n, ticks = episode.plant.q.shape[0], episode.table.shape[0]
    frame, target = np.zeros(1, frame_dtype(n)), np.zeros(1, target_dtype(n))
    tier = episode.plant.tier
    memory = np.zeros(1, memory_dtype(n, delay=tier.delay_ticks))
    outcome = Outcome(log=np.zeros(ticks, frame_dtype(n)), memory=memory)
    plant = episode.plant
    start_memory(memory, episode.constants, plant.theta, plant.wrench, plant.gravity())
    frame["readback"] = frame["torque"] = episode.nominal_gravity
    recorder = _Recorder([])
    started = time.perf_counter()
    with _collector_paused(), _watchdog() as watch:
        try:
            recorder = _Recorder.of(episode.controller, ticks)
            for k in _ticks(episode, frame, target, outcome, watch):
                if recorder.sources:
                    recorder.record(k)
        except RunFailure as failure:
            outcome.failure = failure
    outcome.wall_time = time.perf_counter() - started
    outcome.log = outcome.log[: watch.rows]
    outcome.diagnostics = recorder.rows()
    return outcome


def _ticks(episode: Episode, frame: np.ndarray, target: np.ndarray, outcome: Outcome, watch: "_Watch") -> Iterator[int]:
    """Yield every finished tick."""
    plant, provider, controller = episode.plant, episode.provider, episode.controller
    table, memory, constants, noise, log = episode.table, outcome.memory, episode.constants, episode.noise, outcome.log
    observation, plan = observe(frame), aim(target, episode.reference)
    state = (plant.q, plant.dq, plant.theta, plant.dtheta, plant.wrench)
    command, torque = frame["command"][0], frame["torque"][0]
    acted, logged = plant.torque, log["torque"]
    begin = bind(begin_tick, frame, target, table, memory, constants, state, noise, tick=True)
    end = bind(end_tick, frame, target, log, memory, constants, tick=True)
    if episode.disturbance is not None:
        begin, end = episode.disturbance.on_sensors(begin, frame), episode.disturbance.on_command(end, memory)
    call_time, now = frame["call_time"], frame["time"]
    refresh, compute, step = provider.refresh, controller.compute, plant.step
    clock, shape, loads = time.perf_counter_ns, command.shape, episode.loads
    for k, instant in enumerate(episode.times.tolist()):
        if k in loads:
            change_load(episode, loads[k])
        watch.tick = k
        observation.time = instant
        begin(k)
        try:
            begun = clock()
            refresh(observation)
            answer = compute(observation, plan)
            spent = clock() - begun
            if getattr(answer, "shape", None) != shape:
                raise RunFailure("wrong shape", f"returned {_shape_of(answer)}, expected an array of shape {shape}")
            if answer.dtype is DOUBLE:
                command[:] = answer
            else:
                np.copyto(command, answer, casting="same_kind")
        except RunFailure:
            raise
        except Exception as error:
            raise RunFailure("exception", describe(error)) from error
        call_time[0], now[0] = spent, instant
        verdict = end(k)
        watch.rows = k + 1
        if verdict != RUNNING:
            raise RunFailure(CAUSES[verdict], _explain(verdict, frame[0], target[0], constants[0]))
        if spent > CALL_LIMIT * 1e9:
            raise RunFailure("time-out", f"one call took {spent * 1e-9:.1f} s, allowed {CALL_LIMIT:g} s")
        step(torque)
        logged[k] = acted
        yield k


def change_load(episode: Episode, active: Sequence[bool]) -> None:
    """Switch the plant's load and let the oracle see it."""
    episode.plant.set_load(active)
    np.subtract(episode.plant.payload, episode.untold, out=episode.truth.parameters)
    episode.truth.revision += 1


def observe(frame: np.ndarray) -> Observation:
    """Return the observation whose arrays are read-only views of a tick's record."""
    return Observation(
        time=0.0,
        q=_view(frame["q_measured"][0]),
        dq=_view(frame["dq_measured"][0]),
        wrench=_view(frame["wrench_measured"][0]),
        command=_view(frame["readback"][0]),
        torque=_view(frame["torque"][0]),
    )


def aim(target: np.ndarray, reference: Reference) -> Target:
    """Return the target whose arrays are read-only views of a tick's record."""
    names = ("q", "dq", "ddq", "pose", "twist", "acceleration")
    return Target(**{name: _view(target[name][0]) for name in names}, reference=reference)


def describe(error: BaseException) -> str:
    """Return an exception in one line with the place where it was raised."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text} ({last.filename.rsplit('/', 1)[-1]}:{last.lineno} in {last.name})"


def _explain(verdict: int, frame: np.void, target: np.void, constants: np.void) -> str:
    """Say in one line which joint ended the run, and by how much."""
    when = f"at {frame['time']:.3f} s"
    if verdict == NOT_FINITE:
        joint = int(np.flatnonzero(~np.isfinite(frame["command"]))[0])
        return f"torque of joint {joint + 1} is {frame['command'][joint]} {when}"
    if verdict == POSITION_LIMIT:
        excess = np.maximum(constants["lower"] - frame["q"], frame["q"] - constants["upper"])
        joint = int(np.argmax(excess))
        return f"joint {joint + 1} is {excess[joint]:.3g} rad beyond its position limit {when}"
    if verdict == OVERSPEED:
        joint = int(np.argmax(np.abs(frame["dq"])))
        return f"joint {joint + 1} moves at {frame['dq'][joint]:.3g} rad/s {when}"
    return f"joint error norm {np.linalg.norm(target['q'] - frame['q']):.3g} rad {when}"


def _shape_of(answer: object) -> str:
    return f"shape {answer.shape}" if isinstance(answer, np.ndarray) else type(answer).__name__


def _view(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view


@dataclass
class _Recorder:
    """Copies the rows of a controller's diagnostics."""

    sources: list[tuple[str, np.ndarray, int, np.ndarray]]
    ticks: int = 0

    @classmethod
    def of(cls, controller: object, ticks: int) -> "_Recorder":
        try:
            shown = hook(controller, "diagnostics")()  # type: ignore[operator]
            return cls(
                [
                    (name, view, period, np.zeros((-(-ticks // period), *view.shape), view.dtype))
                    for name, (view, period) in shown.items()
                ]
            )
        except Exception as error:
            raise RunFailure("exception", f"in diagnostics: {describe(error)}") from error

    def record(self, k: int) -> None:
        self.ticks = k + 1
        for _, view, period, rows in self.sources:
            if k % period == 0:
                rows[k // period] = view

    def rows(self) -> dict[str, tuple[np.ndarray, int]]:
        return {name: (rows[: -(-self.ticks // period)], period) for name, _, period, rows in self.sources}


@dataclass
class _Watch:
    """The tick that is being computed and the rows that are logged, for whoever watches from outside the loop."""

    tick: int = -1
    rows: int = 0


@contextmanager
def _watchdog() -> Iterator[_Watch]:
    """End a call that does not return: once a second an alarm looks whether the tick has moved on.

    A call that never comes back to Python sees no alarm; a timer outside the interpreter then ends the whole process,
    which a campaign notes as a failed run. Works in a process's main thread, where campaigns run; elsewhere only the
    time after the call is judged.
    """
    watch = _Watch()
    if threading.current_thread() is not threading.main_thread():
        yield watch
        return
    seen, since = -1, time.monotonic()

    def look(_signal: int, _frame: object) -> None:
        nonlocal seen, since
        faulthandler.dump_traceback_later(2.0 * CALL_LIMIT, exit=True, file=nowhere)
        if watch.tick != seen:
            seen, since = watch.tick, time.monotonic()
        elif time.monotonic() - since > CALL_LIMIT:
            raise RunFailure("time-out", f"a call did not return within {CALL_LIMIT:g} s (tick {watch.tick})")

    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        previous = signal.signal(signal.SIGALRM, look)
        signal.setitimer(signal.ITIMER_REAL, 1.0, 1.0)
        try:
            yield watch
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            faulthandler.cancel_dump_traceback_later()
            signal.signal(signal.SIGALRM, previous)


@contextmanager
def _collector_paused() -> Iterator[None]:
    """Keep the garbage collector out of the timed loop."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
