"""What one content of the container changes against another of the same mass."""

from ..materials import MaterialContrast
from ..metrics import METRICS
from .cells import interval_cell
from .findings import HEADLINES, Findings
from .numbers import ratio_text, significant, unit_on_page
from .sentences import SUBJECTS
from .table import Cell, Column, Reading, Table, columns_to_rows, head_cells, number_cells

EMPTY_NOTE = "the empty container counts on both sides, as in the paper's means"
DIFFERENCE_NOTE = "{0} less {1}, mean over trajectories; below, its 95 % interval, the trajectory as unit"
RATIO_NOTE = "{0} over {1}, geometric mean over trajectories; below, its 95 % interval"


def material_tables(findings: Findings) -> list[Table]:
    """Return a table for each headline metric and pair of materials that ran."""
    pairs = dict.fromkeys((found.material, found.baseline) for found in findings.materials)
    return [_table(findings, metric, *pair) for pair in pairs for metric in HEADLINES]


def _table(findings: Findings, metric: str, material: str, baseline: str) -> Table:
    """Return the contrasts of one metric, a row for each controller."""
    wanted = (metric, material, baseline)
    found = [row for row in findings.materials if (row.metric, row.material, row.baseline) == wanted]
    unit, subject = METRICS[metric].unit, SUBJECTS[metric]
    shown = unit_on_page(unit).text
    columns = [
        head_cells((row.controller for row in found), (f"#{findings.runs_anchor(row.controller)}" for row in found)),
        number_cells([Reading(row.means[1]) for row in found], unit),
        number_cells([Reading(row.means[0]) for row in found], unit),
        [_difference(row, unit) for row in found],
        [_ratio(row) for row in found],
    ]
    return Table(
        id=f"{findings.world.id}-{material}-{baseline}-{subject}",
        caption=f"Mean {subject} error: {material} against {baseline} at the same masses, run window",
        columns=[
            Column("Controller / knowledge", numeric=False),
            Column(baseline.capitalize(), shown, note=EMPTY_NOTE),
            Column(material.capitalize(), shown),
            Column("Difference", shown, note=DIFFERENCE_NOTE.format(material, baseline)),
            Column("Ratio", note=RATIO_NOTE.format(material, baseline)),
        ],
        rows=columns_to_rows(columns),
        name=f"{findings.world.id}-{material}-against-{baseline}-{subject}",
    )


def _difference(row: MaterialContrast, unit: str) -> Cell:
    """Return a difference with its interval, two digits each: it may be far smaller than what it is a difference of."""
    shown = unit_on_page(unit)
    note = "one trajectory: no interval"
    if row.interval is not None:
        note = " to ".join(significant(shown.of(limit), 2) for limit in (row.interval.low, row.interval.high))
    return Cell(significant(shown.of(row.difference), 2), shown.of(row.difference), note=note)


def _ratio(row: MaterialContrast) -> Cell:
    return Cell(ratio_text(row.ratio.gmr), row.ratio.gmr, note=interval_cell(row.ratio.interval_new_motions).text)
