"""A logarithmic axis in per cent of a figure's width, so that figures fit any screen without scaling their text."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

STEPS = ((1.0, 2.0, 5.0), (1.0, 3.0), (1.0,))
"""Ticks within a decade, the densest first."""
MOST_TICKS = 6


@dataclass(frozen=True)
class LogScale:
    """A logarithmic axis.

    Attributes:
        low: Value at the left end, above 0.
        high: Value at the right end.
    """

    low: float
    high: float

    @classmethod
    def around(cls, values: Iterable[float], *, include: float | None = None) -> "LogScale":
        """Return an axis that shows all values with some room at the ends.

        Args:
            values: What it has to show; those that are not positive and finite are left out.
            include: A value that must be on the axis as well.
        """
        shown = [value for value in values if math.isfinite(value) and value > 0.0]
        shown += [] if include is None else [include]
        low, high = (min(shown), max(shown)) if shown else (1.0, 1.0)
        room = max((high / low) ** 0.06, 1.08)
        return cls(low / room, high * room)

    def percent(self, value: float) -> float:
        """Return where a value lies, from 0 to 100; values beyond an end lie on it."""
        if not value > 0.0:
            return 0.0
        share = math.log(value / self.low) / math.log(self.high / self.low)
        return round(100.0 * min(max(share, 0.0), 1.0), 2)

    def holds(self, value: float) -> bool:
        """Return whether a value is within the ends."""
        return self.low <= value <= self.high

    def ticks(self) -> list[float]:
        """Return round values for the ticks, at least two, at most about six."""
        for steps in STEPS:
            ticks = self._decades(steps)
            if len(ticks) <= MOST_TICKS:
                return ticks if len(ticks) >= 2 else self._linear()
        return ticks[:: math.ceil(len(ticks) / MOST_TICKS)]

    def _decades(self, steps: tuple[float, ...]) -> list[float]:
        first, last = math.floor(math.log10(self.low)), math.ceil(math.log10(self.high))
        candidates = (step * 10.0**decade for decade in range(first, last + 1) for step in steps)
        return [value for value in candidates if self.holds(value)]

    def _linear(self) -> list[float]:
        """Return ticks for less than a decade, where one, two and five are too far apart."""
        step = 10.0 ** math.floor(math.log10(self.high - self.low))
        if (self.high - self.low) / step < 2.0:
            step /= 5.0
        elif (self.high - self.low) / step > MOST_TICKS - 1:
            step *= 2.0
        first, last = math.ceil(self.low / step), math.floor(self.high / step)
        return [index * step for index in range(first, last + 1)]
