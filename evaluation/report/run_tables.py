"""Tables of single runs: those behind the figures, those that failed, and twins."""

from collections.abc import Sequence

from ...scenarios.store import StoredRun
from ..metrics import METRICS
from .findings import ORIENTATION, POSITION, WINDOW, Findings
from .numbers import fixed, unit_on_page
from .run_files import row_data
from .table import Cell, Column, Table, columns_to_rows, number_cells, stored_reading, word_cell
from .worlds import Run


def run_table(findings: Findings, label: str) -> Table:
    """Return the runs of one controller."""
    runs = findings.runs_of(label)
    cells = [
        [Cell(run.row.trajectory, kind="head") for run in runs],
        [Cell(f"{run.row.mass:g}", run.row.mass) for run in runs],
        [Cell(run.row.material or "none") for run in runs],
        [Cell(str(run.row.repetition), run.row.repetition) for run in runs],
        [Cell(run.row.status, kind="" if run.row.status == "ok" else "bad") for run in runs],
        *(_run_cells(runs, metric) for metric in (POSITION, ORIENTATION)),
        [Cell(run.stored.address[:12], kind="") for run in runs],
    ]
    mm, mrad = (unit_on_page(METRICS[metric].unit).text for metric in (POSITION, ORIENTATION))
    columns = [
        Column("Trajectory", numeric=False), Column("Mass", "kg"), Column("Material", numeric=False),
        Column("Repetition"), Column("Status", numeric=False), Column("Position", mm), Column("Orientation", mrad),
        Column("Address", numeric=False),
    ]  # fmt: skip
    return Table(
        id=findings.runs_anchor(label),
        caption=f"Runs of {label}",
        columns=columns,
        rows=columns_to_rows(cells),
        row_ids=[run.anchor for run in runs],
        row_data=[row_data(findings.world, run) for run in runs],
    )


def failure_table(findings: Findings) -> Table:
    """Return what failed or was refused, when and why."""
    words = ("Controller / knowledge", "Trajectory", "Load", "Repetition", "Status", "When", "Cause", "Reason")
    rows = []
    for run in findings.failures:
        result = run.stored.result
        texts = (
            run.row.trajectory,
            run.load,
            str(run.row.repetition),
            result.status,
            _when(run.stored),
            result.cause,
        )
        head = Cell(run.row.controller, href=f"#{run.anchor}", kind="head")
        rows.append((head, *(Cell(text) for text in texts), Cell(result.reason, kind="wide")))
    return Table(
        id=f"{findings.world.id}-failed",
        caption="Runs that failed or were refused",
        columns=[Column(word, numeric=False) for word in words],
        rows=rows,
        name=f"{findings.world.id}-failed",
    )


def twin_table(findings: Findings) -> Table:
    """Return the twins: they judge events and enter no comparison."""
    words = ("Controller / knowledge", "Trajectory", "Twin", "Status", "Address")
    rows = []
    for twin in findings.world.twins:
        texts = (twin.row.trajectory, twin.stored.result.role, twin.row.status, twin.stored.address[:12])
        rows.append((Cell(twin.row.controller, kind="head"), *(Cell(text) for text in texts)))
    columns = [Column(word, numeric=False) for word in words]
    return Table(
        id=f"{findings.world.id}-twins",
        caption="Twins, in no comparison",
        columns=columns,
        rows=rows,
        row_ids=[twin.anchor for twin in findings.world.twins],
        row_data=[row_data(findings.world, twin) for twin in findings.world.twins],
    )


def _when(stored: StoredRun) -> str:
    """Return when a run failed; the first scored lap begins at zero, and who was refused never began."""
    result = stored.result
    if result.failed_at is None:
        # A process that was lost takes the time with it.
        return "before the start" if result.status == "refused" else "no tick on record"
    return f"{fixed(result.failed_at, 3)} s" + (", in the lead-in" if result.failed_at < 0.0 else "")


def _run_cells(runs: Sequence[Run], metric: str) -> list[Cell]:
    readings = [stored_reading(run.row.metrics, WINDOW, metric) for run in runs]
    cells = number_cells(readings, METRICS[metric].unit)
    return [
        cell if run.row.status == "ok" else word_cell(run.row.status) for run, cell in zip(runs, cells, strict=True)
    ]
