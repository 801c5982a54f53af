"""Tables of adaptation: what each controller's error depends on, from whole grids only."""

from collections.abc import Sequence

from ..metrics import METRICS
from ..rows import RunRow
from .adaptation import ENDINGS, Grid, adaptation_values, compared_rows, grids_of
from .cells import controller_cells, controller_column
from .findings import HEADLINES, Findings
from .numbers import capitalised, unit_on_page
from .sentences import SUBJECTS
from .table import Column, Reading, Table, columns_to_rows, number_cells

BETTER = {"lower": "lower is better", "higher": "higher is better", "none": "descriptive"}


def adaptation_tables(findings: Findings) -> list[Table]:
    """Return a table for each headline metric; none where the runs are no grid.

    A controller without the whole grid has no numbers: a range over part of a grid is smaller than one over all of it.
    """
    rows = compared_rows(findings.world.rows)
    return [_table(findings, rows, metric) for metric in HEADLINES] if rows else []


def _table(findings: Findings, rows: Sequence[RunRow], base: str) -> Table:
    grids = grids_of(rows, findings.order, base)
    values = {label: {} if isinstance(grid, str) else adaptation_values(grid, base) for label, grid in grids.items()}
    names = list(dict.fromkeys(name for found in values.values() for name in found))
    columns, cells = [controller_column()], [controller_cells(findings)]
    for name in names:
        metric = METRICS[name]
        readings = [_reading(grids[label], values[label].get(name)) for label in findings.order]
        note = f"{name}, {BETTER[metric.better]}: {metric.source}"
        columns.append(Column(capitalised(metric.label), unit_on_page(metric.unit).text, note=note))
        cells.append(number_cells(readings, metric.unit))
    identity = f"{findings.world.id}-adaptation-{ENDINGS[base]}"
    return Table(
        id=identity,
        caption=f"How the mean {SUBJECTS[base]} error depends on motion, speed and load, over {_extent(rows)}",
        columns=columns,
        rows=columns_to_rows(cells) if names else [],
        name=identity,
    )


def _reading(grid: Grid | str, value: float | None) -> Reading:
    """Return a value, or why there is none: a whole grid lacks nothing but the range over repetitions."""
    if isinstance(grid, str):
        return Reading(None, grid)
    if value is None:
        return Reading(None, "unequal repetitions" if grid.repeats is None else "one repetition")
    return Reading(value)


def _extent(rows: Sequence[RunRow]) -> str:
    """Say which grid it is."""
    motions, contents = {row.trajectory for row in rows}, sorted({row.material for row in rows if row.material})
    loads = {(row.mass, row.material) for row in rows}
    return f"{len(motions)} motions and {len(loads)} loads" + (f" of {contents[0]}" if contents else "")
