"""Everything the page says about one world, computed once."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..comparison import MANY_FAILURES, Comparison, compare, compare_all, decide
from ..errors import NothingToCompare
from ..materials import MaterialContrast, contrast_all
from ..metrics import METRICS
from ..motion_sets import rows_in, sets_in
from ..rows import RunRow, read
from ..summary import Summary, summary
from .worlds import Run, World

WINDOW = "run"
POSITION, ORIENTATION = "tcp_position_error_mean", "tcp_orientation_error_mean"
JOINTS, LAST_LAP = "joint_error_mean", "tcp_position_error_last_lap"
LAG, CONTOUR = "time_lag", "contour_error_mean"
CHATTER, CLIPPED, RATE_CLIPPED = "torque_rate_rms", "clip_fraction", "torque_rate_clip_fraction"

HEADLINES = (POSITION, ORIENTATION)
COMPARED = (POSITION, ORIENTATION, JOINTS, LAST_LAP)
SUMMARISED = (*COMPARED, LAG, CONTOUR, CHATTER, CLIPPED, RATE_CLIPPED)

SATURATED = 0.01
"""Share of ticks beyond a torque limit above which a run compares saturated systems."""


@dataclass(frozen=True)
class Lead:
    """Who comes first on a headline metric, and against whom.

    Attributes:
        metric: Id of the metric.
        ranked: Controllers that ran all common cells with few failures, smallest mean first.
        against_reference: The first against the declared reference, as a family of one; None if it is the reference
            itself or shares no run with it.
        in_family: The same comparison corrected for all opponents of the reference.
        against_next: The first against the second; None if there is no second.
    """

    metric: str
    ranked: tuple[str, ...]
    against_reference: Comparison | None
    in_family: Comparison | None
    against_next: Comparison | None


class Findings:
    """One world with its summaries and comparisons.

    Attributes:
        world: The world.
        summaries: Metric id to controller to summary.
        comparisons: Metric id to controller to its comparison with the reference.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        rows = world.rows
        self.summaries: dict[str, dict[str, Summary]] = {name: summary(rows, name, WINDOW) for name in SUMMARISED}
        self.comparisons: dict[str, dict[str, Comparison]] = {name: {} for name in COMPARED}
        if world.has_reference:
            self.comparisons = {name: compare_all(rows, world.reference, name, WINDOW) for name in COMPARED}

    @cached_property
    def common_rows(self) -> list[RunRow]:
        """Runs in the cells that more than half of the controllers ran, where they can be ranked; all without any."""
        rows = self.world.rows
        pairs = {(row.controller, row.cell) for row in rows}
        ran = Counter(cell for _, cell in pairs)
        common = [row for row in rows if 2 * ran[row.cell] > len(self.world.labels)]
        return common or rows

    @cached_property
    def common_summaries(self) -> dict[str, dict[str, Summary]]:
        """Headline metric to controller to its summary over :attr:`common_rows`: means that may be ranked."""
        return {metric: summary(self.common_rows, metric, WINDOW) for metric in HEADLINES}

    @cached_property
    def order(self) -> tuple[str, ...]:
        """Controllers as tables list them: those with a rank before others, then by mean position error."""
        ranked = self.ranked(POSITION)
        summaries = self.summaries[POSITION]

        def place(label: str) -> tuple[float, float, str]:
            mean = summaries[label].mean
            rank = ranked.index(label) if label in ranked else np.inf
            return (rank, np.inf if mean is None else mean, label)

        return tuple(sorted(self.world.labels, key=place))

    @cached_property
    def leads(self) -> tuple[Lead, ...]:
        """Who comes first on each headline metric."""
        return tuple(self._lead(metric) for metric in HEADLINES)

    @cached_property
    def by_set(self) -> dict[str, dict[str, dict[str, Comparison]]]:
        """Set of motions to headline metric to controller to comparison; empty unless old and new motions ran."""
        world = self.world
        return {
            name: {
                metric: compare_all(rows_in(world.rows, name), world.reference, metric, WINDOW) for metric in HEADLINES
            }
            for name in sets_in(world.rows)
        }

    @cached_property
    def materials(self) -> tuple[MaterialContrast, ...]:
        """What one content changes against another, for each headline metric, in the order of the tables."""
        found = [contrast for metric in HEADLINES for contrast in contrast_all(self.world.rows, metric, WINDOW)]
        return tuple(sorted(found, key=lambda contrast: self.order.index(contrast.controller)))

    @cached_property
    def failures(self) -> tuple[Run, ...]:
        """Runs that failed, then those that were refused."""
        ended = (run for run in self.world.runs if run.row.status != "ok")
        return tuple(sorted(ended, key=lambda run: (run.row.status, self.order.index(run.row.controller), run.row.key)))

    def ranked(self, metric: str) -> tuple[str, ...]:
        """Return controllers with few failures and a value in every common cell, smallest mean over these first."""
        return tuple(self.ranking[metric])

    @cached_property
    def ranking(self) -> dict[str, dict[str, float]]:
        """Headline metric to the mean over the common cells of every controller that has a rank, smallest first.

        A mean over the easy part of a grid is no better than one over all of it, and who ran more cells or repetitions
        than others is judged where they ran too.
        """
        return {metric: self._ranked_means(metric) for metric in HEADLINES}

    def _ranked_means(self, metric: str) -> dict[str, float]:
        rows, found = self.common_rows, self.common_summaries[metric]
        definition = METRICS[metric]
        valued = {(row.controller, row.cell) for row in rows if read(row, definition, WINDOW).magnitude is not None}
        cells = Counter(label for label, _ in valued)
        whole = max(cells.values(), default=0)
        able = {
            label: s.mean
            for label, s in found.items()
            if s.mean is not None and cells[label] == whole and s.failures <= MANY_FAILURES * s.runs
        }
        return dict(sorted(able.items(), key=lambda item: (item[1], item[0])))

    @staticmethod
    def verdict_alone(comparison: Comparison) -> str:
        """Return the word for a comparison on its own, as if it had been the only one asked for."""
        return decide(replace(comparison, family=1, p_holm=None))

    def runs_anchor(self, label: str) -> str:
        """Return the fragment of a controller's table of runs."""
        return f"{self.world.id}-runs-{self.order.index(label) + 1}"

    def runs_of(self, label: str) -> list[Run]:
        """Return the runs of one controller."""
        return self._runs_by_label.get(label, [])

    def saturated(self, label: str) -> int:
        """Return how many runs of a controller were beyond a torque limit for more than 1 % of their ticks."""
        shares = (run.row.metrics.get(WINDOW, {}).get(CLIPPED, {}).get("value") for run in self.runs_of(label))
        return sum(share is not None and share > SATURATED for share in shares)

    def timing(self, label: str, name: str) -> float | None:
        """Return the median over a controller's runs of one of their wall times."""
        timings = (run.stored.result.timing for run in self.runs_of(label))
        times = [float(timing[name]) for timing in timings if name in timing]
        return float(np.median(times)) if times else None

    @cached_property
    def by_lap(self) -> dict[str, dict[str, list[float]]]:
        """Metric to controller to the mean of each lap, over its runs in the common cells that finished."""
        return {metric: self._by_lap(metric) for metric in self.lap_metrics}

    def _by_lap(self, metric: str) -> dict[str, list[float]]:
        found, cells = {}, {row.cell for row in self.common_rows}
        for label in self.order:
            runs = [run for run in self.runs_of(label) if run.row.status == "ok" and run.row.cell in cells]
            laps = [run.stored.result.laps.get(metric, ()) for run in runs]
            whole = [list(lap) for lap in laps if len(lap) == int(self.world.facts["Laps"])]
            if whole:
                found[label] = [float(value) for value in np.mean(whole, axis=0)]
        return found

    @cached_property
    def lap_metrics(self) -> list[str]:
        """Metrics of which values by lap are stored, in the registry's order."""
        stored = dict.fromkeys(name for run in self.world.runs for name in run.stored.result.laps)
        known = [*METRICS, *stored]
        return sorted(stored, key=known.index)

    @cached_property
    def _runs_by_label(self) -> Mapping[str, list[Run]]:
        found: dict[str, list[Run]] = {}
        for run in self.world.runs:
            found.setdefault(run.row.controller, []).append(run)
        return found

    def _lead(self, metric: str) -> Lead:
        ranked = self.ranked(metric)
        first, second = (*ranked, "", "")[:2]
        in_family = self.comparisons[metric].get(first)
        alone = replace(in_family, family=1, p_holm=None) if in_family else None
        return Lead(metric, ranked, alone, in_family, self._pair(first, second, metric) if second else None)

    def _pair(self, first: str, second: str, metric: str) -> Comparison | None:
        try:
            return compare(self.world.rows, first, second, metric, WINDOW)
        except NothingToCompare:
            return None


def find_all(worlds: Sequence[World]) -> tuple[Findings, ...]:
    """Return the findings of all worlds."""
    return tuple(Findings(world) for world in worlds)
