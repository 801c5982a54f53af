"""How errors split by trajectory, mass and lap, and how much they depend on the path."""

from collections.abc import Callable, Mapping
from typing import Any

from ..metrics import METRICS
from ..summary import Summary
from .cells import controller_cells, controller_column, why_none
from .findings import HEADLINES, Findings
from .numbers import capitalised, counting, significant, unit_on_page
from .sentences import SUBJECTS
from .table import Cell, Column, Reading, Table, columns_to_rows, head_cells, number_cells


def trajectory_table(findings: Findings, metric: str) -> Table:
    """Return the mean of each controller on each trajectory."""
    names = sorted({run.row.trajectory for run in findings.world.runs}, key=counting)
    return _split_table(findings, metric, "trajectory", names, str, lambda s: s.by_trajectory)


def mass_table(findings: Findings, metric: str) -> Table:
    """Return the mean of each controller at each mass."""
    masses = sorted({row.mass for row in findings.world.rows})
    return _split_table(findings, metric, "mass", masses, lambda mass: f"{mass:g} kg", lambda s: s.by_mass)


def shape_table(findings: Findings) -> Table:
    """Return how much the error depends on the path: largest less smallest path mean, group by group."""
    groups = sorted({run.row.group for run in findings.world.runs}, reverse=True)
    columns, cells = [], []
    for metric in HEADLINES:
        for group in groups:
            unit = METRICS[metric].unit
            readings = [_range_reading(findings.summaries[metric][label], group) for label in findings.order]
            columns.append(Column(group or "all paths", unit_on_page(unit).text, group=SUBJECTS[metric].capitalize()))
            cells.append(number_cells(readings, unit))
    return Table(
        id=f"{findings.world.id}-shape",
        caption="Shape range: largest less smallest trajectory mean within a group of trajectories",
        columns=[controller_column(), *columns],
        rows=columns_to_rows([controller_cells(findings), *cells]),
        name=f"{findings.world.id}-shape-range",
    )


def lap_table(findings: Findings, metric: str) -> Table:
    """Return the mean of each lap: who wins depends on how long one learns."""
    laps = int(findings.world.facts["Laps"])
    found = findings.by_lap[metric]
    registered = METRICS.get(metric)
    unit, label = (registered.unit, registered.label) if registered else ("m", metric)
    flat = [Reading(found[name][lap]) for name in found for lap in range(laps)]
    cells = number_cells(flat, unit)
    rows = [
        (head, *cells[index * laps : (index + 1) * laps])
        for index, head in enumerate(head_cells(found, (f"#{findings.runs_anchor(name)}" for name in found)))
    ]
    return Table(
        id=f"{findings.world.id}-laps-{metric}",
        caption=f"{capitalised(label)} by lap, mean over the runs in the common cells that finished",
        columns=[controller_column(), *(Column(f"Lap {lap + 1}", unit_on_page(unit).text) for lap in range(laps))],
        rows=rows,
        name=f"{findings.world.id}-laps-{metric}",
    )


def _split_table(
    findings: Findings,
    metric: str,
    word: str,
    keys: list[Any],
    title: Callable[[Any], str],
    split: Callable[[Summary], Mapping[Any, float]],
) -> Table:
    """Return the means of one metric, one column for each value of what it is split by."""
    unit = METRICS[metric].unit
    summaries = findings.summaries[metric]
    readings = []
    for label in findings.order:
        means, status = split(summaries[label]), why_none(summaries[label])
        # The runs of a controller stand sorted: those of a trajectory begin at its first.
        first = {getattr(run.row, word): run.anchor for run in reversed(findings.runs_of(label))}
        table = findings.runs_anchor(label)
        readings += [
            Reading(means.get(key), status if not means else "missing", Cell("", href=f"#{first.get(key, table)}"))
            for key in keys
        ]
    cells = number_cells(readings, unit)
    return Table(
        id=f"{findings.world.id}-{word}-{SUBJECTS[metric]}",
        caption=f"Mean {SUBJECTS[metric]} error by {word}, run window",
        columns=[controller_column(), *(Column(title(key), unit_on_page(unit).text) for key in keys)],
        rows=[
            (head, *cells[index * len(keys) : (index + 1) * len(keys)])
            for index, head in enumerate(controller_cells(findings))
        ],
        name=f"{findings.world.id}-{SUBJECTS[metric]}-by-{word}",
    )


def _range_reading(found: Summary, group: str) -> Reading:
    """Return a shape range with the two paths it lies between, and its interval where there are repetitions."""
    shape = found.by_group.get(group)
    if shape is None:
        return Reading(None, why_none(found))
    if shape.largest == shape.smallest:
        return Reading(None, "one path")
    note = f"{shape.largest} less {shape.smallest}"
    if shape.interval is not None:
        shown = unit_on_page(found.unit)
        low, high = (significant(shown.of(limit), 2) for limit in (shape.interval.low, shape.interval.high))
        note += f", {low} to {high}"
    return Reading(shape.value, cell=Cell("", note=note))
