"""The paper's motions and new ones apart: what each controller reached on each set, and how sure that is there."""

from collections.abc import Mapping, Sequence

from ..comparison import Comparison
from ..metrics import METRICS
from ..motion_sets import FURTHER, PAPER, TITLES, rows_in
from ..rows import RunRow
from ..summary import Summary, summary
from .adaptation import Grid, grids_of
from .cells import controller_cells, controller_column, verdict_cell, why_none
from .findings import WINDOW, Findings
from .numbers import capitalised, ratio_text, unit_on_page
from .sentences import SUBJECTS
from .table import Cell, Column, Reading, Table, columns_to_rows, number_cells, word_cell

RATIO_NOTE = "geometric mean of the ratio to the reference, with the 95 % interval over the trajectories of the set"
GAP_NOTE = (
    "geometric mean over motions and shared loads (heldout_gap); the new motions have shapes and speeds of their own, "
    "so compare it between controllers"
)
FAMILY_NOTE = "corrected for all opponents of the reference on the set; below, how many trajectories decide"


def motion_set_table(findings: Findings, metric: str) -> Table:
    """Return mean, ratio and verdict of each controller on each set of motions.

    Args:
        findings: The world's findings; old and new motions ran.
        metric: Id of a headline metric.
    """
    columns, cells = [controller_column()], [controller_cells(findings)]
    unit, rows = METRICS[metric].unit, findings.world.rows
    for place, (name, families) in enumerate(findings.by_set.items()):
        found, comparisons = summary(rows_in(rows, name), metric, WINDOW), families[metric]
        title, first = capitalised(TITLES[name]), place == 0
        columns += [
            Column("Mean", unit_on_page(unit).text, group=title),
            Column("Ratio", group=title, note=RATIO_NOTE if first else ""),
            Column("In the family", numeric=False, group=title, note=FAMILY_NOTE if first else ""),
        ]
        cells += [
            number_cells([_mean(found, label) for label in findings.order], unit),
            [_ratio(findings, comparisons, label) for label in findings.order],
            [_family(comparisons.get(label)) for label in findings.order],
        ]
    columns.append(Column(f"{TITLES[FURTHER]} over {TITLES[PAPER]}", note=GAP_NOTE))
    cells.append(_gaps(rows, findings.order, metric))
    return Table(
        id=f"{findings.world.id}-motion-sets-{SUBJECTS[metric]}",
        caption=f"Mean {SUBJECTS[metric]} error by set of motions, run window",
        columns=columns,
        rows=columns_to_rows(cells),
        name=f"{findings.world.id}-{SUBJECTS[metric]}-by-motion-set",
    )


def _gaps(rows: Sequence[RunRow], labels: Sequence[str], metric: str) -> list[Cell]:
    """Return how much larger each controller's error is on the new motions, over the loads that those ran with."""
    new = rows_in(rows, FURTHER)
    loads = {(row.mass, row.material) for row in new}
    old = [row for row in rows_in(rows, PAPER) if (row.mass, row.material) in loads]
    trained, tried = grids_of(old, labels, metric), grids_of(new, labels, metric)
    return [_gap(tried[label], trained[label]) for label in labels]


def _gap(new: Grid | str, old: Grid | str) -> Cell:
    if isinstance(new, str) or isinstance(old, str):
        return word_cell(new if isinstance(new, str) else str(old))
    value = METRICS["heldout_gap"].value_of({"new": new.errors, "trained": old.errors}).value
    return Cell(ratio_text(value), value)


def _mean(found: Mapping[str, Summary], label: str) -> Reading:
    own = found.get(label)
    return Reading(None, "missing") if own is None else Reading(own.mean, why_none(own))


def _ratio(findings: Findings, comparisons: Mapping[str, Comparison], label: str) -> Cell:
    if label == findings.world.reference:
        return Cell("1", 1.0, note="the reference")
    comparison = comparisons.get(label)
    if comparison is None:
        return word_cell("no pair")
    return verdict_cell(comparison, findings.verdict_alone(comparison))


def _family(comparison: Comparison | None) -> Cell:
    if comparison is None:
        return Cell("")
    return Cell(comparison.verdict, note=f"{comparison.n_trajectories} trajectories")
