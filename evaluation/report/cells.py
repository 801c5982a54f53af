"""Cells that several tables share."""

from ..comparison import Comparison
from ..intervals import Interval
from ..metrics import METRICS
from ..summary import Summary
from .findings import Findings
from .numbers import ratio_text, significant, unit_on_page
from .table import Cell, Column, Kind, head_cells

VERDICTS: dict[str, tuple[str, Kind]] = {
    "better": ("\N{BLACK DOWN-POINTING TRIANGLE}", "good"),
    "worse": ("\N{BLACK UP-POINTING TRIANGLE}", "bad"),
}
UNDECIDED: tuple[str, Kind] = ("\N{WHITE DIAMOND}", "open")
"""Symbols of a verdict, so that it does not hang on colour."""


def controller_column() -> Column:
    """Return the column of row headers."""
    return Column("Controller / knowledge", numeric=False)


def controller_cells(findings: Findings) -> list[Cell]:
    """Return the row headers, each a link to the controller's runs."""
    return head_cells(findings.order, (f"#{findings.runs_anchor(label)}" for label in findings.order))


def verdict_cell(comparison: Comparison, verdict: str, href: str = "") -> Cell:
    """Return a ratio with its interval and the symbol of its verdict."""
    symbol, kind = VERDICTS.get(verdict, UNDECIDED)
    interval = comparison.interval_new_motions
    note = "one trajectory: no interval"
    if interval is not None:
        note = f"{ratio_text(interval.low)} to {ratio_text(interval.high)}"
    return Cell(f"{symbol} {ratio_text(comparison.gmr)}", comparison.gmr, href, note, kind)


def interval_cell(interval: Interval | None) -> Cell:
    """Return the limits of an interval."""
    if interval is None:
        return Cell("none", kind="missing")
    note = "degenerate" if interval.status == "degenerate" else ""
    return Cell(f"{ratio_text(interval.low)} to {ratio_text(interval.high)}", interval.low, note=note)


def failed_as(metric: str) -> str:
    """Return what a failed run counts as in means and ratios, empty if it is left out."""
    cost, shown = METRICS[metric].fail_value, unit_on_page(METRICS[metric].unit)
    return "" if cost is None else f"{significant(shown.of(cost))} {shown.text}"


def why_none(found: Summary) -> str:
    """Return why a controller may have no mean."""
    if found.runs == 0:
        return "refused"
    return "failed" if found.failures == found.runs else "undefined"
