"""Checks of the contract on a recorded sequence, without a plant: what a controller must hold to be comparable.

A run is compared with a second one to the bit: after ``reset``, in a fresh instance, beside another instance, and with
inputs that the harness takes back. Whoever keeps an input, draws from an unseeded source or shares state is found.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace

import numpy as np

from .controller import hook
from .ledger import LedgerEntry
from .observation import Observation
from .target import Target
from .task import Task

MEASURED = ("q", "dq", "wrench", "command", "torque")
PLANNED = ("q", "dq", "ddq", "pose", "twist", "acceleration")


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One check and its outcome.

    Attributes:
        check: The law that was checked.
        passed: Whether it holds.
        detail: What was found, one line; empty if there is nothing to say.
    """

    check: str
    passed: bool
    detail: str = ""


def check_controller(
    factory: Callable[[], object], task: Task, observations: Sequence[Observation], targets: Sequence[Target]
) -> list[Finding]:
    """Check the contract on a controller.

    Args:
        factory: Makes the configured controller, a new one with each call.
        task: The episode; every reset gets a copy of its model.
        observations: What was recorded, one per tick, with arrays of their own.
        targets: The plan at the same ticks.

    Returns:
        One finding per law; where a run cannot be finished, the one that says why.
    """
    recording = _Recording(task, observations, targets)
    with ExitStack() as stack:

        def make() -> object:
            controller = factory()
            stack.callback(_close, controller)
            return controller

        first = make()
        try:
            with _faults("in supports"):
                reason = hook(first, "supports")(recording.task())  # type: ignore[operator]
            if reason:
                return [Finding(check="supports", passed=True, detail=f"refuses the task: {reason}")]
            expected = recording.play(first)
        except _Fault as fault:
            return [Finding(check=fault.check, passed=False, detail=fault.detail)]
        findings = [Finding(check=name, passed=True) for name in ("runs", "shape", "finite", "changes no input")]
        findings += [_compare(law, expected, run) for law, run in _second_runs(recording, first, make)]
        findings += [_hook_finding(name, check, first, recording) for name, check in _HOOKS]
        return findings


def _second_runs(
    recording: "_Recording", first: object, make: Callable[[], object]
) -> Iterator[tuple[str, Callable[[], np.ndarray]]]:
    """Yield the laws of repetition and the runs that show them."""
    if not getattr(first, "carry_over", False):
        yield "repeats after reset", lambda: recording.play(first)
    other = make()
    if other is first:
        # An object from code is the only one of its kind: there is nothing to put beside it.
        return
    yield "repeats in a fresh instance", lambda: recording.play(other)
    yield "repeats beside another instance", lambda: recording.play_beside(make(), make())
    yield "keeps no input", lambda: recording.play(make(), fresh_inputs=True)


class _Fault(Exception):
    """What ended a run of a recording: the law that is broken, and how."""

    def __init__(self, check: str, detail: str) -> None:
        self.check, self.detail = check, detail
        super().__init__(f"{check}: {detail}")


class _Desk:
    """Where a controller finds its inputs: buffers behind read-only views, as the harness hands them out."""

    def __init__(self, observation: Observation, target: Target) -> None:
        measured = {name: np.empty_like(getattr(observation, name)) for name in MEASURED}
        planned = {name: np.empty_like(getattr(target, name)) for name in PLANNED}
        self.buffers = [*measured.values(), *planned.values()]
        views = ({name: _view(array) for name, array in group.items()} for group in (measured, planned))
        self.observation = Observation(time=0.0, **next(views))
        self.target = Target(**next(views), reference=target.reference)

    def put(self, observation: Observation, target: Target) -> list[np.ndarray]:
        """Fill the buffers and return what went in."""
        values = [*(getattr(observation, name) for name in MEASURED), *(getattr(target, name) for name in PLANNED)]
        for buffer, value in zip(self.buffers, values, strict=True):
            np.copyto(buffer, value)
        self.observation.time = observation.time
        return values


@dataclass(frozen=True)
class _Recording:
    original: Task
    observations: Sequence[Observation]
    targets: Sequence[Target]

    def task(self) -> Task:
        """Return the task with a model of its own."""
        return replace(self.original, robot=self.original.robot.copy(), initial_q=self.original.initial_q.copy())

    def desk(self) -> _Desk:
        return _Desk(self.observations[0], self.targets[0])

    def reset(self, controller: object) -> None:
        with _faults("in reset"):
            controller.reset(self.task())  # type: ignore[attr-defined]

    def call(self, controller: object, desk: _Desk, k: int) -> np.ndarray:
        """Return a copy of the torque of tick k."""
        values = desk.put(self.observations[k], self.targets[k])
        with _faults(f"in tick {k}"):
            answer = controller.compute(desk.observation, desk.target)  # type: ignore[attr-defined]
        shape = self.original.initial_q.shape
        if getattr(answer, "shape", None) != shape:
            raise _Fault("shape", f"tick {k} returned {getattr(answer, 'shape', type(answer).__name__)}, not {shape}")
        if not np.can_cast(answer.dtype, np.float64, "same_kind") or not np.all(np.isfinite(answer)):
            raise _Fault("finite", f"tick {k} returned {answer}")
        torque = np.array(answer, dtype=float)
        if not all(np.array_equal(buffer, value) for buffer, value in zip(desk.buffers, values, strict=True)):
            raise _Fault("changes no input", f"tick {k} wrote into its arguments")
        return torque

    def play(self, controller: object, *, fresh_inputs: bool = False) -> np.ndarray:
        """Return the torques of a run, shape (ticks, n), with the same buffers or new ones for each tick."""
        self.reset(controller)
        ticks = len(self.observations)
        # With one desk, whoever kept an input of the last tick finds that of this one in its place.
        desks = [self.desk() for _ in range(ticks)] if fresh_inputs else [self.desk()] * ticks
        return np.array([self.call(controller, desk, k) for k, desk in enumerate(desks)])

    def play_beside(self, controller: object, other: object) -> np.ndarray:
        """Return the torques of a run whose ticks alternate with those of another instance, one tick behind."""
        self.reset(controller)
        self.reset(other)
        desk, rows = self.desk(), []
        for k in range(len(self.observations)):
            rows.append(self.call(controller, desk, k))
            if k:
                self.call(other, desk, k - 1)
        return np.array(rows)


def _compare(law: str, expected: np.ndarray, run: Callable[[], np.ndarray]) -> Finding:
    """Compare a second run with the first to the bit."""
    try:
        found = run()
    except _Fault as fault:
        return Finding(check=law, passed=False, detail=str(fault))
    if np.array_equal(found, expected):
        return Finding(check=law, passed=True)
    tick = int(np.flatnonzero(np.any(found != expected, axis=1))[0])
    difference = np.max(np.abs(found - expected))
    return Finding(check=law, passed=False, detail=f"differs from tick {tick} on, by up to {difference:.3g} N m")


def _diagnostics(controller: object, recording: _Recording) -> str:
    """Return what is wrong with the diagnostics: arrays stay where they are, the harness takes them once."""
    recording.reset(controller)
    shown = dict(hook(controller, "diagnostics")())  # type: ignore[operator]
    desk = recording.desk()
    for k in range(min(20, len(recording.observations))):
        recording.call(controller, desk, k)
    again = hook(controller, "diagnostics")()  # type: ignore[operator]
    for name, (array, period) in shown.items():
        if not isinstance(array, np.ndarray) or not isinstance(period, int) or period < 1:
            return f"{name!r} is not an array with a period in ticks"
        if name not in again or (array.size and not np.shares_memory(array, again[name][0])):
            return f"{name!r} moved to another array during the run"
    return ""


def _operations(controller: object, recording: _Recording) -> str:
    """Return what is wrong with the counters."""
    wrong = [name for name, count in hook(controller, "operations")().items() if int(count) != count or count < 0]  # type: ignore[operator]
    return f"{wrong[0]!r} is not a count" if wrong else ""


def _ledger(controller: object, recording: _Recording) -> str:
    """Return what is wrong with the ledger."""
    for entry in hook(controller, "ledger")():  # type: ignore[operator]
        if not isinstance(entry, LedgerEntry):
            return f"holds a {type(entry).__name__}, expected LedgerEntry"
        json.dumps(entry.value)
    return ""


_HOOKS = (("diagnostics", _diagnostics), ("operations", _operations), ("ledger", _ledger))


def _hook_finding(
    name: str, check: Callable[[object, _Recording], str], controller: object, recording: _Recording
) -> Finding:
    try:
        detail = check(controller, recording)
    except Exception as error:
        detail = _line(error)
    return Finding(check=name, passed=not detail, detail=detail)


@contextmanager
def _faults(where: str) -> Iterator[None]:
    """Turn what a controller raises into a fault."""
    try:
        yield
    except Exception as error:
        raise _Fault("runs", f"{where}: {_line(error)}") from error


def _line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def _close(controller: object) -> None:
    with suppress(Exception):
        hook(controller, "close")()  # type: ignore[operator]


def _view(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
