"""A campaign: what a benchmark asks for and the store does not hold yet, run and written as it finishes."""

import shlex
import sys
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime

from ..controllers import InvalidInput
from .benchmark import Benchmark
from .digest import run_digest
from .execution import Evaluate, EvaluateEvents, Judges
from .expansion import Expansion, expand
from .gate import require, run_gate
from .latency import MEASURED
from .machine import commit, machine, machine_label, versions
from .margins import LOOP_RESPONSE
from .result import FAILED, OK, RunResult
from .specification import RunSpecification, twin_schedules
from .store import Store
from .workers import Duty, run_in_workers
from .world import cached_plan, cached_robot

UNMEASURED_SPEED = 20.0
"""Assumed times real time per process for a controller that has no run in the store yet."""

USUAL_PROBES = 8
"""Whole runs that the search of a margin usually takes; more are tried, but many of them end early."""


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """A benchmark against a store.

    Attributes:
        benchmark: The benchmark.
        expansion: All its runs.
        addresses: Their addresses, in the same order.
        mine: Positions of the runs of this shard.
        pending: Those of them that are to be done.
        plug_ins: Python objects behind controller names that no other door knows.
    """

    benchmark: Benchmark
    expansion: Expansion
    addresses: tuple[str, ...]
    mine: tuple[int, ...]
    pending: tuple[int, ...]
    plug_ins: Mapping[str, object] = field(default_factory=dict)

    @property
    def runs(self) -> tuple[RunSpecification, ...]:
        """The runs that are to be done."""
        return tuple(self.expansion.specifications[position] for position in self.pending)

    def against(self, statuses: Mapping[str, str], *, retry_failed: bool = False) -> "Campaign":
        """Return the campaign with what is still to be done.

        Args:
            statuses: Address to status of what a store holds.
            retry_failed: Whether failed runs are tried again.
        """
        done = {address for address, status in statuses.items() if not (retry_failed and status == FAILED)}
        return replace(self, pending=tuple(position for position in self.mine if self.addresses[position] not in done))


@dataclass(frozen=True, kw_only=True)
class Finished:
    """A run that was just written.

    Attributes:
        specification: The run.
        results: The run and its twins, or the repetitions of its chain.
        simulated: Its simulated time, twins and repetitions included [s].
    """

    specification: RunSpecification
    results: tuple[RunResult, ...]
    simulated: float

    @property
    def failed(self) -> bool:
        """Whether the run, a twin or a repetition failed."""
        return any(result.status == FAILED for result in self.results)


def plan_campaign(
    benchmark: Benchmark,
    statuses: Mapping[str, str],
    *,
    shard: tuple[int, int] = (1, 1),
    retry_failed: bool = False,
    plug_ins: Mapping[str, object] | None = None,
) -> Campaign:
    """Return what is to be done.

    Args:
        benchmark: The benchmark.
        statuses: Address to status of what a store holds.
        shard: Part i of n, counted from 1.
        retry_failed: Whether failed runs are tried again.
        plug_ins: Python objects behind controller names that no other door knows.

    Raises:
        TorquebenchError: If something the runs need is wrong.
    """
    expansion = expand(benchmark, plug_ins=plug_ins)
    addresses = tuple(_address(item, plug_ins) for item in expansion.specifications)
    part, parts = shard
    mine = tuple(range(part - 1, len(addresses), parts))
    everything = Campaign(
        benchmark=benchmark,
        expansion=expansion,
        addresses=addresses,
        mine=mine,
        pending=mine,
        plug_ins=plug_ins or {},
    )
    return everything.against(statuses, retry_failed=retry_failed)


def _address(specification: RunSpecification, plug_ins: Mapping[str, object] | None) -> str:
    """Return the address of a run; where latency is measured, the machine is part of the result and so of it."""
    digest = run_digest(specification, plug_ins)
    return specification.address(f"{digest}\n{machine_label()}" if specification.latency == MEASURED else digest)


def _stamped(specification: RunSpecification, result: RunResult) -> RunResult:
    """Return a result with the machine on its timing and, where latency is measured, on the result itself."""
    own = {"machine": machine_label()}
    provenance = {**result.provenance, **own} if specification.latency == MEASURED else result.provenance
    return replace(result, timing={**result.timing, **own}, provenance=provenance)


def run_campaign(
    campaign: Campaign,
    store: Store,
    *,
    evaluate: Evaluate,
    evaluate_events: EvaluateEvents | None = None,
    judges: Judges | None = None,
    workers: int = 1,
    traces: str = "plot",
) -> Iterator[Finished]:
    """Do what is to be done: check the plant, run, write each run as it finishes.

    Args:
        campaign: What to do.
        store: Where results go, open for writing.
        evaluate: Scores a log; picklable.
        evaluate_events: Compares a run with its twins; picklable; None leaves events out.
        judges: Judge the runs of studies; picklable; None where there are no studies.
        workers: Number of processes.
        traces: Which traces are kept, see :func:`~.execution.execute`.

    Yields:
        Each run after it was written.

    Raises:
        GateFailure: If the plant does not compute the arm's equations; nothing runs then.
    """
    if not campaign.pending:
        return
    store.put_campaign(datetime.now(UTC).isoformat(timespec="seconds"), _record(campaign, workers))
    duty = Duty(
        evaluate=evaluate,
        evaluate_events=evaluate_events,
        judges=judges,
        traces=traces,
        plug_ins=campaign.plug_ins,
    )
    runs = campaign.runs
    for job, results in run_in_workers(runs, duty, workers=workers):
        specification = runs[job]
        stamped = tuple(_stamped(specification, result) for result in results)
        store.put(campaign.addresses[campaign.pending[job]], specification, stamped)
        yield Finished(specification=specification, results=stamped, simulated=simulated_time(specification))


def _record(campaign: Campaign, workers: int) -> dict[str, object]:
    """Return the provenance of a campaign; the gate is run here, and insisted on."""
    benchmark, expansion = campaign.benchmark, campaign.expansion
    robot = cached_robot(benchmark.robot, benchmark.tool)
    plants = sorted({specification.plant for specification in campaign.runs})
    checks = [check for plant in plants for check in run_gate(robot, plant)]
    require(tuple(checks))
    named = {"name": benchmark.name, "title": benchmark.title, "description": benchmark.description}
    return {
        "benchmark": {**named, "reference": expansion.reference},
        "command": shlex.join(["torquebench", *sys.argv[1:]]),
        "notes": list(expansion.notes),
        "versions": versions(),
        "commit": commit(),
        "machine": machine(),
        "seed": benchmark.seed,
        "workers": workers,
        "gate": [{**asdict(check), "passed": check.passed} for check in checks],
    }


def simulated_time(specification: RunSpecification) -> float:
    """Return the simulated time of a run with its twins or repetitions [s]; of a margin, what one usually takes."""
    robot = cached_robot(specification.robot, specification.tool)
    plan = cached_plan(robot, specification.trajectory, specification.lead_in)
    histories = 1 + (len(twin_schedules(specification.schedule)) if specification.twins else 0)
    if specification.study:
        histories = robot.n if specification.study == LOOP_RESPONSE else USUAL_PROBES
    return specification.repetitions * histories * (specification.lead_in + specification.laps * plan.period)


def predicted_time(campaign: Campaign, store: Store | None, *, workers: int) -> tuple[float, float]:
    """Return the simulated time of what is to be done, and the wall time that this machine will need [s].

    Speeds are those of the store's own runs on this machine, controller by controller; without any, a guess.

    Args:
        campaign: What is to be done.
        store: The store, None if there is none yet.
        workers: Number of processes.
    """
    speeds = _known_speeds(store) if store is not None else {}
    simulated = wall = 0.0
    for specification in campaign.runs:
        duration = simulated_time(specification)
        simulated += duration
        wall += duration / speeds.get(specification.controller, UNMEASURED_SPEED)
    return simulated, wall / workers


def _known_speeds(store: Store) -> dict[str, float]:
    """Return the measured times real time, overheads included, by controller."""
    totals: dict[str, list[float]] = {}
    for run in store.runs():
        timing = run.result.timing
        # A run that failed early says little of the speed of one that does not.
        if run.result.status == OK and timing.get("machine") == machine_label() and timing.get("total_s"):
            pair = totals.setdefault(run.specification.controller, [0.0, 0.0])
            pair[0] += float(timing["simulated_s"])
            pair[1] += float(timing["total_s"])
    return {controller: simulated / wall for controller, (simulated, wall) in totals.items()}


def parse_shard(text: str) -> tuple[int, int]:
    """Return part and number of parts of ``i/n``.

    Raises:
        InvalidInput: If it is no such pair.
    """
    part, _, parts = text.partition("/")
    if not (part.isdigit() and parts.isdigit() and 1 <= int(part) <= int(parts)):
        raise InvalidInput(repr(text), "--shard", "expected i/n with 1 <= i <= n, for example 2/8")
    return int(part), int(parts)
