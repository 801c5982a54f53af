"""Performance profiles: how large a share of a controller's runs stays within each multiple of the reference."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .errors import NothingToCompare
from .intervals import SMALLEST_BOOTSTRAP
from .metrics import METRICS, Metric
from .rows import Cell, RunRow, find_metric, read, runs_by_key

MULTIPLES = np.geomspace(1e-3, 10.0, 81)
"""Multiples of the reference's error at which a profile is read: the most precise laws are hundreds of times below."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Share of runs with an error of at most so many times the reference's mean error in their cell.

    Profiles in relation to the best of several controllers are not offered: the order below the first place depends
    on who else takes part (Gould and Scott, ACM TOMS 2016). Source: Agarwal et al., NeurIPS 2021, run-score
    distributions; Dolan and More, Mathematical Programming 2002.

    Attributes:
        controller: Whose runs.
        reference: Whose cell means are the unit.
        metric: Id of the metric.
        multiples: Multiples of the unit, shape (K,).
        share: Share of runs within each, shape (K,); a failed run is within none.
        band: Pointwise 95 % limits of the share over resampled trajectories, shape (2, K); None below five.
        runs: Runs that count.
        trajectories: Trajectories that they are on.
    """

    controller: str
    reference: str
    metric: str
    multiples: np.ndarray
    share: np.ndarray
    band: np.ndarray | None
    runs: int
    trajectories: int


def score_profile(
    rows: Sequence[RunRow],
    controller: str,
    reference: str,
    metric_id: str,
    window: str = "run",
    metrics: Mapping[str, Metric[...]] = METRICS,
) -> Profile:
    """Return the profile of a controller over the cells in which the reference has a value.

    Args:
        rows: Runs of one plant, tier and number of laps.
        controller: Label of the controller.
        reference: Label of the reference.
        metric_id: Which metric; lower is better.
        window: Which window.
        metrics: The metrics by id.

    Raises:
        UnknownMetric: If nobody registered the metric.
        AmbiguousRuns: If a side has two runs for one key.
        NothingToCompare: If no run of the controller lies in a cell with a value of the reference.
    """
    metric = find_metric(metric_id, metrics)
    units = _cell_means(runs_by_key(rows, reference).values(), metric, window)
    scores: dict[str, list[float]] = {}
    for row in runs_by_key(rows, controller).values():
        if row.status != "refused" and row.cell in units:
            scores.setdefault(row.trajectory, []).append(read(row, metric, window).rank(metric) / units[row.cell])
    if not scores:
        raise NothingToCompare(controller, reference, f"no common cell has a value of {metric_id} in window {window}")
    within = np.array([[np.mean(np.array(path) <= c) for c in MULTIPLES] for path in scores.values()])
    counts = np.array([len(path) for path in scores.values()], dtype=float)
    return Profile(
        controller=controller,
        reference=reference,
        metric=metric_id,
        multiples=MULTIPLES,
        share=counts @ within / counts.sum(),
        band=_band(within, counts) if len(counts) >= SMALLEST_BOOTSTRAP else None,
        runs=int(counts.sum()),
        trajectories=len(counts),
    )


def _cell_means(rows: Iterable[RunRow], metric: Metric[...], window: str) -> dict[Cell, float]:
    """Return the mean of each cell in which a run has a value other than zero."""
    cells: dict[Cell, list[float]] = {}
    for row in rows:
        found = read(row, metric, window)
        if found.status in ("ok", "censored") and found.magnitude is not None:
            cells.setdefault(row.cell, []).append(found.magnitude)
    return {cell: float(np.mean(values)) for cell, values in cells.items() if np.mean(values) > 0.0}


def _band(within: np.ndarray, counts: np.ndarray, n_resamples: int = 999, seed: int = 0) -> np.ndarray:
    """Return pointwise limits over resampled trajectories, shape (2, K)."""
    drawn = np.random.default_rng(seed).integers(0, len(counts), (n_resamples, len(counts)))
    weights = counts[drawn]
    shares = np.einsum("bt,btk->bk", weights, within[drawn]) / weights.sum(axis=1, keepdims=True)
    return np.asarray(np.quantile(shares, [0.025, 0.975], axis=0))
