"""Figures as data: positions in per cent of the width, so that text keeps its size on every screen."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..comparison import Comparison
from ..metrics import METRICS
from .cells import failed_as
from .findings import Findings
from .numbers import ratio_text, significant, unit_on_page
from .scale import LogScale
from .sentences import SUBJECTS

ROW_HEIGHT = 44
"""Height of a figure's row: a line of text above a line of marks [px]."""
WIDEST = 8.0
"""Intervals are drawn at most this many times beyond the outermost ratios; with two trajectories they can be huge."""


@dataclass(frozen=True)
class Mark:
    """A mark of a figure.

    Attributes:
        x: Place [% of the width].
        shape: ``circle``, ``diamond``, ``triangle``, ``hollow`` or ``bar``.
        title: What it is, in words.
    """

    x: float
    shape: str
    title: str


@dataclass(frozen=True)
class Line:
    """A row of a figure.

    Attributes:
        label: Whose it is.
        text: Its numbers.
        href: Where it leads.
        marks: What is drawn.
        span: Ends of its interval [% of the width], None if there is none.
        open_ends: Whether the interval goes on beyond the left and the right end of the axis.
    """

    label: str
    text: str
    href: str
    marks: Sequence[Mark]
    span: tuple[float, float] | None = None
    open_ends: tuple[bool, bool] = (False, False)


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A figure of rows on one axis.

    Attributes:
        id: Fragment of its place on the page.
        title: What it shows.
        description: The same for who cannot see it.
        axis: Title of the axis.
        ticks: Place [% of the width] and text of each tick.
        one: Where the ratio 1 lies, None if the axis is no ratio.
        lines: Its rows.
        legend: Shape and meaning of the marks.
    """

    id: str
    title: str
    description: str
    axis: str
    ticks: Sequence[tuple[float, str]]
    one: float | None
    lines: Sequence[Line]
    legend: Sequence[tuple[str, str]]

    @property
    def height(self) -> int:
        """Height of the drawing [px]."""
        return ROW_HEIGHT * len(self.lines) + 30


def ratio_figure(findings: Findings, metric: str) -> Figure | None:
    """Return the ratio of each controller to the reference, with its interval; None without any ratio.

    Args:
        findings: The world's findings.
        metric: Id of a headline metric.
    """
    compared = findings.comparisons[metric]
    order = [label for label in findings.order if label in compared]
    if not order:
        return None
    world, subject = findings.world, SUBJECTS[metric]
    scale = _ratio_scale([compared[label] for label in order])
    lines = [_ratio_line(findings, compared[label], scale) for label in order]
    return Figure(
        id=f"{world.id}-ratio-{subject}",
        title=f"Mean {subject} error against {world.reference}",
        description=(
            f"Dots: geometric mean ratio to {world.reference}. Bars: 95 % interval over "
            f"{_trajectories([compared[label].n_trajectories for label in order])}. Left of 1 the error is lower. "
            + "; ".join(f"{line.label}: {line.text}" for line in lines)
        ),
        axis=f"ratio of mean {subject} errors, logarithmic",
        ticks=_ticks(scale),
        one=scale.percent(1.0),
        lines=lines,
        legend=(("circle", "lower"), ("triangle", "higher"), ("hollow", "not enough to decide")),
    )


def trajectory_figure(findings: Findings, metric: str) -> Figure | None:
    """Return the mean error of each controller on each trajectory; None if nothing has a mean."""
    summaries = findings.summaries[metric]
    order = [label for label in findings.order if summaries[label].by_trajectory]
    if not order:
        return None
    world, subject, shown = findings.world, SUBJECTS[metric], unit_on_page(METRICS[metric].unit)
    means = {label: {t: shown.of(v) for t, v in summaries[label].by_trajectory.items()} for label in order}
    scale = LogScale.around(value for found in means.values() for value in found.values())
    shapes = _group_shapes(findings)
    lines = []
    for label in order:
        marks = [
            Mark(scale.percent(value), shapes[trajectory][0], f"{trajectory}: {significant(value)} {shown.text}")
            for trajectory, value in means[label].items()
        ]
        mean = shown.of(summaries[label].mean or 0.0)
        marks.append(Mark(scale.percent(mean), "bar", f"mean: {significant(mean)} {shown.text}"))
        failed = summaries[label].failures
        text = f"mean {significant(mean)} {shown.text}" + (
            f" ({failed} failed, as {failed_as(metric)})" if failed else ""
        )
        lines.append(Line(label, text, f"#{findings.runs_anchor(label)}", marks))
    return Figure(
        id=f"{world.id}-dots-{subject}",
        title=f"Mean {subject} error on each trajectory",
        description=(
            f"One mark for each trajectory, mean over loads and repetitions; a bar for the mean of all. "
            f"{'; '.join(f'{line.label}: {line.text}' for line in lines)}. The table below holds every value."
        ),
        axis=f"mean {subject} error [{shown.text}], logarithmic",
        ticks=_ticks(scale),
        one=None,
        lines=lines,
        legend=(*dict.fromkeys(shapes.values()), ("bar", "mean of all")),
    )


def _trajectories(counts: Sequence[int]) -> str:
    """Say over how many trajectories the comparisons are, which need not be the same for all."""
    least, most = min(counts), max(counts)
    return f"{most} trajectories" if least == most else f"the {least} to {most} trajectories that both ran"


def _ratio_scale(comparisons: Sequence[Comparison]) -> LogScale:
    ratios = [comparison.gmr for comparison in comparisons]
    least, most = min(*ratios, 1.0) / WIDEST, max(*ratios, 1.0) * WIDEST
    intervals = [comparison.interval_new_motions for comparison in comparisons]
    ends = [end for interval in intervals if interval for end in (interval.low, interval.high)]
    return LogScale.around([*ratios, *(min(max(end, least), most) for end in ends)], include=1.0)


def _ratio_line(findings: Findings, comparison: Comparison, scale: LogScale) -> Line:
    verdict = findings.verdict_alone(comparison)
    ratio, interval = ratio_text(comparison.gmr), comparison.interval_new_motions
    shape = {"better": "circle", "worse": "triangle"}.get(verdict, "hollow")
    text, span, ends = f"{ratio} (no interval)", None, (False, False)
    if interval is not None:
        text = f"{ratio} ({ratio_text(interval.low)} to {ratio_text(interval.high)})"
        span = (scale.percent(interval.low), scale.percent(interval.high))
        ends = (not scale.holds(interval.low), not scale.holds(interval.high))
    mark = Mark(scale.percent(comparison.gmr), shape, f"{comparison.controller}: {text}, {verdict}")
    return Line(comparison.controller, text, f"#{findings.runs_anchor(comparison.controller)}", [mark], span, ends)


def _ticks(scale: LogScale) -> list[tuple[float, str]]:
    return [(scale.percent(value), f"{value:.6g}") for value in scale.ticks()]


def _group_shapes(findings: Findings) -> dict[str, tuple[str, str]]:
    """Return shape and name of each trajectory's group; a third group and all beyond share the last shape."""
    groups = {run.row.trajectory: run.row.group for run in findings.world.runs}
    names = sorted(set(groups.values()), reverse=True)
    shapes = {name: ("circle", "diamond", "triangle")[min(place, 2)] for place, name in enumerate(names)}
    return {trajectory: (shapes[group], group or "a trajectory") for trajectory, group in groups.items()}
