"""A table as data: what a template draws, what a CSV link carries, and how cells without a number read."""

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal
from urllib.parse import quote

from .numbers import AT_LEAST, decimals_for, fixed, unit_on_page

Kind = Literal["", "head", "good", "bad", "open", "missing", "wide"]

WORDS = {
    "missing": "not computed",
    "undefined": "undefined",
    "failed": "failed",
    "refused": "refused",
}
"""What stands where there is no number."""

NO_NUMBER = "\N{EMPTY SET}"
"""Symbol before those words."""


@dataclass(frozen=True)
class Cell:
    """A cell.

    Attributes:
        text: What it shows.
        value: The number behind it in the page's unit, for sorting and CSV; None if there is none.
        href: Where it leads, empty for nowhere.
        note: A second, smaller line.
        kind: How it looks.
    """

    text: str
    value: float | None = None
    href: str = ""
    note: str = ""
    kind: Kind = ""


@dataclass(frozen=True)
class Column:
    """A column.

    Attributes:
        text: Its header.
        unit: Its unit on the page, empty for words.
        numeric: Whether its cells are aligned to the right.
        group: Header that it shares with its neighbours, empty for none.
        note: What a reader must know of it, listed below the table.
    """

    text: str
    unit: str = ""
    numeric: bool = True
    group: str = ""
    note: str = ""

    @property
    def title(self) -> str:
        """Its header where it stands alone: what it shares with its neighbours, its own words, its unit."""
        words = f"{self.group}: {self.text}" if self.group else self.text
        return f"{words} [{self.unit}]" if self.unit not in ("", "1") else words


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table.

    Attributes:
        id: Fragment of its place on the page.
        caption: What it shows.
        columns: Its columns.
        rows: Its cells, row by row.
        name: File name of its CSV without suffix; no link if empty.
        row_ids: Fragment of each row, empty for none.
        row_data: What scripts have to know of each row, by name; empty for nothing.
    """

    id: str
    caption: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    name: str = ""
    row_ids: Sequence[str] = ()
    row_data: Sequence[Mapping[str, str]] = ()

    @property
    def groups(self) -> list[tuple[str, int]]:
        """Return the shared headers with the number of columns below each; empty if no column has one."""
        spans: list[tuple[str, int]] = []
        for column in self.columns:
            if spans and spans[-1][0] == column.group:
                spans[-1] = (column.group, spans[-1][1] + 1)
            else:
                spans.append((column.group, 1))
        return spans if any(group for group, _ in spans) else []

    @property
    def notes(self) -> list[tuple[str, str]]:
        """Return what has to be said about columns."""
        return [
            (f"{column.group}, {_within(column.text)}" if column.group else column.text, column.note)
            for column in self.columns
            if column.note
        ]

    @property
    def csv(self) -> str:
        """Return the table as CSV, numbers with six digits, units in the header."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([column.title for column in self.columns])
        writer.writerows([[c.text if c.value is None else f"{c.value:.6g}" for c in row] for row in self.rows])
        return stream.getvalue()

    @property
    def data_link(self) -> str:
        """Return the CSV as a ``data:`` link."""
        return f"data:text/csv;charset=utf-8,{quote(self.csv)}"


@dataclass(frozen=True)
class Reading:
    """A value of a metric on its way to a cell.

    Attributes:
        value: The stored value, None if there is none.
        status: Its status.
        cell: What the cell has besides.
    """

    value: float | None
    status: str = "ok"
    cell: Cell = field(default_factory=lambda: Cell(""))


def stored_reading(metrics: Mapping[str, Mapping[str, Mapping[str, object]]], window: str, metric: str) -> Reading:
    """Return one metric of one run; a value that is not a number has a status in words."""
    entry = metrics.get(window, {}).get(metric)
    if entry is None:
        return Reading(None, "missing")
    value, status = entry.get("value"), str(entry.get("status", "ok"))
    if not isinstance(value, int | float) or not math.isfinite(value):
        return Reading(None, status if status in WORDS else "undefined")
    return Reading(float(value), status)


def number_cells(readings: Iterable[Reading], unit: str) -> list[Cell]:
    """Return the cells of a column: one number of decimals for all, words where there is no number."""
    listed, shown = list(readings), unit_on_page(unit)
    decimals = decimals_for(shown.of(reading.value) for reading in listed if reading.value is not None)
    return [
        _cell(reading, shown.of(reading.value) if reading.value is not None else None, decimals) for reading in listed
    ]


def word_cell(status: str) -> Cell:
    """Return a cell that says why there is no number."""
    return Cell(f"{NO_NUMBER} {WORDS.get(status, status)}", kind="missing")


def columns_to_rows(columns: Sequence[Sequence[Cell]]) -> list[tuple[Cell, ...]]:
    """Return rows of cells from columns of cells."""
    return list(zip(*columns, strict=True))


def head_cells(labels: Iterable[str], hrefs: Iterable[str] = ()) -> list[Cell]:
    """Return the row headers of a table, each a link if links are given."""
    listed = list(labels)
    links = list(hrefs) or [""] * len(listed)
    return [Cell(label, href=href, kind="head") for label, href in zip(listed, links, strict=True)]


def _within(text: str) -> str:
    """Return words as they stand within a sentence; an abbreviation keeps its capitals."""
    return text if text[:2].isupper() else f"{text[0].lower()}{text[1:]}"


def _cell(reading: Reading, number: float | None, decimals: int) -> Cell:
    if number is None:
        return replace(word_cell(reading.status), href=reading.cell.href, note=reading.cell.note)
    bound = f"{AT_LEAST} " if reading.status == "censored" else ""
    return replace(reading.cell, text=f"{bound}{fixed(number, decimals)}", value=number)
