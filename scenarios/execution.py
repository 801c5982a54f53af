"""From a run specification to its results: the run and its twins, each in a world of its own, scored at full rate."""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, replace

import numpy as np

from ..controllers import (
    InvalidInput,
    PlugInFailure,
    Refusal,
    UnknownName,
    build_controller,
    check_inertia,
    discovery,
    hook,
)
from .episode import Outcome, describe, run_episode
from .loads import LoadSchedule
from .log import RunLog
from .result import FAILED, OK, REFUSED, RunResult, Scores
from .specification import RunSpecification, twin_schedules
from .trace import encode_trace
from .world import World

Evaluate = Callable[[RunLog], Scores]
TRACE_KINDS = ("plot", "full", "none")
TRACE_STEP = 10
"""Every tenth tick of a run is kept in a plot trace."""
REHEARSED = 20
"""Ticks of a rehearsal."""
TRACED = ("t", "q", "q_ref", "p", "p_ref", "quat", "quat_ref", "tau", "tau_cmd", "wrench")


class ControllerFault(Exception):
    """An optional hook of a controller that failed, in one line."""


def execute(
    specification: RunSpecification,
    *,
    evaluate: Evaluate,
    traces: str = "plot",
    plug_ins: Mapping[str, object] | None = None,
) -> tuple[RunResult, ...]:
    """Run one specification: a row for the run itself and one for each twin.

    Args:
        specification: What to run.
        evaluate: Scores a log at full rate.
        traces: ``plot`` keeps every tenth tick, ``full`` every tick, ``none`` nothing.
        plug_ins: Python objects behind controller names that no other door knows.

    Returns:
        The results; whatever goes wrong inside a run is a result with a status, not an exception.

    Raises:
        TorquebenchError: If robot, trajectory, load, plant or tier cannot be had.
    """
    histories = {"run": specification.schedule}
    if specification.twins:
        histories |= twin_schedules(specification.schedule)
    door = (plug_ins or {}).get(specification.controller, specification.controller)
    return tuple(_run(specification, role, history, door, evaluate, traces) for role, history in histories.items())


def rehearse(specification: RunSpecification, *, plug_ins: Mapping[str, object] | None = None) -> None:
    """Run the first ticks of a specification for their side effect: every kernel that it needs is compiled and cached.

    Args:
        specification: What to run.
        plug_ins: Python objects behind controller names that no other door knows.
    """
    door = (plug_ins or {}).get(specification.controller, specification.controller)
    world = World(specification, specification.schedule)
    world.times, world.table = world.times[:REHEARSED], world.table[:REHEARSED]
    try:
        controller = build_controller(
            discovery.load("controllers", door), specification.settings, name=specification.controller
        )
        _run_controller(world, "run", controller, lambda _: Scores(metrics={}), "none")
        hook(controller, "close")()  # type: ignore[operator]
    finally:
        world.plant.close()


def _run(
    specification: RunSpecification,
    role: str,
    history: LoadSchedule,
    door: object,
    evaluate: Evaluate,
    traces: str,
) -> RunResult:
    """Run one load history of a specification."""
    started = time.perf_counter()
    world = World(specification, history)
    try:
        factory = discovery.load("controllers", door)
        controller = build_controller(factory, specification.settings, name=specification.controller)
    except (InvalidInput, PlugInFailure, UnknownName) as error:
        world.plant.close()
        return RunResult(role=role, status=FAILED, cause="exception", reason=str(error))
    try:
        result = _run_controller(world, role, controller, evaluate, traces)
        timing = {**result.timing, "total_s": time.perf_counter() - started} if result.timing else {}
        return replace(result, timing=timing)
    except ControllerFault as fault:
        return RunResult(role=role, status=FAILED, cause="exception", reason=str(fault))
    finally:
        # The run is over: what goes wrong in tidying up takes nothing from its result.
        with suppress(Exception):
            hook(controller, "close")()  # type: ignore[operator]
        world.plant.close()


def _run_controller(world: World, role: str, controller: object, evaluate: Evaluate, traces: str) -> RunResult:
    """Reset, check and run a controller in a world that is ready."""
    task = world.task()
    provider = discovery.load("knowledge", task.knowledge)()  # type: ignore[operator]
    provider.reset(task.robot, task.actuation, world.truth)
    begun = time.perf_counter()
    try:
        reason = hook(controller, "supports")(task)  # type: ignore[operator]
        if reason:
            raise Refusal(str(reason))
        controller.reset(task)  # type: ignore[attr-defined]
        check_inertia(hook(controller, "design_inertia")(), world.plant.mass_matrix(), task.period)  # type: ignore[operator]
    except Refusal as refusal:
        return RunResult(role=role, status=REFUSED, cause="refused", reason=refusal.reason)
    except Exception as error:
        return RunResult(role=role, status=FAILED, cause="exception", reason=f"in reset: {describe(error)}")
    reset_time = time.perf_counter() - begun
    outcome = run_episode(world.episode(controller, provider))
    with _blamed("ledger"):
        # There and back: what JSON cannot hold is found here and not when the campaign writes its rows.
        entries = [asdict(entry) for entry in hook(controller, "ledger")()]  # type: ignore[operator]
        ledger = json.loads(json.dumps(entries))
    with _blamed("operations"):
        operations = {name: int(count) for name, count in hook(controller, "operations")().items()}  # type: ignore[operator]
    log = world.run_log(outcome)
    failure = outcome.failure
    scores = evaluate(log) if failure is None else Scores(metrics={})
    return RunResult(
        role=role,
        status=FAILED if failure else OK,
        cause=failure.cause if failure else "",
        reason=failure.reason if failure else "",
        failed_at=float(log.t[-1]) if failure and log.t.size else None,
        metrics=scores.metrics,
        laps=scores.laps,
        ledger=ledger,
        counts=_counts(outcome, operations),
        timing=_timing(outcome, reset_time, world.tier.period),
        provenance={"group": world.plan.group, "plant": world.plant.name, "payload": world.truth.parameters.tolist()},
        trace=_trace(log, outcome, traces),
    )


@contextmanager
def _blamed(name: str) -> Iterator[None]:
    """Say in one line which hook of a controller failed."""
    try:
        yield
    except Exception as error:
        raise ControllerFault(f"in {name}: {describe(error)}") from error


def _counts(outcome: Outcome, operations: Mapping[str, int]) -> dict[str, object]:
    """Return what was counted: ticks, clipped ticks by cause and joint, speed limits, operations."""
    memory = outcome.memory[0]
    return {
        "ticks": int(outcome.log.shape[0]),
        "clipped_effort": memory["clipped"][0].tolist(),
        "clipped_rate": memory["clipped"][1].tolist(),
        "velocity_limit": memory["overspeed"].tolist(),
        "operations": operations,
    }


def _timing(outcome: Outcome, reset_time: float, period: float) -> dict[str, float]:
    """Return wall times; they belong to the machine, not to the result."""
    ticks = outcome.log.shape[0]
    calls = np.sort(outcome.log["call_time"]) * 1e-3
    simulated = ticks * period
    return {
        "reset_s": reset_time,
        "loop_s": outcome.wall_time,
        "simulated_s": simulated,
        "real_time_factor": simulated / outcome.wall_time if outcome.wall_time > 0.0 else 0.0,
        "call_us_median": float(calls[ticks // 2]) if ticks else 0.0,
        "call_us_p99": float(calls[min(ticks - 1, int(0.99 * ticks))]) if ticks else 0.0,
        "call_us_max": float(calls[-1]) if ticks else 0.0,
        "deadline_misses": float(np.count_nonzero(calls > period * 1e6)),
    }


def _trace(log: RunLog, outcome: Outcome, traces: str) -> bytes | None:
    """Return the arrays that are kept: every tick in double precision, or every tenth in single."""
    if traces == "none":
        return None
    step, kind = (1, np.float64) if traces == "full" else (TRACE_STEP, np.float32)
    kept = {name: getattr(log, name)[::step].astype(kind) for name in TRACED}
    kept |= {f"diagnostics/{name}": rows for name, (rows, _) in outcome.diagnostics.items()}
    return encode_trace(kept)
