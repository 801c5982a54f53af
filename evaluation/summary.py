"""What each controller reached on one metric: over the grid, by path, by mass, and how often it failed."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from .intervals import Interval, ShapeRange, clopper_pearson, shape_range
from .metrics import METRICS, Metric
from .rows import Cell, RunRow, find_metric, read, runs_by_key

Group = TypeVar("Group")


@dataclass(frozen=True, kw_only=True)
class Summary:
    """One controller on one metric. Means are over cells of the mean over repetitions, of magnitudes.

    Attributes:
        controller: Label of the controller.
        metric: Id of the metric.
        window: Window of the metric.
        unit: Unit of the means.
        mean: Mean over cells, a failed run counted as the metric's ``fail_value``; None if no run has a value.
        survivors_mean: The same without failed runs: biased, since the hard runs are those that fail.
        by_trajectory: Mean of each trajectory.
        by_mass: Mean of each mass [kg].
        by_group: Shape range of each group of trajectories, for example slow and fast.
        runs: Runs that were not refused.
        failures: Failed runs among them.
        failure_rate: Exact interval of the failure rate; None without a run.
        refused: Runs that were refused.
        without_value: Runs whose value is undefined or missing, or failed without a ``fail_value``.
    """

    controller: str
    metric: str
    window: str
    unit: str
    mean: float | None
    survivors_mean: float | None
    by_trajectory: Mapping[str, float]
    by_mass: Mapping[float, float]
    by_group: Mapping[str, ShapeRange]
    runs: int
    failures: int
    failure_rate: Interval | None
    refused: int
    without_value: int


def summary(
    rows: Sequence[RunRow],
    metric_id: str,
    window: str = "run",
    metrics: Mapping[str, Metric[...]] = METRICS,
) -> dict[str, Summary]:
    """Summarise one metric for every controller of a run table.

    Args:
        rows: Runs of one plant, tier and number of laps.
        metric_id: Which metric.
        window: Which window.
        metrics: The metrics by id.

    Returns:
        A summary by controller, in the order of the rows.

    Raises:
        UnknownMetric: If nobody registered the metric.
        AmbiguousRuns: If a controller has two runs for one key.
    """
    metric = find_metric(metric_id, metrics)
    controllers = dict.fromkeys(row.controller for row in rows)
    return {name: _summarise(name, list(runs_by_key(rows, name).values()), metric, window) for name in controllers}


def _summarise(controller: str, rows: Sequence[RunRow], metric: Metric[...], window: str) -> Summary:
    readings = [(row, read(row, metric, window)) for row in rows if row.status != "refused"]
    values = [(row, r.magnitude) for row, r in readings if r.magnitude is not None]
    cells = _cells(values)
    survivors = _cells((row, r.magnitude) for row, r in readings if r.magnitude is not None and r.status != "failed")
    failures = sum(r.status == "failed" for _, r in readings)
    groups = {row.trajectory: row.group for row, _ in values}
    return Summary(
        controller=controller,
        metric=metric.id,
        window=window,
        unit=metric.unit,
        mean=_mean(cells.values()),
        survivors_mean=_mean(survivors.values()),
        by_trajectory=_means_by(lambda cell: cell[0], cells),
        by_mass=_means_by(lambda cell: cell[1], cells),
        by_group=_shape_ranges(groups, cells),
        runs=len(readings),
        failures=failures,
        failure_rate=clopper_pearson(failures, len(readings)) if readings else None,
        refused=len(rows) - len(readings),
        without_value=len(readings) - len(values),
    )


def _cells(values: Iterable[tuple[RunRow, float]]) -> dict[Cell, list[float]]:
    """Return the repetitions of each cell."""
    cells: dict[Cell, list[float]] = {}
    for row, value in values:
        cells.setdefault(row.cell, []).append(value)
    return cells


def _mean(cells: Iterable[Sequence[float]]) -> float | None:
    means = [np.mean(cell) for cell in cells]
    return float(np.mean(means)) if means else None


def _means_by(label: Callable[[Cell], Group], cells: Mapping[Cell, Sequence[float]]) -> dict[Group, float]:
    """Return the mean over the cells that share a label."""
    groups: dict[Group, list[float]] = {}
    for cell, values in cells.items():
        groups.setdefault(label(cell), []).append(float(np.mean(values)))
    return {name: float(np.mean(means)) for name, means in groups.items()}


def _shape_ranges(groups: Mapping[str, str], cells: Mapping[Cell, Sequence[float]]) -> dict[str, ShapeRange]:
    """Return the shape range of each group of trajectories."""
    paths: dict[str, dict[str, list[Sequence[float]]]] = {}
    for cell, values in cells.items():
        paths.setdefault(groups[cell[0]], {}).setdefault(cell[0], []).append(values)
    return {group: shape_range(members) for group, members in sorted(paths.items())}
