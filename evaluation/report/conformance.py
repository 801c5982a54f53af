"""Whether the controllers of a store keep the contract that makes their runs comparable."""

from collections.abc import Callable, Iterable, Sequence

from ...controllers import Finding
from ...scenarios.store import StoredRun
from .table import Cell, Column, Table
from .worlds import Run, settings_in_words

ConformanceOf = Callable[[StoredRun], Sequence[Finding]]
"""Takes a run to the outcome of every check of its controller; empty if it is not there to be checked."""


def no_conformance(run: StoredRun) -> tuple[Finding, ...]:
    """Check nothing."""
    return ()


def conformance_table(runs: Iterable[Run], conformance_of: ConformanceOf) -> Table:
    """Return a row for each controller and its settings, a column for each law of the contract.

    Args:
        runs: All runs of a store.
        conformance_of: Checks a controller; asked with one run of each.
    """
    first: dict[tuple[str, str], Run] = {}
    for run in runs:
        specification = run.stored.specification
        first.setdefault((specification.controller, repr(sorted(specification.settings.items()))), run)
    # Several settings of one controller may have one name, in one world or in two: each has its row.
    checked = sorted(((_name(run), conformance_of(run.stored)) for run in first.values()), key=lambda pair: pair[0])
    laws = list(dict.fromkeys(finding.check for _, findings in checked for finding in findings))
    rows = [_row(name, findings, laws) for name, findings in checked]
    return Table(
        id="conformance-table",
        caption="The contract, checked when this page was written",
        columns=[Column("Controller", numeric=False), *(Column(law, numeric=False) for law in laws)],
        rows=rows if laws else [],
    )


def _name(run: Run) -> str:
    """Return a controller's label without the knowledge of the run, and with the settings that it ran with."""
    specification = run.stored.specification
    name = specification.label.rpartition(" / ")[0]
    return f"{name} ({settings_in_words(specification.settings)})" if specification.settings else name


def _row(name: str, findings: Sequence[Finding], laws: Sequence[str]) -> tuple[Cell, ...]:
    found = {finding.check: finding for finding in findings}
    return (Cell(name, kind="head"), *(_outcome(found.get(law)) for law in laws))


def _outcome(finding: Finding | None) -> Cell:
    if finding is None:
        return Cell("not checked", kind="missing")
    word = "\N{CHECK MARK} holds" if finding.passed else "\N{BALLOT X} broken"
    return Cell(word, note=finding.detail, kind="good" if finding.passed else "bad")
