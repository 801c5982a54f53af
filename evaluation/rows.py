"""Rows of a run table, and how one metric is read from them: failures, refusals and gaps have one meaning here."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from .errors import AmbiguousRuns, UnknownMetric
from .metrics import METRICS, Metric

Cell = tuple[str, float, str]
"""Trajectory, mass, material."""

Key = tuple[str, float, str, int]
"""A cell and a repetition: what pairs the runs of two controllers."""


@dataclass(frozen=True, kw_only=True)
class RunRow:
    """One run of a campaign, as comparisons want it.

    Attributes:
        controller: Label with everything that makes a row of its own, for example ``computed_torque / oracle``.
        trajectory: Name of the trajectory.
        group: What kind of trajectory it is, for example ``slow`` or ``fast``.
        mass: Mass beyond the flange [kg].
        material: Content, for example ``sand``; empty without content.
        repetition: Number of the repetition; the same number means the same draws for every controller.
        status: ``ok``, ``failed`` (ranked worst), ``refused`` (never ran).
        metrics: Window to metric id to value, status and unit.
    """

    controller: str
    trajectory: str
    group: str
    mass: float
    material: str
    repetition: int
    status: Literal["ok", "failed", "refused"]
    metrics: Mapping[str, Mapping[str, Mapping[str, Any]]]

    @property
    def cell(self) -> Cell:
        """The cell of the grid that the run belongs to."""
        return (self.trajectory, self.mass, self.material)

    @property
    def key(self) -> Key:
        """The cell and the repetition."""
        return (*self.cell, self.repetition)


@dataclass(frozen=True)
class Reading:
    """One metric of one run, as a comparison counts it.

    Attributes:
        magnitude: Absolute value, the metric's ``fail_value`` for a failed run; None if nothing can stand for it,
            as for a recovery that never came, which is censored and ranked worst.
        status: The value's status; ``failed`` and ``refused`` for such runs; ``missing`` if nobody computed it.
    """

    magnitude: float | None
    status: Literal["ok", "censored", "failed", "undefined", "refused", "missing"]

    def rank(self, metric: Metric[...]) -> float:
        """Return a number that is lower for better runs, infinite for failed ones."""
        if self.status == "failed" or self.magnitude is None:
            return math.inf
        return -self.magnitude if metric.better == "higher" else self.magnitude


def find_metric(metric_id: str, metrics: Mapping[str, Metric[...]] = METRICS) -> Metric[...]:
    """Return a metric by its id.

    Args:
        metric_id: The id.
        metrics: The table to look in.

    Raises:
        UnknownMetric: If the table does not have it.
    """
    if metric_id not in metrics:
        raise UnknownMetric(metric_id, list(metrics))
    return metrics[metric_id]


def read(row: RunRow, metric: Metric[...], window: str) -> Reading:
    """Read one metric from a row.

    Args:
        row: The run.
        metric: Which metric; its ``fail_value`` stands for failed runs and for values with a sample not finite, its
            ``resolution`` for smaller magnitudes.
        window: Which window.

    Returns:
        The reading.
    """
    if row.status == "refused":
        return Reading(None, "refused")
    if row.status == "failed":
        return Reading(metric.fail_value, "failed")
    stored = row.metrics.get(window, {}).get(metric.id)
    if stored is None:
        return Reading(None, "missing")
    if stored["status"] == "failed":
        return Reading(metric.fail_value, "failed")
    if stored["status"] == "undefined" or stored["value"] is None or not math.isfinite(stored["value"]):
        return Reading(None, "censored" if stored["status"] == "censored" else "undefined")
    if metric.better == "higher" and stored["value"] < 0.0:
        # Of two negative scores the magnitude would call the worse one the better, and their ratio says nothing.
        return Reading(None, "undefined")
    return Reading(max(abs(float(stored["value"])), metric.resolution), stored["status"])


def runs_by_key(rows: Iterable[RunRow], controller: str) -> dict[Key, RunRow]:
    """Return the runs of one controller by cell and repetition.

    Args:
        rows: Runs of any controllers.
        controller: Whose runs.

    Returns:
        The runs in the order of their keys.

    Raises:
        AmbiguousRuns: If two runs claim the same key.
    """
    found: dict[Key, RunRow] = {}
    for row in rows:
        if row.controller == controller:
            if row.key in found:
                raise AmbiguousRuns(controller, row.key)
            found[row.key] = row
    return dict(sorted(found.items()))
