"""Charts of curves as data: what is drawn, on which axes; how it is drawn is the business of :mod:`.drawing`."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .numbers import significant
from .scale import LogScale

STYLES = 6
"""Colours that can be told apart; beyond them a dash tells."""
MOST = 6
"""Most steps between the ticks of an axis."""
BUCKETS = 220
"""Pairs of a smallest and a largest sample that a long curve is drawn from: plain striding would lose its peaks."""


@dataclass(frozen=True)
class Axis:
    """An axis of a chart.

    Attributes:
        title: What it shows, with its unit.
        low: Value at its start.
        high: Value at its end, larger.
        log: Whether it is logarithmic.
    """

    title: str
    low: float
    high: float
    log: bool = False

    def place(self, value: float) -> float:
        """Return where a value lies, 0 at the start and 1 at the end; beyond it is beyond them."""
        if self.log:
            return math.log(max(value, 1e-300) / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def ticks(self) -> list[tuple[float, str]]:
        """Return value and text of each tick."""
        if self.log:
            return [(value, f"{value:.6g}") for value in LogScale(self.low, self.high).ticks()]
        size = 10.0 ** math.floor(math.log10(self.high - self.low))
        steps = (step * size for step in (0.1, 0.2, 0.25, 0.5, 1.0, 2.0))
        step = next(step for step in steps if (self.high - self.low) / step <= MOST)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [(index * step, f"{index * step:.6g}") for index in range(first, last + 1)]


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A line of a chart.

    Attributes:
        label: Whose it is.
        x: Shape (K,).
        y: Shape (K,); a gap where it is NaN.
        style: Its colour, from 0; beyond the last colour also its dash.
        band: Lower and upper edge of what is uncertain about it, shape (K,) each.
        dots: Whether its points are marked.
        plain: Whether it is a guide to the eye.
    """

    label: str
    x: np.ndarray
    y: np.ndarray
    style: int = 0
    band: tuple[np.ndarray, np.ndarray] | None = None
    dots: bool = False
    plain: bool = False


@dataclass(frozen=True, kw_only=True)
class Point:
    """A mark of a chart.

    Attributes:
        key: What stands beside it: a number that a table explains.
        title: Whose it is and where it lies, in words.
        x: Its place on the horizontal axis.
        y: Its place on the vertical axis.
        shape: ``circle`` filled, ``diamond`` hollow.
        style: Its colour, from 0.
    """

    key: str
    title: str
    x: float
    y: float
    shape: str
    style: int = 0


@dataclass(frozen=True, kw_only=True)
class Chart:
    """Curves and marks on two axes.

    Attributes:
        id: Fragment of its place on the page, and the name of its file.
        title: What it shows.
        description: The same for who cannot see it.
        x: Horizontal axis.
        y: Vertical axis.
        curves: What is drawn.
        points: Marks on top of them.
        events: Places on the horizontal axis with a mark, and what happens there.
        direct: Whether the curves carry their labels at their ends; if not, more than one get a legend.
        width: Width of the drawing; it grows with its place.
        height: Height of the drawing.
    """

    id: str
    title: str
    description: str
    x: Axis
    y: Axis
    curves: Sequence[Curve]
    points: Sequence[Point] = ()
    events: Sequence[tuple[float, str]] = ()
    direct: bool = False
    width: int = 460
    height: int = 220

    @property
    def legend(self) -> list[tuple[int, bool, str]]:
        """Return style and label of each curve, whether it is plain; empty if the curves carry their labels."""
        named = [(curve.style, curve.plain, curve.label) for curve in self.curves if curve.label]
        return [] if self.direct or len(named) < 2 else [(style, plain, label) for style, plain, label in named]


def thinned(x: np.ndarray, y: np.ndarray, buckets: int = BUCKETS) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and the largest sample of each of so many parts of a curve, in their order.

    Args:
        x: Shape (K,).
        y: Finite, shape (K,).
        buckets: How many parts.
    """
    if len(y) <= 2 * buckets:
        return x, y
    edges = np.linspace(0, len(y), buckets + 1).astype(int)
    kept = {0, len(y) - 1}
    for start, stop in pairwise(edges):
        kept |= {start + int(y[start:stop].argmin()), start + int(y[start:stop].argmax())}
    rows = np.array(sorted(kept))
    return x[rows], y[rows]


def around(title: str, values: Sequence[np.ndarray], *, zero: bool = False, log: bool = False) -> Axis:
    """Return an axis that shows all finite values with a little room.

    Args:
        title: Its title.
        values: What it has to show.
        zero: Whether it starts at zero.
        log: Whether it is logarithmic; values that are not positive are not shown then.
    """
    flat = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(0)
    shown = flat[np.isfinite(flat) & ((flat > 0.0) | (not log))]
    if log:
        scale = LogScale.around(shown.tolist())
        return Axis(title, scale.low, scale.high, log=True)
    low, high = (float(shown.min()), float(shown.max())) if len(shown) else (0.0, 1.0)
    low = 0.0 if zero else low
    room = 0.05 * (high - low) or 0.5 * (abs(high) or 1.0)
    return Axis(title, low if zero else low - room, high + room)


def at_ends(curves: Sequence[Curve], unit: str) -> str:
    """Return the last value of each curve in words, for a description."""
    return "; ".join(f"{c.label} ends at {significant(float(c.y[-1]))} {unit}" for c in curves if len(c.y) and c.label)
