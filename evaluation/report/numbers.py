"""Numbers as people read them: units of the field, sensible digits, words where there is no number."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

MINUS, TIMES, AT_LEAST = "\N{MINUS SIGN}", "\N{MULTIPLICATION SIGN}", "\N{GREATER-THAN OR EQUAL TO}"
LONGEST = 3
"""Most decimals that a table shows; one less where its numbers have two digits before the point."""


@dataclass(frozen=True)
class Unit:
    """How a unit of the metrics is shown.

    Attributes:
        text: The unit on the page.
        factor: Multiplies the stored value.
    """

    text: str
    factor: float

    def of(self, value: float) -> float:
        """Return a stored value in the page's unit."""
        return value * self.factor


_SHOWN = {
    "m": Unit("mm", 1e3),
    "rad": Unit("mrad", 1e3),
    "s": Unit("ms", 1e3),
    "1": Unit("%", 1e2),
    "-": Unit("1", 1.0),
    "m/kg": Unit("mm/kg", 1e3),
    "rad/kg": Unit("mrad/kg", 1e3),
    "1/kg": Unit("%/kg", 1e2),
}
"""A share has the unit 1 where it is stored, a number that is no share of anything has "-"."""


def unit_on_page(unit: str) -> Unit:
    """Return how a unit is shown: metres as millimetres, shares as per cent, all others as they are; ``1`` for none."""
    return _SHOWN.get(unit, Unit(unit, 1.0))


def decimals_for(values: Iterable[float]) -> int:
    """Return the decimals of a column: two significant digits for its smallest value, three for its largest."""
    sizes = [abs(value) for value in values if math.isfinite(value) and value != 0.0]
    if not sizes:
        return 0
    smallest = 1 - math.floor(math.log10(min(sizes)))
    largest = 2 - math.floor(math.log10(max(sizes)))
    return min(max(smallest, largest, 0), LONGEST if max(sizes) < 10.0 else LONGEST - 1)


def fixed(value: float, decimals: int) -> str:
    """Return a number with so many decimals; a true minus sign, and none before zero."""
    text = f"{abs(value):.{decimals}f}"
    return f"{MINUS}{text}" if value < 0.0 and float(text) != 0.0 else text


def counting(name: str) -> tuple[tuple[str, int], ...]:
    """Return what sorts names as people count: M2 before M10."""
    return tuple((text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", name))


def capitalised(text: str) -> str:
    """Return a title with its first letter large and all others as they are: names in it keep theirs."""
    return f"{text[:1].upper()}{text[1:]}"


def significant(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits and never in exponential form above 1e-6."""
    if value == 0.0:
        return "0"
    size = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if size < -6:
        return f"{value:.1e}".replace("-", MINUS)
    return fixed(value, max(0, digits - 1 - size))


def ratio_text(value: float) -> str:
    """Return a ratio: two decimals around 1, a third where 1.00 would hide on which side it is."""
    if 0.1 <= value < 10.0:
        return fixed(value, 3 if value != 1.0 and abs(value - 1.0) < 0.005 else 2)
    return significant(value, 2)


def p_value(value: float) -> str:
    """Return a p value with three decimals, four below 0.01."""
    return "< 0.0001" if value < 1e-4 else f"{value:.4f}" if value < 0.01 else f"{value:.3f}"


def times_lower(ratio: float) -> str:
    """Return a ratio in words: ``39 times lower``, ``12 % lower``, ``40 % higher``."""
    word = "lower" if ratio < 1.0 else "higher"
    size = max(ratio, 1.0 / ratio) if ratio > 0.0 else math.inf
    if not math.isfinite(size):
        return f"incomparably {word}"
    if size >= 1.5:
        return f"{size:.2g} times {word}" if size < 99.5 else f"{size:.0f} times {word}"
    return f"{abs(1.0 - ratio) * 100:.2g} % {word}"
