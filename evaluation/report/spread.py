"""One figure of several runs: its median and its range, with what could not be counted."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .numbers import fixed, unit_on_page
from .table import Cell, word_cell

NEVER = "never"
"""What stands for a recovery that did not come before the next event."""
SECONDS = 2
"""Decimals of a time of recovery."""


@dataclass
class Spread:
    """Values of one figure over runs or seeds.

    Attributes:
        values: Numbers, infinite for what never came about.
        others: How many runs have no number, by the word for it.
        reasons: Why, where it is known.
    """

    values: list[float] = field(default_factory=list)
    others: Counter[str] = field(default_factory=Counter)
    reasons: list[str] = field(default_factory=list)

    def add(self, value: object, status: str, reason: str = "") -> None:
        """Count one run."""
        number = float(value) if isinstance(value, int | float) else math.nan
        if status == "censored" and math.isinf(number):
            self.values.append(math.inf)
        elif status in ("ok", "censored") and math.isfinite(number):
            self.values.append(number)
        else:
            self.others[status if status not in ("ok", "censored") else "undefined"] += 1
            self.reasons += [reason] if reason and reason not in self.reasons else []

    @property
    def median(self) -> float:
        """The middle value; infinite if at least half of the values are, NaN without any."""
        if not self.values:
            return math.nan
        middle = sorted(self.values)[(len(self.values) - 1) // 2 : len(self.values) // 2 + 1]
        return math.inf if math.inf in middle else float(np.mean(middle))

    @property
    def missing(self) -> int:
        """How many runs have no number."""
        return sum(self.others.values())


def gathered(entries: Iterable[Any]) -> Spread:
    """Return the spread of stored values, each a mapping with ``value`` and ``status``, or None."""
    found = Spread()
    for entry in entries:
        if entry is None:
            found.add(None, "missing")
        else:
            found.add(entry.get("value"), str(entry.get("status", "ok")), str(entry.get("reason", "")))
    return found


def spread_cell(spread: Spread, unit: str, decimals: int) -> Cell:
    """Return a median with the range below it, words where there is no number.

    Args:
        spread: The values, in the stored unit.
        unit: That unit; seconds stay seconds.
        decimals: Digits after the point.
    """
    factor = 1.0 if unit == "s" else unit_on_page(unit).factor
    if not spread.values:
        cell = word_cell(next(iter(spread.others), "missing"))
        return Cell(cell.text, note=spread.reasons[0] if len(spread.reasons) == 1 else "", kind="missing")
    low, high = min(spread.values), max(spread.values)
    notes = []
    if len(spread.values) > 1 and not math.isinf(low):
        notes.append(f"[{_text(low, factor, decimals)}..{_text(high, factor, decimals)}]")
    never = sum(math.isinf(value) for value in spread.values)
    notes += [f"{never} of {len(spread.values)} {NEVER}"] if never else []
    notes += [f"{count} {word}" for word, count in sorted(spread.others.items())]
    median = spread.median
    # The middle of two counts may lie between them.
    halves = decimals == 0 and math.isfinite(median) and median % 1.0 != 0.0
    number = median * factor if math.isfinite(median) else None
    return Cell(
        _text(median, factor, 1 if halves else decimals),
        number,
        note=" ".join(notes),
        kind="bad" if math.isinf(median) else "",
    )


def _text(value: float, factor: float, decimals: int) -> str:
    return NEVER if math.isinf(value) else fixed(value * factor, decimals)
