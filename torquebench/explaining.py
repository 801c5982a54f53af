"""One cell of a report down to its runs: their values, the worst of them, and how to have it again."""

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .controllers import InvalidInput
from .evaluation.metrics import Metric
from .evaluation.report.findings import HEADLINES, WINDOW
from .evaluation.report.worlds import Run, worlds_of
from .evaluation.rows import find_metric, read
from .plug_in_metrics import all_metrics
from .repeating import obstacle
from .scenarios.store import Store
from .selection import Selection, one_label, one_world


@dataclass(frozen=True, kw_only=True)
class ExplainedRun:
    """A run behind a cell.

    Attributes:
        address: Its address.
        trajectory: Its motion.
        load: Its load history in words.
        seed: Seed of its campaign.
        repetition: Number of the repetition.
        status: ``ok``, ``failed`` or ``refused``.
        reason: Why it ended early, empty if it did not.
        values: Metric id to value in its stored unit; None where there is none.
    """

    address: str
    trajectory: str
    load: str
    seed: int
    repetition: int
    status: str
    reason: str
    values: Mapping[str, float | None]


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """What stands behind one cell.

    Attributes:
        controller: Label of the controller.
        world: Id of the world on the page.
        facts: What all its runs share.
        metric: Id of the metric that says which run is worst.
        unit: Its stored unit.
        runs: The runs, in the order of the page.
        mean: Mean of the values that there are, None without any.
        worst: The run that failed, or has the worst value.
        command: What runs the worst run again to the bit; empty if that cannot be.
        obstacle: Why it cannot, empty if it can.
        curve: Time [s] and distance of the tool from its plan [m] in the worst run; None without a trace.
    """

    controller: str
    world: str
    facts: Mapping[str, str]
    metric: str
    unit: str
    runs: tuple[ExplainedRun, ...]
    mean: float | None
    worst: ExplainedRun
    command: str
    obstacle: str
    curve: tuple[np.ndarray, np.ndarray] | None


def explain(folder: Path, selection: Selection, *, metric: str, world: str = "") -> Explanation:
    """Return what stands behind a cell of a results folder.

    Args:
        folder: The folder.
        selection: Which runs; they must belong to one controller.
        metric: Id of the metric that says which run is worst.
        world: Id of the world on the page, empty if only one has such runs.

    Raises:
        TorquebenchError: If the folder holds no store, a name is unknown, or several cells could be meant.
        UnknownMetric: If nobody registered the metric.
    """
    found = find_metric(metric, all_metrics())
    with Store.read(folder) as store:
        home, runs = one_world(worlds_of(store.runs(), store.campaigns()), world, selection)
        label = one_label(runs, selection)
        worst = max(runs, key=lambda run: _badness(run, found))
        curve = _curve(store, worst)
    shown = dict.fromkeys((*HEADLINES, metric))
    values = [value for run in runs if (value := _value(run, metric)) is not None]
    reason = obstacle(worst.stored)
    command = shlex.join(["torquebench", "replay", str(folder), worst.stored.address[:12], "--again"])
    return Explanation(
        controller=label,
        world=home.id,
        facts=home.facts,
        metric=metric,
        unit=found.unit,
        runs=tuple(_explained(run, list(shown)) for run in runs),
        mean=float(np.mean(values)) if values else None,
        worst=_explained(worst, list(shown)),
        command="" if reason else command,
        obstacle=reason,
        curve=curve,
    )


def _badness(run: Run, metric: Metric[...]) -> float:
    """Return a number that is larger for worse runs; one that was refused never ran and is no worst case."""
    if run.row.status == "refused":
        return -math.inf
    return read(run.row, metric, WINDOW).rank(metric)


def _value(run: Run, metric: str) -> float | None:
    value = run.row.metrics.get(WINDOW, {}).get(metric, {}).get("value")
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _explained(run: Run, metrics: Sequence[str]) -> ExplainedRun:
    stored = run.stored
    return ExplainedRun(
        address=stored.address,
        trajectory=run.row.trajectory,
        load=run.load,
        seed=stored.specification.campaign,
        repetition=run.row.repetition,
        status=run.row.status,
        reason=stored.result.reason,
        values={name: _value(run, name) for name in metrics},
    )


def _curve(store: Store, run: Run) -> tuple[np.ndarray, np.ndarray] | None:
    """Return time and position error of a run from its trace, None if none was kept or it cannot be read."""
    if not run.stored.trace:
        return None
    try:
        trace = store.trace(run.stored.trace)
    except InvalidInput:
        return None
    if not {"t", "p", "p_ref"} <= set(trace) or not len(trace["t"]):
        return None
    t, p, p_ref = (trace[name].astype(float) for name in ("t", "p", "p_ref"))
    return t, np.linalg.norm(p_ref - p, axis=1)
