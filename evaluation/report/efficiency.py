"""What the controllers of a world compute for a second of simulated time, and what that is estimated to cost."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

from ...controllers.operations import OperationCosts, OperationCounts
from ...scenarios.store import StoredRun
from ..energy import Estimate, estimate
from .findings import POSITION, Findings
from .worlds import Run

CostsOf = Callable[[StoredRun], OperationCosts | None]
"""Takes a run to what its controller computes, None if nobody has counted it."""

TICKS = "ticks"
"""The event that every run counts: a call of the law."""


def no_costs(run: StoredRun) -> None:
    """Count nothing."""


@dataclass(frozen=True, kw_only=True)
class Computing:
    """What one controller computes.

    Attributes:
        costs: By event.
        counts: Operations for a second of simulated time, mean over the runs that finished, lead-in included.
        estimate: What they are estimated to cost.
    """

    costs: OperationCosts
    counts: OperationCounts
    estimate: Estimate


@dataclass(frozen=True, kw_only=True)
class Efficiency:
    """The computing of one world.

    Attributes:
        found: Controller to what it computes, in the order of the tables.
        uncounted: Controllers with runs that nobody has counted.
        fronts: Controllers that nobody of the same knowledge beats in both error and estimate, for arithmetic alone
            and with memory.
        errors: Mean position error of the controllers that ran the whole grid with few failures [m].
        knowledge: Controller to its knowledge of the load.
    """

    found: Mapping[str, Computing]
    uncounted: Sequence[str]
    fronts: tuple[frozenset[str], frozenset[str]]
    errors: Mapping[str, float]
    knowledge: Mapping[str, str]


def efficiency_of(findings: Findings, costs_of: CostsOf) -> Efficiency | None:
    """Return what the controllers of a world compute, None if nobody has counted any.

    Args:
        findings: The world's findings.
        costs_of: Knows what controllers compute; asked with one run of each.
    """
    found: dict[str, Computing] = {}
    uncounted: list[str] = []
    for label in findings.order:
        runs = [run for run in findings.runs_of(label) if run.row.status == "ok"]
        if runs:
            costs = costs_of(runs[0].stored)
            computing = None if costs is None else computing_of(runs, costs)
            if computing is None:
                uncounted.append(label)
            else:
                found[label] = computing
    if not found:
        return None
    errors = findings.ranking[POSITION]
    knowledge = {label: findings.runs_of(label)[0].stored.specification.knowledge for label in found}
    compared = [label for label in found if label in errors]
    arithmetic = {label: (errors[label], found[label].estimate.arithmetic) for label in compared}
    with_memory = {label: (errors[label], found[label].estimate.with_memory) for label in compared}
    return Efficiency(
        found=found,
        uncounted=uncounted,
        fronts=(front(arithmetic, knowledge), front(with_memory, knowledge)),
        errors=errors,
        knowledge=knowledge,
    )


def front(points: Mapping[str, tuple[float, float]], group: Mapping[str, str]) -> frozenset[str]:
    """Return whose point no other of its group dominates: not larger in either number, smaller in one.

    Args:
        points: Two numbers of each, smaller is better.
        group: What each is compared within.
    """

    def dominates(one: tuple[float, float], other: tuple[float, float]) -> bool:
        return one != other and one[0] <= other[0] and one[1] <= other[1]

    return frozenset(
        name
        for name, point in points.items()
        if not any(dominates(points[other], point) for other in points if group[other] == group[name])
    )


def computing_of(runs: Sequence[Run], costs: OperationCosts) -> Computing | None:
    """Return what runs of one controller computed, None if no run noted its time.

    Args:
        runs: The runs.
        costs: What the controller computes, by event.
    """
    seconds = sum(_seconds(run) for run in runs)
    if seconds <= 0.0:
        return None
    events: dict[str, float] = {}
    for run in runs:
        for name, count in _events(run).items():
            events[name] = events.get(name, 0.0) + count
    counts = OperationCounts()
    for name, cost in costs.by_event.items():
        counts += cost.times(events.get(name, 0.0) / seconds)
    kept = costs.parameters + costs.state
    return Computing(costs=costs, counts=counts, estimate=estimate(asdict(counts), touched=counts.touched, kept=kept))


def _seconds(run: Run) -> float:
    simulated = run.stored.result.timing.get("simulated_s")
    return float(simulated) if isinstance(simulated, int | float) else 0.0


def _events(run: Run) -> dict[str, float]:
    """Return how often each event came about: ticks, and the controller's own counters."""
    counted = run.stored.result.counts
    operations, ticks = counted.get("operations"), counted.get("ticks")
    found = {str(name): float(count) for name, count in operations.items()} if isinstance(operations, Mapping) else {}
    return {**found, TICKS: float(ticks) if isinstance(ticks, int | float) else 0.0}
