"""How long a tick took, against the period it must fit into: facts of one machine, apart from all that repeats."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .cells import controller_column
from .figures import Figure, Line, Mark
from .findings import Findings
from .numbers import significant
from .scale import LogScale
from .table import Column, Reading, Table, columns_to_rows, head_cells, number_cells
from .traces import TICK

MEDIAN, P99, MOST, MISSES = "call_us_median", "call_us_p99", "call_us_max", "deadline_misses"
TENTH, FIFTIETH = "tick_time_every_10", "tick_time_every_50"
"""Metrics of calls in which levels with a longer period work too [s]."""
MICRO = "\N{MICRO SIGN}s"


@dataclass(frozen=True, kw_only=True)
class TimingPanel:
    """The wall time of a controller's call on the page.

    Attributes:
        figure: Median to 99th percentile and longest call of each controller, against the period.
        table: Its numbers.
        host: Sentence about the machine.
    """

    figure: Figure
    table: Table
    host: str


def timing_panel(findings: Findings, campaigns: Sequence[Mapping[str, object]]) -> TimingPanel | None:
    """Return what is known of the time of a tick; None if no run has any.

    Args:
        findings: The world's findings.
        campaigns: Records of the campaigns; they name the machines.
    """
    found = {label: _times(findings, label) for label in findings.order}
    timed = {label: times for label, times in found.items() if times[MEDIAN].size}
    if not timed:
        return None
    period = 1e6 * _period(findings)
    return TimingPanel(figure=_figure(findings, timed, period), table=_table(findings, timed), host=_host(campaigns))


def _times(findings: Findings, label: str) -> dict[str, np.ndarray]:
    timings = [run.stored.result.timing for run in findings.runs_of(label)]
    names = (MEDIAN, P99, MOST, MISSES, TENTH, FIFTIETH)
    return {name: np.array([t[name] for t in timings if name in t], float) for name in names}


def _period(findings: Findings) -> float:
    noted = (run.stored.result.provenance.get("tick_s") for run in findings.world.runs)
    return next((float(tick) for tick in noted if isinstance(tick, int | float)), TICK)


def _figure(findings: Findings, timed: Mapping[str, Mapping[str, np.ndarray]], period: float) -> Figure:
    scale = LogScale.around(
        (float(value) for times in timed.values() for name in (MEDIAN, P99, MOST) for value in times[name]),
        include=period,
    )
    lines = []
    for label, times in timed.items():
        median, p99, longest = (
            float(times[MEDIAN].min()), float(times[P99].max()), float(times[MOST].max()),
        )  # fmt: skip
        middle = float(np.median(times[MEDIAN]))
        late = longest > period
        marks = [
            Mark(scale.percent(middle), "circle", f"median: {significant(middle)} {MICRO}"),
            Mark(scale.percent(longest), "triangle" if late else "hollow", f"longest: {significant(longest)} {MICRO}"),
        ]
        text = f"{significant(middle)} {MICRO} (longest {significant(longest)} {MICRO})"
        span = (scale.percent(median), scale.percent(p99))
        lines.append(Line(label, text, f"#{findings.runs_anchor(label)}", marks, span))
    limit = f"{period:g} {MICRO}"
    return Figure(
        id=f"{findings.world.id}-ticks",
        title=f"Time of one call of the controller, against the period of {limit}",
        description=f"The upright line is the period of {limit}: a call beyond it is late. "
        + "; ".join(f"{line.label}: {line.text}" for line in lines),
        axis=f"wall time of a call [{MICRO}], logarithmic; bars from the least median to the largest 99th percentile",
        ticks=[(scale.percent(value), f"{value:.6g}") for value in scale.ticks()],
        one=scale.percent(period),
        lines=lines,
        legend=(("circle", "median"), ("hollow", "longest call"), ("triangle", "longest call, beyond the period")),
    )


def _table(findings: Findings, timed: Mapping[str, Mapping[str, np.ndarray]]) -> Table:
    # The metrics' seconds become milliseconds on the page; these are stored in microseconds and stay so.
    late = [float(times[MISSES].mean()) if times[MISSES].size else 0.0 for times in timed.values()]
    columns: list[tuple[str, str, Sequence[float | None]]] = [
        ("Median", MICRO, [_middle(times[MEDIAN]) for times in timed.values()]),
        ("Every 10th", MICRO, [_middle(1e6 * times[TENTH]) for times in timed.values()]),
        ("Every 50th", MICRO, [_middle(1e6 * times[FIFTIETH]) for times in timed.values()]),
        ("99th percentile", MICRO, [_middle(times[P99]) for times in timed.values()]),
        ("Longest", MICRO, [float(times[MOST].max()) for times in timed.values()]),
        ("Late calls a run", "", late),
    ]
    notes = {"Every 50th": "calls in which slow levels work too: 2 % of all, which a 95th percentile does not see"}
    heads = head_cells(timed, (f"#{findings.runs_anchor(label)}" for label in timed))
    return Table(
        id=f"{findings.world.id}-ticks-table",
        caption="Wall time of a call: medians over runs, the longest of all, and calls beyond the period",
        columns=[controller_column(), *(Column(text, unit, note=notes.get(text, "")) for text, unit, _ in columns)],
        rows=columns_to_rows([heads, *(number_cells(map(_reading, values), unit) for _, unit, values in columns)]),
        name=f"{findings.world.id}-call-times",
    )


def _middle(times: np.ndarray) -> float | None:
    return float(np.median(times)) if times.size else None


def _reading(value: float | None) -> Reading:
    return Reading(value, "ok" if value is not None else "missing")


def _host(campaigns: Sequence[Mapping[str, object]]) -> str:
    machines = [record.get("machine") for record in campaigns]
    names = dict.fromkeys(
        ", ".join(f"{name} {value}" for name, value in sorted(machine.items()))
        for machine in machines
        if isinstance(machine, Mapping)
    )
    known = "; and ".join(names) or "a machine that is not on record"
    mixed = " The rows do not say which machine ran them, so these times are mixed." if len(names) > 1 else ""
    return f"Measured on {known}, beside whatever else it did: another machine gives other times.{mixed}"
