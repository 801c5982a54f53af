"""Two materials under one controller: what a content changes at equal mass."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from .comparison import Comparison, compare
from .errors import NothingToCompare
from .intervals import Interval, t_interval
from .metrics import METRICS, Metric
from .pairing import Ratios
from .rows import RunRow, find_metric, read, runs_by_key


@dataclass(frozen=True, kw_only=True)
class MaterialContrast:
    """One metric of one controller with two materials, over the trajectories, masses and repetitions that both have.

    The empty container has no material and counts on both sides, as in the paper's means.

    Attributes:
        controller: Label of the controller.
        metric: Id of the metric.
        material: The one.
        baseline: The other.
        means: Mean over the cells of the material and of the baseline, in the metric's unit.
        difference: Mean over trajectories of material less baseline, in the metric's unit.
        interval: Its interval with the trajectory as unit; None for a single trajectory.
        ratio: Material over baseline.
    """

    controller: str
    metric: str
    material: str
    baseline: str
    means: tuple[float, float]
    difference: float
    interval: Interval | None
    ratio: Comparison


def contrast_materials(
    rows: Sequence[RunRow],
    controller: str,
    materials: tuple[str, str],
    metric_id: str,
    window: str = "run",
    metrics: Mapping[str, Metric[...]] = METRICS,
) -> MaterialContrast:
    """Compare a controller's runs with one material with those with another.

    Args:
        rows: Runs of one plant, tier and number of laps.
        controller: Label of the controller.
        materials: The material and the baseline.
        metric_id: Which metric.
        window: Which window.
        metrics: The metrics by id.

    Raises:
        UnknownMetric: If nobody registered the metric.
        AmbiguousRuns: If a side has two runs for one key.
        NothingToCompare: If the controller ran with one of them only, or no pair has a ratio.
    """
    metric, (material, baseline) = find_metric(metric_id, metrics), materials
    own = [row for row in rows if row.controller == controller]
    if not {material, baseline} <= {row.material for row in own}:
        raise NothingToCompare(material, baseline, f"{controller} ran with one of them at most")
    # The material takes the controller's place: the rest is the comparison of two controllers.
    sides = [
        replace(row, controller=name, material="") for name in materials for row in own if row.material in ("", name)
    ]
    ratio = compare(sides, material, baseline, metric_id, window, metrics)
    ours, theirs = runs_by_key(sides, material), runs_by_key(sides, baseline)
    pairs = Ratios.of(
        {k: (read(ours[k], metric, window), read(theirs[k], metric, window)) for k in ours if k in theirs}
    )
    by_path = pairs.differences_by_trajectory()
    return MaterialContrast(
        controller=controller,
        metric=metric_id,
        material=material,
        baseline=baseline,
        means=(float(np.mean(pairs.cell_means(0))), float(np.mean(pairs.cell_means(1)))),
        difference=float(np.mean(by_path)),
        interval=t_interval(by_path) if len(by_path) > 1 else None,
        ratio=ratio,
    )


def contrast_all(
    rows: Sequence[RunRow], metric_id: str, window: str = "run", metrics: Mapping[str, Metric[...]] = METRICS
) -> list[MaterialContrast]:
    """Return the contrasts of all controllers and pairs of materials that have one; the baseline comes first by name.

    Args:
        rows: Runs of one plant, tier and number of laps.
        metric_id: Which metric.
        window: Which window.
        metrics: The metrics by id.

    Raises:
        UnknownMetric: If nobody registered the metric.
        AmbiguousRuns: If a side has two runs for one key.
    """
    found = []
    for baseline, material in combinations(sorted({row.material for row in rows} - {""}), 2):
        for controller in dict.fromkeys(row.controller for row in rows):
            try:
                found.append(contrast_materials(rows, controller, (material, baseline), metric_id, window, metrics))
            except NothingToCompare:
                continue
    return found
