"""The paper's claims on the page: a table for each group, and the contradictions within the paper."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from ...scenarios.store import Store
from ..claims import Claim, Inconsistency, Measured, Verdict, judge_all, read_book
from ..claims.rules import IN_PARTS, NOT_REPRODUCED, OPPOSITE, REPRODUCED, SMALLER, UNTESTABLE
from ..metrics import METRICS
from ..paper import reductions
from .claim_evidence import HELD_OUT, evidence_of
from .findings import Findings
from .numbers import fixed, ratio_text, significant, unit_on_page
from .panels import Panels
from .table import Cell, Column, Kind, Table

TITLES = {
    "precision": "Precision",
    "adaptation": "Adaptation",
    "resilience": "Resilience",
    "module": "Modules",
    "compute": "Computing",
    "energy": "Energy",
    "overview": "Overview",
}
MARKS: dict[str, tuple[str, Kind]] = {
    REPRODUCED: ("\N{CHECK MARK}", "good"),
    SMALLER: ("\N{WHITE DOWN-POINTING SMALL TRIANGLE}", "good"),
    NOT_REPRODUCED: ("\N{BALLOT X}", "bad"),
    OPPOSITE: ("\N{BLACK UP-POINTING TRIANGLE}", "bad"),
    UNTESTABLE: ("\N{EMPTY SET}", "missing"),
    IN_PARTS: ("\N{IDENTICAL TO}", ""),
}
SUBJECT = "cbmc_v3 / none"
"""Whom the claims are about: where it did not run, all of them would be open."""
OPEN: tuple[str, Kind] = ("\N{WHITE DIAMOND}", "open")
"""Symbol of what is not enough to decide."""


@dataclass(frozen=True, kw_only=True)
class ClaimsPanel:
    """What the runs of a store say about the paper.

    Attributes:
        verdicts: One for each claim.
        counts: How many claims have each word, in words.
        tables: Table of each group.
        reductions: The paper's percentages recomputed from its printed means.
        inconsistencies: Contradictions within the paper.
    """

    verdicts: Sequence[Verdict]
    counts: str
    tables: Sequence[Table]
    reductions: Table
    inconsistencies: Sequence[Inconsistency]

    @property
    def metrics(self) -> list[str]:
        """Ids of the metrics that claims were judged by, in the registry's order."""
        used = {name for verdict in self.verdicts if verdict.measured.n for name in verdict.claim.metrics}
        return [name for name in METRICS if name in used]


def claims_of(findings: Sequence[Findings], panels: Sequence[Panels], store: Store) -> ClaimsPanel | None:
    """Return the verdicts on all claims; None if CBMC-V3 ran in none of the sets that they are about.

    Args:
        findings: Findings of each world.
        panels: What the section of each world has besides.
        store: The open store that they come from.
    """
    book = read_book()
    evidence = evidence_of([found.world for found in findings], panels, store, book)
    # What patterns know of gravity stands in for no run: alone it would leave all other claims open.
    ran = [found for name, found in evidence.items() if name != HELD_OUT]
    if all(row.controller != SUBJECT for found in ran for row in found.rows):
        return None
    verdicts = judge_all(book, evidence)
    counted = Counter(verdict.word for verdict in verdicts)
    return ClaimsPanel(
        verdicts=verdicts,
        counts=", ".join(f"{count} {word}" for word, count in counted.most_common()),
        tables=[_table(group, [v for v in verdicts if v.claim.group == group]) for group in TITLES],
        reductions=_reductions(),
        inconsistencies=book.inconsistency,
    )


def claim_figures(panel: ClaimsPanel) -> list[dict[str, object]]:
    """Return every verdict for programs."""
    return [_figures(verdict) for verdict in panel.verdicts]


def _figures(verdict: Verdict) -> dict[str, object]:
    claim, measured = verdict.claim, verdict.measured
    limits = None if measured.interval is None else [measured.interval.low, measured.interval.high]
    return {
        "id": claim.id, "group": claim.group, "claim": claim.says, "place": claim.place, "printed": claim.printed,
        "printed_unit": claim.unit, "metrics": list(claim.metrics), "runs": claim.runs, "window": claim.window,
        "a": list(claim.a), "b": list(claim.b), "rule": claim.rule, "testable": claim.testable,
        "measured": measured.value, "unit": measured.unit, "interval": limits,
        "interval_method": "" if measured.interval is None else measured.interval.method,
        "n": measured.n, "of": measured.of, "test": measured.test, "notes": list(measured.notes),
        "verdict": verdict.statement, "reason": verdict.reason, "why": claim.why, "sentence": verdict.sentence,
        "see": list(claim.see), "parts": [_figures(part) for part in verdict.parts],
    }  # fmt: skip


def _table(group: str, verdicts: Sequence[Verdict]) -> Table:
    columns = [
        Column("No.", numeric=False),
        Column("Claim", numeric=False),
        Column(
            "Paper",
            note="a percentage is a reduction of the mean error; the ratio is that of the means"
            if group == "precision"
            else "",
        ),
        Column("Measured", note="below, its 95 % interval or its range" if group == "precision" else ""),
        Column("n"),
        Column("Verdict", numeric=False),
        Column("Why no higher, and what to know", numeric=False),
    ]
    rows = [_row(verdict) for verdict in verdicts]
    return Table(id=f"claims-{group}", caption=TITLES[group], columns=columns, rows=rows, name=f"claims-{group}")


def _row(verdict: Verdict) -> tuple[Cell, ...]:
    claim, measured = verdict.claim, verdict.measured
    symbol, kind = MARKS.get(verdict.word, OPEN)
    reason = verdict.reason if verdict.reason != claim.why else ""
    # What a proxy is stands in its verdict.
    why = "" if claim.testable == "proxy" else claim.why
    also = "; ".join(word for word in (measured.test, *measured.notes, why, *claim.see) if word)
    interval = "" if measured.interval is None else f"{_value(measured, measured.interval.low)} to "
    limits = f"{interval}{_value(measured, measured.interval.high)}" if measured.interval else ""
    return (
        Cell(claim.id, kind="head"),
        Cell(claim.says, note=claim.place, kind="wide"),
        _printed_cell(claim),
        # Units differ from row to row, so a number is nothing without its own, in a file too.
        Cell("none" if measured.value is None else _value(measured, measured.value), note=limits),
        Cell(str(measured.n) if measured.n else "", float(measured.n) or None, note=measured.of),
        Cell(f"{symbol} {verdict.statement}", kind="wide" if verdict.parts else kind),
        Cell(reason or ("the highest word" if verdict.word == REPRODUCED else ""), note=also, kind="wide"),
    )


def _printed_cell(claim: Claim) -> Cell:
    """Return the printed number, a reduction with the ratio that it is."""
    value, unit = claim.printed, claim.unit
    if value is None:
        return Cell("")
    note = f"ratio {ratio_text(1.0 - value / 100.0)}" if unit == "%" else ""
    return Cell(_printed(value, unit), note=note)


def _printed(value: float, unit: str) -> str:
    if unit in ("m", "rad"):
        return _with_unit(value, unit)
    return f"{value:g} {'' if unit == 'r' else unit}".strip().replace("-", "\N{MINUS SIGN}")


def _value(measured: Measured, value: float) -> str:
    """Return a measured value with its unit; an interval repeats no unit that the value shows."""
    if value in (float("inf"), float("-inf")):
        return "never"
    if measured.unit == "ratio":
        return ratio_text(value)
    if measured.unit in ("r", "per event"):
        return fixed(value, 2 if measured.unit == "r" else 3)
    if measured.unit in ("peaks", "kg"):
        return f"{value:g} {measured.unit}"
    return _with_unit(value, measured.unit)


def _with_unit(value: float, unit: str) -> str:
    base, _, per = unit.partition("/")
    if base in ("s", "1", "-"):
        return f"{significant(value)} {'s' if base == 's' else ''}{f'/{per}' if per else ''}".strip()
    shown = unit_on_page(base)
    return f"{significant(shown.of(value))} {shown.text}{f'/{per}' if per else ''}".strip()


def _reductions() -> Table:
    """Return the percentages of the paper beside what its printed means give."""
    columns = [
        Column("Place", numeric=False), Column("CBMC-V3"), Column("Factory"), Column("Printed", "%"),
        Column("From the means", "%"),
    ]  # fmt: skip
    rows = [
        (
            Cell(found.place, kind="head"),
            Cell(f"{found.ours:g} {found.unit}"),
            Cell(f"{found.theirs:g} {found.unit}"),
            Cell(f"{found.printed:.1f}", found.printed),
            Cell(f"{found.recomputed:.2f}", found.recomputed, kind="" if found.agrees else "bad"),
        )
        for found in reductions()
    ]
    caption = "The paper's percentages, recomputed from its printed means"
    return Table(id="claims-arithmetic", caption=caption, columns=columns, rows=rows, name="claims-arithmetic")
