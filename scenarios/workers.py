"""Worker processes: one run at a time each, one thread each, and a dead one costs only its run."""

import multiprocessing
import os
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from .execution import Evaluate, EvaluateEvents, Judges, execute, rehearse
from .result import FAILED, RunResult
from .specification import RunSpecification

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS",
)
HARD_EXIT = 1
"""Exit status of a process that the watchdog of an episode ended."""


@dataclass(frozen=True, kw_only=True)
class Duty:
    """What all runs of a campaign share.

    Attributes:
        evaluate: Scores a log.
        traces: Which traces are kept, see :func:`~.execution.execute`.
        plug_ins: Python objects behind controller names that no other door knows.
        evaluate_events: Compares a run with its twins; None leaves events out.
        judges: Judge the runs of studies; None where there are no studies.
    """

    evaluate: Evaluate
    traces: str
    plug_ins: Mapping[str, object]
    evaluate_events: EvaluateEvents | None = None
    judges: Judges | None = None


IDLE, REHEARSING = -1, -2


@dataclass
class _Worker:
    """A process, its pipe, what it is working on, and the position of that."""

    process: SpawnProcess
    pipe: Connection
    job: int = IDLE
    work: RunSpecification | list[RunSpecification] = field(default_factory=list)


def run_in_workers(
    specifications: Sequence[RunSpecification], duty: Duty, *, workers: int
) -> Iterator[tuple[int, tuple[RunResult, ...]]]:
    """Run specifications in worker processes.

    The first worker rehearses every controller before the others start: kernels are compiled once, into the cache.

    Args:
        specifications: What to run.
        duty: What all runs share; it must be picklable.
        workers: Number of processes, at least 1.

    Yields:
        The position of a specification and its results, in the order in which they finish.
    """
    waiting = list(range(len(specifications)))[::-1]
    crew: list[_Worker] = []
    try:
        crew.append(_hire(duty))
        _give(crew[0], REHEARSING, _one_of_each(specifications))
        while waiting or any(worker.job >= 0 for worker in crew):
            rehearsing = any(worker.job == REHEARSING for worker in crew)
            while waiting and not rehearsing and len(crew) < min(workers, len(specifications)):
                crew.append(_hire(duty))
            for worker in crew:
                if worker.job == IDLE and waiting:
                    job = waiting.pop()
                    _give(worker, job, specifications[job])
            for worker in _ready(crew):
                job, results = worker.job, _collect(worker, crew)
                if job >= 0:
                    yield job, results
    finally:
        for worker in crew:
            worker.process.kill()
            worker.process.join()
            worker.pipe.close()


def _one_of_each(specifications: Sequence[RunSpecification]) -> list[RunSpecification]:
    """Return the first specification of each controller with its settings."""
    first: dict[tuple[str, str], RunSpecification] = {}
    for specification in specifications:
        first.setdefault((specification.controller, repr(specification.settings)), specification)
    return list(first.values())


def _give(worker: _Worker, job: int, work: RunSpecification | list[RunSpecification]) -> None:
    """Send work to a worker; if it has died meanwhile, collecting its answer says so."""
    worker.job, worker.work = job, work
    with suppress(OSError):
        worker.pipe.send(work)


def _ready(crew: Sequence[_Worker]) -> list[_Worker]:
    """Wait until a worker has answered or died."""
    handles = [handle for worker in crew for handle in (worker.pipe, worker.process.sentinel)]
    events = wait(handles)
    return [worker for worker in crew if worker.pipe in events or worker.process.sentinel in events]


def _collect(worker: _Worker, crew: list[_Worker]) -> tuple[RunResult, ...]:
    """Take a worker's answer; a dead one leaves the crew and its run has failed."""
    try:
        if worker.pipe.poll():
            results: tuple[RunResult, ...] = worker.pipe.recv()
            worker.job = IDLE
            return results
    except (EOFError, OSError):
        pass
    worker.process.join()
    crew.remove(worker)
    worker.pipe.close()
    code = worker.process.exitcode
    if code == HARD_EXIT:
        return _lost(worker.work, "time-out", "a call of the controller did not return and its process was ended")
    name = signal.Signals(-code).name if code is not None and code < 0 else f"status {code}"
    return _lost(worker.work, "crash", f"the process of the run ended with {name}")


def _lost(work: RunSpecification | list[RunSpecification], cause: str, reason: str) -> tuple[RunResult, ...]:
    """Return the rows of a run of which nothing is left, one for each repetition; none for a rehearsal."""
    links = () if isinstance(work, list) else work.links()
    lost = RunResult(role="run", status=FAILED, cause=cause, reason=reason)
    return tuple(replace(lost, repetition=link.repetition) for link in links)


def _hire(duty: Duty) -> _Worker:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(theirs, duty), daemon=True)
    with _single_threaded():
        process.start()
    theirs.close()
    return _Worker(process=process, pipe=ours)


def _work(pipe: Connection, duty: Duty) -> None:
    """Run what comes through the pipe until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # A coordinator that was killed closes the pipe; what nobody waits for any more is dropped.
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            work = pipe.recv()
            pipe.send(_rehearsed(work, duty) if isinstance(work, list) else _guarded(work, duty))


def _rehearsed(specifications: list[RunSpecification], duty: Duty) -> tuple[RunResult, ...]:
    """Rehearse; what goes wrong here goes wrong in the run itself, which says so."""
    for specification in specifications:
        with suppress(Exception):
            rehearse(specification, plug_ins=duty.plug_ins)
    return ()


def _guarded(specification: RunSpecification, duty: Duty) -> tuple[RunResult, ...]:
    """Run a specification; whatever the harness itself stumbles over becomes a failed run too."""
    try:
        return execute(
            specification,
            evaluate=duty.evaluate,
            evaluate_events=duty.evaluate_events,
            judges=duty.judges,
            traces=duty.traces,
            plug_ins=duty.plug_ins,
        )
    except Exception as error:
        return _lost(specification, "exception", f"{type(error).__name__}: {' '.join(str(error).split())}")


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Let a new process find every thread pool set to one thread before it imports anything."""
    kept = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in kept.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value
