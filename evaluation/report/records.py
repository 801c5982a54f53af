"""Definitions of the metrics, and the gate that a campaign had to pass."""

import re
from collections.abc import Iterable, Mapping

from ..metrics import METRICS
from .findings import SUMMARISED
from .table import Cell, Column, Table


def definition_table(also: Iterable[str] = ()) -> Table:
    """Return the definition of every metric that the page uses, from the registry.

    Args:
        also: Ids of metrics that only some pages use.
    """
    columns = [
        Column(word, numeric=False)
        for word in ("Id", "Name", "Unit", "Better", "Counts as, if failed", "Source", "Definition")
    ]
    rows = []
    for name in (*SUMMARISED, *also):
        metric = METRICS[name]
        failed = "left out" if metric.fail_value is None else f"{metric.fail_value:.3g} {metric.unit}"
        first_line = re.sub(r":\w+:`([^`]*)`", r"\1", (metric.__doc__ or "").strip().partition("\n")[0])
        texts = (metric.label, metric.unit, metric.better, failed)
        rows.append(
            (
                Cell(name, kind="head"),
                *(Cell(text) for text in texts),
                Cell(metric.source, kind="wide"),
                Cell(first_line, kind="wide"),
            )
        )
    return Table(id="definitions-table", caption="Metrics on this page, in stored units", columns=columns, rows=rows)


def gate_table(number: int, gate: object) -> Table:
    """Return the checks that a plant had to pass before the campaign."""
    checks = [check for check in gate if isinstance(check, Mapping)] if isinstance(gate, list) else []
    rows = []
    for check in checks:
        passed = bool(check.get("passed"))
        figures = (_plain(check.get("deviation")), _plain(check.get("allowed")))
        mark = Cell("\N{CHECK MARK} passed" if passed else "\N{BALLOT X} failed", kind="good" if passed else "bad")
        rows.append((Cell(str(check.get("name", "")), kind="head"), Cell(str(check.get("plant", ""))), *figures, mark))
    columns = [
        Column("Check", numeric=False), Column("Plant", numeric=False), Column("Deviation"), Column("Allowed"),
        Column("Result", numeric=False),
    ]  # fmt: skip
    return Table(id=f"gate-{number}", caption="Physics gate before the campaign", columns=columns, rows=rows)


def _plain(value: object) -> Cell:
    if not isinstance(value, int | float):
        return Cell("not given", kind="missing")
    return Cell(f"{value:.2g}", float(value))
