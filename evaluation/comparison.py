"""Paired comparison of a controller with a declared reference: one metric, two intervals, one word."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from .errors import NothingToCompare
from .intervals import SMALLEST_BOOTSTRAP, Interval, bca_interval, t_interval
from .metrics import METRICS, Metric
from .metrics.registry import Better
from .pairing import FLOOR, Ratios
from .rows import Cell, Key, Reading, RunRow, find_metric, read, runs_by_key
from .statistics import (
    geometric_mean_ratio,
    holm,
    paired_win_rate,
    prob_improvement,
    ratio_of_means,
    sign_flip_floor,
    sign_flip_test,
    wilcoxon_test,
)

Verdict = Literal["better", "worse", "not enough to decide"]

PRACTICALLY_EQUAL = (0.95, 1.05)
"""Ratios that nobody would change a controller for."""

MANY_FAILURES = 0.05
"""Share of failed runs on either side beyond which a ratio is no headline."""


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """What the paired runs of two controllers say about one metric; ratios are controller over reference.

    Attributes:
        controller: Label of the controller.
        reference: Label of the reference.
        metric: Id of the metric.
        window: Window of the metric.
        better: Which direction of the metric is better.
        gmr: Geometric mean ratio over trajectory means; below 1, the controller's values are smaller.
        interval_new_motions: Interval of the ratio with the trajectory as unit; None for a single trajectory.
        interval_suite: Interval of the ratio for these trajectories; None without repetitions.
        suite_bootstrap: Bootstrap interval beside the second; None without repetitions.
        bca: Bootstrap interval beside the first; None below five trajectories.
        ratio_of_means: The paper's percentage, for comparison with printed numbers only.
        prob_improvement: Probability that a run beats a run of the reference, averaged over cells.
        win_rate: Share of pairs won.
        p_sign_flip: Permutation test over trajectories.
        p_wilcoxon: Exact signed-rank test beside it.
        p_holm: The permutation test's p corrected for the family; None outside a family.
        family: Number of comparisons in the family.
        n_trajectories: Trajectories with a ratio.
        n_pairs: Pairs with a ratio.
        runs: Pairs that were run at all.
        failures: Failed runs among them, of the controller and of the reference.
        refused: Pairs in which either side was refused.
        without_ratio: Pairs that were run but have no ratio: value undefined or missing, or failed without a
            ``fail_value``.
        unpaired: Runs of either side that the other does not have.
        censored: Values in ratios that are bounds only.
        floored: Values in ratios that were raised to the floor.
    """

    controller: str
    reference: str
    metric: str
    window: str
    better: Better
    gmr: float
    interval_new_motions: Interval | None
    interval_suite: Interval | None
    suite_bootstrap: Interval | None
    bca: Interval | None
    ratio_of_means: float
    prob_improvement: float
    win_rate: float
    p_sign_flip: float
    p_wilcoxon: float
    p_holm: float | None = None
    family: int = 1
    n_trajectories: int
    n_pairs: int
    runs: int
    failures: tuple[int, int]
    refused: int
    without_ratio: tuple[Key, ...]
    unpaired: tuple[Key, ...]
    censored: int
    floored: int

    @property
    def verdict(self) -> Verdict:
        """The word of :func:`decide`."""
        return decide(self)

    @property
    def headline(self) -> Literal["gmr", "prob_improvement"]:
        """Which number may stand first: with many failures, a ratio depends on what a failure is said to cost."""
        return "prob_improvement" if max(self.failures) > MANY_FAILURES * self.runs else "gmr"

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader must know beside the word."""
        interval = self.interval_new_motions
        low, high = PRACTICALLY_EQUAL
        checks = {
            "practically equal": interval is not None and low <= interval.low and interval.high <= high,
            "depends on the average used": _averages_disagree(self),
            "too few trajectories": _too_few(self),
            "not after the correction for all opponents": not _too_few(self) and _taken_back(self),
            "failures in more than 5 % of the runs: see the probability of improvement": self.headline != "gmr",
            "no direction of this metric is better": self.better == "none",
            f"{self.censored} values are bounds only": self.censored > 0,
            f"{self.floored} values raised to the floor of {FLOOR:g}": self.floored > 0,
        }
        return tuple(remark for remark, holds in checks.items() if holds)


def decide(comparison: Comparison) -> Verdict:
    """Say what a comparison shows about new motions.

    Args:
        comparison: The comparison, as a member of its family.

    Returns:
        ``better`` or ``worse`` than the reference; ``not enough to decide`` if the interval over trajectories contains
        1, there are too few of them for any p value below 5 % in the family, Holm's correction takes the p value above
        it, the two averages disagree in sign, or the metric has no better direction.
    """
    interval = comparison.interval_new_motions
    undecided = interval is None or interval.contains(1.0) or _too_few(comparison) or _averages_disagree(comparison)
    if undecided or _taken_back(comparison) or comparison.better == "none":
        return "not enough to decide"
    return "better" if (comparison.gmr < 1.0) == (comparison.better == "lower") else "worse"


def compare(
    rows: Sequence[RunRow],
    controller: str,
    reference: str,
    metric_id: str,
    window: str = "run",
    metrics: Mapping[str, Metric[...]] = METRICS,
) -> Comparison:
    """Compare a controller with a reference over the runs that both have.

    Runs pair by trajectory, mass, material and repetition. A failed run counts as the metric's ``fail_value`` in
    ratios and as worst in ranks. Values enter with their magnitude, so that an early lag is not better than none.

    Args:
        rows: Runs of one plant, tier and number of laps.
        controller: Label of the controller.
        reference: Label of the reference.
        metric_id: Which metric.
        window: Which window.
        metrics: The metrics by id.

    Returns:
        The comparison.

    Raises:
        UnknownMetric: If nobody registered the metric.
        AmbiguousRuns: If a side has two runs for one key.
        NothingToCompare: If no pair has a ratio.
    """
    metric = find_metric(metric_id, metrics)
    ours, theirs = runs_by_key(rows, controller), runs_by_key(rows, reference)
    read_pairs = {k: (read(ours[k], metric, window), read(theirs[k], metric, window)) for k in ours if k in theirs}
    run = {k: pair for k, pair in read_pairs.items() if all(side.status != "refused" for side in pair)}
    ratios = Ratios.of(run)
    if not ratios.pairs:
        raise NothingToCompare(controller, reference, f"no pair of runs has a ratio of {metric_id} in window {window}")
    by_path, counted = ratios.by_trajectory(), [side for k in ratios.pairs for side in run[k]]
    return Comparison(
        controller=controller,
        reference=reference,
        metric=metric_id,
        window=window,
        better=metric.better,
        gmr=geometric_mean_ratio(by_path),
        interval_new_motions=t_interval(by_path).exponentiated() if len(by_path) > 1 else None,
        interval_suite=ratios.suite_interval(),
        suite_bootstrap=ratios.suite_bootstrap(),
        bca=bca_interval(by_path).exponentiated() if len(by_path) >= SMALLEST_BOOTSTRAP else None,
        ratio_of_means=ratio_of_means(ratios.cell_means(0), ratios.cell_means(1)),
        prob_improvement=_prob_improvement(run, metric),
        win_rate=paired_win_rate(*_ranks(list(run.values()), metric)),
        p_sign_flip=sign_flip_test(by_path),
        p_wilcoxon=wilcoxon_test(by_path),
        n_trajectories=len(by_path),
        n_pairs=len(ratios.pairs),
        runs=len(run),
        failures=(_failures(a for a, _ in run.values()), _failures(b for _, b in run.values())),
        refused=len(read_pairs) - len(run),
        without_ratio=tuple(k for k in run if k not in ratios.pairs),
        unpaired=tuple(sorted(ours.keys() ^ theirs.keys())),
        censored=sum(side.status == "censored" for side in counted),
        floored=sum(side.magnitude is not None and side.magnitude < FLOOR for side in counted),
    )


def compare_all(
    rows: Sequence[RunRow],
    reference: str,
    metric_id: str,
    window: str = "run",
    metrics: Mapping[str, Metric[...]] = METRICS,
) -> dict[str, Comparison]:
    """Compare every other controller with a reference: one family, corrected by Holm.

    Args:
        rows: Runs of one plant, tier and number of laps.
        reference: Label of the reference.
        metric_id: Which metric.
        window: Which window.
        metrics: The metrics by id.

    Returns:
        The comparisons by controller, in the order of the rows; controllers that share no usable pair are left out.

    Raises:
        UnknownMetric: If nobody registered the metric.
        AmbiguousRuns: If a controller has two runs for one key.
    """
    family: dict[str, Comparison] = {}
    for controller in dict.fromkeys(row.controller for row in rows if row.controller != reference):
        try:
            family[controller] = compare(rows, controller, reference, metric_id, window, metrics)
        except NothingToCompare:
            continue
    corrected = holm([comparison.p_sign_flip for comparison in family.values()])
    return {
        name: replace(comparison, p_holm=float(p), family=len(family))
        for (name, comparison), p in zip(family.items(), corrected, strict=True)
    }


def _failures(readings: Iterable[Reading]) -> int:
    return sum(reading.status == "failed" for reading in readings)


def _ranks(pairs: Sequence[tuple[Reading, Reading]], metric: Metric[...]) -> tuple[list[float], list[float]]:
    return [a.rank(metric) for a, _ in pairs], [b.rank(metric) for _, b in pairs]


def _prob_improvement(run: Mapping[Key, tuple[Reading, Reading]], metric: Metric[...]) -> float:
    """Return the probability of improvement, averaged over cells."""
    cells: dict[Cell, list[tuple[Reading, Reading]]] = {}
    for key, pair in run.items():
        cells.setdefault(key[:3], []).append(pair)
    return float(np.mean([prob_improvement(*_ranks(pairs, metric)) for pairs in cells.values()]))


def _too_few(comparison: Comparison) -> bool:
    interval = comparison.interval_new_motions
    return interval is None or sign_flip_floor(comparison.n_trajectories) * comparison.family > 1.0 - interval.level


def _taken_back(comparison: Comparison) -> bool:
    """Return whether the correction for all opponents takes the p value above the level."""
    interval = comparison.interval_new_motions
    return interval is not None and comparison.p_holm is not None and comparison.p_holm > 1.0 - interval.level


def _averages_disagree(comparison: Comparison) -> bool:
    return (comparison.gmr - 1.0) * (comparison.ratio_of_means - 1.0) < 0.0
