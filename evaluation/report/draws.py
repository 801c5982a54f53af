"""What the repetitions of each motion drew, and whether all controllers met the same."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

from .findings import Findings
from .numbers import counting, significant, unit_on_page
from .table import Cell, Column, Table
from .worlds import Run

UNITS = {"payload_centre": "m", "initial_offset": "rad"}
"""Stored units of what is no factor and no angle of a phase."""


def drawn_by(run: Run) -> Mapping[str, object]:
    """Return what a run drew besides its sensor noise, empty for the nominal plant."""
    drawn = run.stored.result.provenance.get("draws")
    return drawn if isinstance(drawn, Mapping) else {}


def draw_table(findings: Findings) -> Table:
    """Return a row for each motion and repetition; two, if runs that should be paired drew differently."""
    counts = Counter(
        (run.row.trajectory, run.row.repetition, _values(drawn_by(run))) for run in findings.world.runs if drawn_by(run)
    )
    names = list(dict.fromkeys(name for _, _, values in counts for name, _ in values))
    rows = [
        (
            Cell(trajectory, kind="head"),
            Cell(str(repetition), repetition),
            Cell(str(count), count),
            *(Cell(dict(values).get(name, "")) for name in names),
        )
        for (trajectory, repetition, values), count in sorted(
            counts.items(), key=lambda item: (counting(item[0][0]), item[0])
        )
    ]
    columns = [Column("Trajectory", numeric=False), Column("Repetition"), Column("Runs")]
    columns += [
        Column(name.replace("_", " ").capitalize(), unit_on_page(UNITS.get(name, "")).text, numeric=False)
        for name in names
    ]
    return Table(
        id=f"{findings.world.id}-draws",
        caption="What each repetition drew, by joint or axis",
        columns=columns,
        rows=rows,
        name=f"{findings.world.id}-draws",
    )


def draw_sentence(findings: Findings) -> str:
    """Say whether the runs of a motion and repetition drew the same, empty if nothing was drawn."""
    found = {
        (run.row.trajectory, run.row.repetition, _values(drawn_by(run))) for run in findings.world.runs if drawn_by(run)
    }
    cells = {key[:2] for key in found}
    if not found:
        return ""
    if len(found) > len(cells):
        return (
            "Some runs of one motion and repetition drew differently: they are not paired, and no interval here holds."
        )
    return (
        "All controllers met the same draws: one for each motion and repetition, whatever the load and the knowledge."
    )


def _values(drawn: Mapping[str, object]) -> tuple[tuple[str, str], ...]:
    return tuple((name, _in_words(name, value)) for name, value in drawn.items())


def _in_words(name: str, value: object) -> str:
    """Return one number, or several with spaces between them."""
    shown = unit_on_page(UNITS.get(name, ""))
    numbers: list[Any] = value if isinstance(value, list) else [value]
    return " ".join(significant(shown.of(float(number)), 4) for number in numbers)
