"""From a run specification to its rows: the run and its twins, or the repetitions of a chain, each in its own world."""

import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

from ..controllers import InvalidInput, PlugInFailure, UnknownName, build_controller, discovery, hook
from .events import EvaluateEvents, judge_events
from .loads import LoadSchedule
from .loop_study import loop_study
from .margin_study import margin_study
from .margins import LOOP_RESPONSE
from .result import FAILED, OK, RunResult, Scores
from .specification import CARRIED, RunSpecification, twin_schedules
from .studies import Judges, Prepare
from .trial import Evaluate, Keeping, Trial, run_trial
from .world import World

__all__ = ["TRACE_KINDS", "Evaluate", "EvaluateEvents", "Judges", "execute", "record", "rehearse"]

TRACE_KINDS = ("plot", "full", "none")
REHEARSED = 20
"""Ticks of a rehearsal."""


def execute(
    specification: RunSpecification,
    *,
    evaluate: Evaluate,
    evaluate_events: EvaluateEvents | None = None,
    judges: Judges | None = None,
    traces: str = "plot",
    plug_ins: Mapping[str, object] | None = None,
) -> tuple[RunResult, ...]:
    """Run one specification: a row for the run itself and for each twin, or for each repetition of its chain.

    A study is one row, whatever runs it takes.

    Args:
        specification: What to run.
        evaluate: Scores a log at full rate.
        evaluate_events: Compares a run with its twins at full rate; None leaves events out.
        judges: Judge the runs of a study; a study needs them.
        traces: ``plot`` keeps every tenth tick, ``full`` every tick and the controller's events, ``none`` nothing.
        plug_ins: Python objects behind controller names that no other door knows.

    Returns:
        The results; whatever goes wrong inside a run is a result with a status, not an exception.

    Raises:
        TorquebenchError: If robot, trajectory, load, plant or tier cannot be had, or a study has no judges.
    """
    if specification.study:
        return (_study(specification, judges, traces, plug_ins or {}),)
    cast = _Cast(specification, plug_ins or {}, Keeping(evaluate=evaluate, traces=traces))
    run = tuple(cast.trials("run", specification.schedule))
    if not specification.twins:
        return tuple(trial.result for trial in run)
    trials = {"run": run[0]}
    for role, history in twin_schedules(specification.schedule).items():
        (trials[role],) = cast.trials(role, history)
    results = {role: trial.result for role, trial in trials.items()}
    if evaluate_events is not None:
        results["run"] = judge_events(specification, trials, evaluate_events)
    return tuple(results.values())


def _study(
    specification: RunSpecification, judges: Judges | None, traces: str, plug_ins: Mapping[str, object]
) -> RunResult:
    """Return the row of a study; each of its runs has a controller of its own."""
    if judges is None:
        raise InvalidInput(f"study {specification.study!r}", "execute", "give the judges of a study")
    nothing = Keeping(evaluate=lambda _: Scores(metrics={}), traces="none")

    def play(probed: RunSpecification, prepare: Prepare | None = None) -> Trial:
        (trial,) = _Cast(probed, plug_ins, nothing, prepare).trials("run", probed.schedule)
        return trial

    if specification.study == LOOP_RESPONSE:
        return loop_study(specification, play, judges, keep=traces != "none")
    return margin_study(specification, play, judges)


def record(
    specification: RunSpecification, *, evaluate: Evaluate, plug_ins: Mapping[str, object] | None = None
) -> Trial:
    """Run one specification without its twins and keep every tick of it.

    Args:
        specification: What to run.
        evaluate: Scores a log at full rate.
        plug_ins: Python objects behind controller names that no other door knows.

    Raises:
        InvalidInput: If it is a study or a chain: neither is one run.
        TorquebenchError: If robot, trajectory, load, plant or tier cannot be had.
    """
    if specification.study or specification.protocol == CARRIED:
        came = f"a {specification.study} study" if specification.study else f"a chain of protocol {CARRIED!r}"
        raise InvalidInput(f"{came} is not one run", "run", "name a run of protocol 'fresh'")
    cast = _Cast(specification, plug_ins or {}, Keeping(evaluate=evaluate, traces="none"))
    (trial,) = cast.trials("run", specification.schedule)
    return trial


def rehearse(specification: RunSpecification, *, plug_ins: Mapping[str, object] | None = None) -> None:
    """Run the first ticks of a specification for their side effect: every kernel that it needs is compiled and cached.

    Args:
        specification: What to run.
        plug_ins: Python objects behind controller names that no other door knows.
    """
    world = World(specification, specification.schedule)
    world.times, world.table = world.times[:REHEARSED], world.table[:REHEARSED]
    nothing = Keeping(evaluate=lambda _: Scores(metrics={}), traces="none")
    cast = _Cast(specification, plug_ins or {}, nothing)
    try:
        controller = cast.controller()
        run_trial(world, controller, role="run", keeping=nothing)
        hook(controller, "close")()  # type: ignore[operator]
    finally:
        world.plant.close()


@dataclass(frozen=True)
class _Cast:
    """What the load histories of one specification share; ``prepare`` changes each world before its run."""

    specification: RunSpecification
    plug_ins: Mapping[str, object]
    keeping: Keeping
    prepare: Prepare | None = None

    def controller(self) -> object:
        """Return a new controller."""
        name = self.specification.controller
        factory = discovery.load("controllers", self.plug_ins.get(name, name))
        return build_controller(factory, self.specification.settings, name=name)

    def trials(self, role: str, history: LoadSchedule) -> Iterator[Trial]:
        """Yield the repetitions of one load history: one in ``fresh``, a chain on one controller in ``carried``.

        A repetition that ends early ends its chain: what would come after it has not been learnt as it should.
        """
        links = self.specification.links()
        begun = time.perf_counter()
        try:
            controller = self.controller()
        except (InvalidInput, PlugInFailure, UnknownName) as error:
            fault = RunResult(role=role, status=FAILED, cause="exception", reason=str(error))
            yield from (Trial(result=replace(fault, repetition=link.repetition)) for link in links)
            return
        ended: RunResult | None = None
        try:
            for link in links:
                if ended is not None:
                    yield Trial(result=_not_run(ended, link))
                    continue
                is_last = len(links) > 1 and link is links[-1]
                keeping = replace(self.keeping, snapshot=is_last)
                trial = self._one(link, role, history, controller, keeping, begun)
                ended = None if trial.result.status == OK else trial.result
                yield trial
                begun = time.perf_counter()
        finally:
            # The runs are over: what goes wrong in tidying up takes nothing from their results.
            with suppress(Exception):
                hook(controller, "close")()  # type: ignore[operator]

    def _one(
        self,
        link: RunSpecification,
        role: str,
        history: LoadSchedule,
        controller: object,
        keeping: Keeping,
        begun: float,
    ) -> Trial:
        """Run one repetition in a world of its own."""
        world = World(link, history)
        try:
            if self.prepare is not None:
                self.prepare(world)
            trial = run_trial(world, controller, role=role, keeping=keeping)
        finally:
            world.plant.close()
        timing = trial.result.timing
        stamped = {**timing, "total_s": time.perf_counter() - begun} if timing else {}
        return replace(trial, result=replace(trial.result, timing=stamped))


def _not_run(ended: RunResult, link: RunSpecification) -> RunResult:
    """Return the row of a repetition whose chain ended before it."""
    reason = f"the chain ended with repetition {ended.repetition}: {ended.reason}"
    return RunResult(role=ended.role, status=ended.status, repetition=link.repetition, cause="carried", reason=reason)
