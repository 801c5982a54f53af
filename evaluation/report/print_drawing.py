"""Charts and figures of rows on matplotlib axes, for print; the only place that knows how print looks."""

import io
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from matplotlib import rc_context, rcdefaults, rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Sheet
from matplotlib.lines import Line2D

from .charts import Axis, Chart
from .drawing import COLOURS
from .figures import Figure

COLUMN, PAGE = 3.5, 7.16
"""Widths of a column and of a page of two columns [in]."""
DASHES = ("-", "--", ":", "-.")
TITLE_LETTERS = 58
"""Letters of a title that fit above one of two charts."""
MARKERS = {"circle": "o", "diamond": "D", "triangle": "^", "hollow": "o", "bar": "|"}

LOOK: Any = {
    "font.size": 7.0,
    "font.family": "sans-serif",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 7.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
    "legend.fontsize": 6.0,
    "hatch.linewidth": 0.5,
    # A controller may have a dollar in its name.
    "text.parse_math": False,
    "text.usetex": False,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    # Identities within an SVG are random otherwise.
    "svg.hashsalt": "torquebench",
}
FORMATS = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""Suffixes, and what is left out of each so that the same store gives the same bytes."""


@contextmanager
def look() -> Iterator[None]:
    """Make and write sheets alike everywhere: a user's own settings of matplotlib count for nothing, and come back."""
    with rc_context():
        rcdefaults()
        rcParams.update(LOOK)
        yield


def written(sheet: Sheet, suffix: str) -> bytes:
    """Return the bytes of a sheet's file."""
    stream = io.BytesIO()
    sheet.savefig(stream, format=suffix, metadata=FORMATS[suffix])
    return stream.getvalue()


def draw_chart(axes: Axes, chart: Chart, *, title: str = "") -> None:
    """Draw the curves of a chart, with their bands and events.

    Args:
        axes: Where.
        chart: What.
        title: In place of the chart's own.
    """
    for curve in chart.curves:
        colour = "#565d66" if curve.plain else COLOURS[curve.style % len(COLOURS)]
        dash = "--" if curve.plain else DASHES[curve.style // len(COLOURS) % len(DASHES)]
        marker = "o" if curve.dots else ""
        axes.plot(curve.x, curve.y, color=colour, linestyle=dash, marker=marker, markersize=2.5, label=curve.label)
        if curve.band is not None:
            axes.fill_between(curve.x, *curve.band, color=colour, alpha=0.16, linewidth=0.0)
    for place, words in chart.events:
        axes.axvline(place, color="#565d66", linestyle=":", linewidth=0.7)
        axes.annotate(words, (place, 1.0), xycoords=("data", "axes fraction"), fontsize=6, va="top", ha="left")
    _scale(axes, chart.x, horizontal=True)
    _scale(axes, chart.y, horizontal=False)
    axes.set_title(textwrap.fill(title or chart.title, TITLE_LETTERS), loc="left")
    if sum(bool(curve.label) for curve in chart.curves) > 1:
        axes.legend()


def draw_rows(axes: Axes, figure: Figure) -> None:
    """Draw a figure of rows: marks and intervals on one axis, a line of words for each."""
    rows = range(len(figure.lines))
    for row, line in zip(rows, figure.lines, strict=True):
        if line.span is not None:
            axes.plot(line.span, (row, row), color="#1b1e22", linewidth=1.4, alpha=0.75)
        for end, x, marker in zip(line.open_ends, line.span or (0.0, 0.0), "<>", strict=True):
            if end:
                axes.plot([x], [row], color="#1b1e22", marker=marker, markersize=3)
        for mark in line.marks:
            axes.plot([mark.x], [row], **_marker(mark.shape))
    if figure.one is not None:
        axes.axvline(figure.one, color="#1b1e22", linewidth=0.7)
    axes.set_yticks(list(rows), [line.label for line in figure.lines])
    axes.set_ylim(len(figure.lines) - 0.5, -0.5)
    axes.set_xlim(0.0, 100.0)
    axes.set_xticks([place for place, _ in figure.ticks], [text for _, text in figure.ticks])
    axes.set_xlabel(figure.axis)
    axes.set_title(figure.title.replace(" against ", "\nagainst "), loc="left")


def marks_legend(sheet: Sheet, figure: Figure) -> None:
    """Say below a sheet what the marks of a figure of rows mean."""
    handles = [Line2D([], [], label=words, **_marker(shape)) for shape, words in figure.legend]
    sheet.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def shared_legend(sheet: Sheet, axes: Sequence[Axes]) -> None:
    """Replace the legends of axes that show the same curves by one below them all."""
    handles, labels = axes[0].get_legend_handles_labels()
    for drawn in axes:
        if (legend := drawn.get_legend()) is not None:
            legend.remove()
    sheet.legend(handles, labels, loc="outside lower center", ncols=min(4, len(labels)))


def _marker(shape: str) -> dict[str, Any]:
    hollow = shape == "hollow"
    colour = "#565d66" if hollow else COLOURS[1] if shape == "triangle" else COLOURS[0]
    look = {"color": colour, "markerfacecolor": "white" if hollow else colour, "linestyle": ""}
    return {**look, "marker": MARKERS[shape], "markersize": 8 if shape == "bar" else 4}


def _scale(axes: Axes, axis: Axis, *, horizontal: bool) -> None:
    """Put an axis's limits, ticks and title; its own ticks, since matplotlib's logarithmic ones are formulas."""
    side = "x" if horizontal else "y"
    places, texts = zip(*axis.ticks(), strict=True)
    axes.set(**{f"{side}scale": "log" if axis.log else "linear", f"{side}label": axis.title})
    axes.set(**{f"{side}lim": (axis.low, axis.high)})
    axes.minorticks_off()
    (axes.set_xticks if horizontal else axes.set_yticks)(places, texts)
