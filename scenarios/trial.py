"""One trial: a controller in a world that is ready, from its reset to its row, scored at full rate."""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace

import numpy as np

from ..controllers import Refusal, check_inertia, discovery, hook
from .diagnostics import figures
from .elastic_loop import check_springs
from .episode import Outcome, describe, run_episode
from .log import RunLog
from .result import FAILED, OK, REFUSED, RunResult, Scores
from .trace import encode_trace
from .world import World

Evaluate = Callable[[RunLog], Scores]
TRACE_STEP = 10
"""Every tenth tick of a run is kept in a plot trace."""
TRACED = ("t", "q", "q_ref", "p", "p_ref", "quat", "quat_ref", "tau", "tau_cmd", "wrench")


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A row and the log behind it.

    Attributes:
        result: The row.
        log: Every tick; None if the run never began, or a hook of the controller failed.
        frames: The same as the loop had it, with what the sensors gave: records of :func:`~.tick.frame_dtype`.
    """

    result: RunResult
    log: RunLog | None = None
    frames: np.ndarray | None = None


@dataclass(frozen=True, kw_only=True)
class Keeping:
    """What is made of a trial.

    Attributes:
        evaluate: Scores a log at full rate.
        traces: ``plot`` keeps every tenth tick, ``full`` every tick and the controller's events, ``none`` nothing.
        snapshot: Whether the trace also keeps what the controller learnt.
    """

    evaluate: Evaluate
    traces: str = "plot"
    snapshot: bool = False


class ControllerFault(Exception):
    """An optional hook of a controller that failed, in one line."""


def run_trial(world: World, controller: object, *, role: str, keeping: Keeping) -> Trial:
    """Reset, check and run a controller; whatever goes wrong with it is a row with a status.

    Args:
        world: Used up by this.
        controller: Built; what it has learnt is its own business.
        role: ``"run"``, or the name of a twin's load history.
        keeping: What is made of the trial.
    """
    row = RunResult(role=role, status=OK, repetition=world.specification.repetition)
    begun = time.perf_counter()
    try:
        provider = reset_controller(world, controller)
        reset_time = time.perf_counter() - begun
        outcome = run_episode(world.episode(controller, provider))
        timed = replace(row, timing=_timing(outcome, reset_time, world), provenance=_findings(provider))
        return _trial(world, controller, outcome, timed, keeping)
    except Refusal as refusal:
        return Trial(result=replace(row, status=REFUSED, cause="refused", reason=refusal.reason))
    except ControllerFault as fault:
        return Trial(result=replace(row, status=FAILED, cause="exception", reason=str(fault)))


def reset_controller(world: World, controller: object) -> object:
    """Reset knowledge and controller, and return the provider of knowledge.

    Raises:
        Refusal: If the controller declines the task, or its design would be unstable on this arm.
        ControllerFault: If one of its hooks failed.
    """
    task = world.task()
    provider = discovery.load("knowledge", task.knowledge)()  # type: ignore[operator]
    provider.reset(task.robot, task.actuation, world.truth)
    with _blamed("reset"):
        reason = hook(controller, "supports")(task)  # type: ignore[operator]
        if reason:
            raise Refusal(str(reason))
        controller.reset(task)  # type: ignore[attr-defined]
        design = hook(controller, "design_inertia")()  # type: ignore[operator]
        mass_matrix = world.plant.mass_matrix()
        check_inertia(design, mass_matrix, task.period)
        check_springs(design, world.tier, mass_matrix)
    return provider


def _trial(world: World, controller: object, outcome: Outcome, row: RunResult, keeping: Keeping) -> Trial:
    """Ask the controller for what it has to say of its run, and score the log."""
    with _blamed("ledger"):
        # There and back: what JSON cannot hold is found here and not when the campaign writes its rows.
        entries = [asdict(entry) for entry in hook(controller, "ledger")()]  # type: ignore[operator]
        ledger = json.loads(json.dumps(entries))
    with _blamed("operations"):
        operations = {name: int(count) for name, count in hook(controller, "operations")().items()}  # type: ignore[operator]
    log, failure = world.run_log(outcome), outcome.failure
    scores = keeping.evaluate(log) if failure is None else Scores(metrics={})
    with _blamed("diagnostics"):
        shown = {} if failure else figures(outcome.diagnostics, log.t, log.lap)
    result = replace(
        row,
        status=FAILED if failure else OK,
        cause=failure.cause if failure else "",
        reason=failure.reason if failure else "",
        failed_at=float(log.t[-1]) if failure and log.t.size else None,
        metrics=scores.metrics,
        laps=scores.laps,
        diagnostics=shown,
        ledger=ledger,
        counts=_counts(outcome, operations),
        timing={**row.timing, **scores.timing},
        provenance={**row.provenance, **_provenance(world, outcome)},
        trace=_trace(log, outcome, controller, keeping),
    )
    return Trial(result=result, log=log, frames=outcome.log)


@contextmanager
def _blamed(name: str) -> Iterator[None]:
    """Say in one line which hook of a controller failed."""
    try:
        yield
    except Refusal:
        raise
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


def _timing(outcome: Outcome, reset_time: float, world: World) -> dict[str, float]:
    """Return wall times; they belong to the machine, not to the result."""
    ticks, period = outcome.log.shape[0], world.tier.period
    calls = np.sort(outcome.log["call_time"]) * 1e-3
    simulated = ticks * period
    return {
        "reset_s": reset_time,
        "loop_s": outcome.wall_time,
        "simulated_s": simulated,
        "call_s": float(calls.sum() * 1e-6),
        "real_time_factor": simulated / outcome.wall_time if outcome.wall_time > 0.0 else 0.0,
        "call_us_median": float(calls[ticks // 2]) if ticks else 0.0,
        "call_us_p99": float(calls[min(ticks - 1, int(0.99 * ticks))]) if ticks else 0.0,
        "call_us_max": float(calls[-1]) if ticks else 0.0,
        "deadline_misses": float(np.count_nonzero(calls > period * 1e6)),
    }


def _findings(provider: object) -> dict[str, object]:
    """Return what a knowledge provider says of its run, if it says anything."""
    findings = getattr(provider, "findings", None)
    return {} if findings is None else {"knowledge": dict(findings())}


def _provenance(world: World, outcome: Outcome) -> dict[str, object]:
    """Return what a reader of row and trace has to know: row j of a diagnostic is that of tick j times its period."""
    drawn = {"draws": world.draws.as_table()} if world.specification.draws else {}
    return {
        **drawn,
        "group": world.plan.group,
        "plant": world.plant.name,
        "payload": world.truth.parameters.tolist(),
        "tick_s": world.tier.period,
        "diagnostics": {name: period for name, (_, period) in outcome.diagnostics.items()},
    }


def _trace(log: RunLog, outcome: Outcome, controller: object, keeping: Keeping) -> bytes | None:
    """Return the arrays that are kept: every tick in double precision, or every tenth in single."""
    if keeping.traces == "none":
        return None
    full = keeping.traces == "full"
    step, kind = (1, np.float64) if full else (TRACE_STEP, np.float32)
    kept = {name: getattr(log, name)[::step].astype(kind) for name in TRACED}
    kept |= {f"diagnostics/{name}": rows for name, (rows, _) in outcome.diagnostics.items()}
    kept |= _asked(controller, "events") if full else {}
    kept |= _asked(controller, "snapshot") if keeping.snapshot else {}
    return encode_trace(kept)


def _asked(controller: object, name: str) -> dict[str, np.ndarray]:
    """Return the arrays of a hook by their names in the trace."""
    with _blamed(name):
        arrays = {f"{name}/{key}": np.asarray(array) for key, array in hook(controller, name)().items()}  # type: ignore[operator]
        wrong = [key for key, array in arrays.items() if array.dtype.kind not in "biuf"]
        if wrong:
            raise TypeError(f"{wrong[0]!r} is no array of numbers")
        return arrays
