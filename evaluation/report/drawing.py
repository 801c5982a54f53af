"""A chart as SVG: inside the page, where the style sheet gives the colours, or as a file of its own."""

import math
import textwrap
from collections.abc import Iterable
from html import escape

import numpy as np

from .charts import STYLES, Chart, Curve

LEFT, RIGHT, TOP, BOTTOM = 46, 16, 16, 38
LETTER = 6.4
"""Room for a letter of a label at the end of a curve."""
TITLE_LETTER, TITLE_LINE = 8.2, 18
"""Room for a letter of a title, and from line to line."""
APART = 13
"""Least distance between two such labels."""
KEY_WIDTH, KEY_HEIGHT = 14, 11
"""Room of a key beside a mark."""
COLOURS = ("#0072b2", "#d55e00", "#00805c", "#a3497c", "#806000", "#4d5661")
"""Colours of a file of its own, light; the page's style sheet has the same, and lighter ones for a dark page."""
DASHES = ("", "6 3", "2 3")

STYLE = (
    "text{font:12px system-ui,-apple-system,'Segoe UI',Roboto,Arial,sans-serif;fill:#565d66}"
    "text.title{font-size:14px;font-weight:600;fill:#1b1e22}text.end{fill:#1b1e22}"
    ".grid{stroke:#d9dcdd}.event{stroke:#565d66;stroke-dasharray:3 3}.curve{fill:none;stroke-width:1.6}"
    ".plain{stroke:#565d66;stroke-dasharray:4 4}.band{stroke:none;opacity:.16}"
    + "".join(f".s{i}{{stroke:{c}}}.f{i}{{fill:{c};color:{c}}}" for i, c in enumerate(COLOURS))
)
ROWS = (
    ".label{fill:#1b1e22;font-size:13.5px}.track{stroke:#d9dcdd}.one{stroke:#1b1e22;stroke-width:1.5}"
    ".span{stroke:#1b1e22;stroke-width:2.5;opacity:.75}.end{fill:#1b1e22;opacity:.75}"
    ".fill-1{fill:#0072b2;stroke:#fff}.fill-2{fill:#d55e00;stroke:#fff}"
    ".hollow{fill:#fff;stroke:#565d66;stroke-width:2}.bar{stroke:#1b1e22;stroke-width:2;fill:none}"
)
"""What a figure of rows needs besides."""


def draw(chart: Chart) -> str:
    """Return a chart as an ``svg`` element for the page."""
    head = (
        f'<svg class="lines" role="img" aria-labelledby="{chart.id}-t {chart.id}-d" '
        f'viewBox="0 0 {chart.width} {chart.height}">'
        f'<title id="{chart.id}-t">{escape(chart.title)}</title>'
        f'<desc id="{chart.id}-d">{escape(chart.description)}</desc>'
    )
    return f"{head}{''.join(_content(chart))}</svg>"


def draw_file(chart: Chart) -> str:
    """Return a chart as the text of an SVG file, with its title, legend and colours."""
    legend, title = chart.legend, textwrap.wrap(chart.title, int((chart.width - 16) / TITLE_LETTER))
    head = 20 + TITLE_LINE * (len(title) - 1)
    longest = max((len(label) for _, _, label in legend), default=0)
    columns = 2 if 8 + 28 + LETTER * longest < chart.width // 2 else 1
    top = head + 10 + 18 * math.ceil(len(legend) / columns)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * chart.width}" height="{2 * (chart.height + top)}" '
        f'viewBox="0 0 {chart.width} {chart.height + top}">',
        f"<title>{escape(chart.title)}</title><desc>{escape(chart.description)}</desc><style>{STYLE}</style>",
        f'<rect width="{chart.width}" height="{chart.height + top}" fill="#fff"/>',
        *(
            f'<text class="title" x="8" y="{20 + TITLE_LINE * row}">{escape(line)}</text>'
            for row, line in enumerate(title)
        ),
    ]
    for place, (style, plain, label) in enumerate(legend):
        x, y = 8 + (place % columns) * chart.width // 2, head + 20 + 18 * (place // columns)
        lines.append(f'<path d="M{x} {y - 4}h22" {_stroke(style, plain=plain)}/><text x="{x + 28}" y="{y}">')
        lines.append(f"{escape(label)}</text>")
    lines.append(f'<g transform="translate(0 {top})">{"".join(_content(chart))}</g></svg>')
    return "\n".join(lines) + "\n"


def wrap_file(content: str, title: str, axis: str, height: int) -> str:
    """Return a figure of rows as the text of an SVG file.

    Args:
        content: Its drawing as the page has it.
        title: What it shows.
        axis: Title of its axis.
        height: Height of the drawing.
    """
    width, inner = 760, content.strip().replace('href="#', 'href="../index.html#')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height + 70}">\n'
        f'<style>{STYLE}{ROWS}</style><rect width="100%" height="100%" fill="#fff"/>\n'
        f'<text class="title" x="20" y="24">{escape(title)}</text>\n'
        f'<svg x="20" y="36" width="{width - 40}" height="{height}" overflow="visible">{inner}</svg>\n'
        f'<text x="20" y="{height + 56}">{escape(axis)}</text>\n</svg>\n'
    )


def swatch(style: int, *, plain: bool) -> str:
    """Return the sample of a line for a legend."""
    return f'<svg width="24" height="10" aria-hidden="true"><path d="M0 5h24" {_stroke(style, plain=plain)}/></svg>'


def _content(chart: Chart) -> Iterable[str]:
    right = chart.width - _room(chart)
    bottom = chart.height - BOTTOM
    for value, text in chart.y.ticks():
        y = _y(chart, value)
        yield f'<path class="grid" d="M{LEFT} {y}H{right}"/>'
        yield f'<text class="tick" x="{LEFT - 5}" y="{y + 4:g}" text-anchor="end">{escape(text)}</text>'
    for value, text in chart.x.ticks():
        x = _x(chart, value)
        yield f'<path class="grid" d="M{x} {bottom}v4"/>'
        yield f'<text class="tick" x="{x}" y="{bottom + 16}" text-anchor="middle">{escape(text)}</text>'
    for value, text in chart.events:
        x = _x(chart, value)
        yield f'<path class="event" d="M{x} {TOP - 4}V{bottom}"/>'
        yield f'<text class="tick" x="{x + 3:g}" y="{TOP + 5}">{escape(text)}</text>'
    middle = (LEFT + right) // 2
    yield f'<text class="tick" x="{middle}" y="{bottom + 32}" text-anchor="middle">{escape(chart.x.title)}</text>'
    yield f'<text class="tick" x="2" y="{TOP - 5}">{escape(chart.y.title)}</text>'
    for curve in chart.curves:
        yield from _curve(chart, curve)
    yield from _points(chart)
    if chart.direct:
        yield from _labels(chart, right)


def _curve(chart: Chart, curve: Curve) -> Iterable[str]:
    if curve.band is not None:
        low, high = curve.band
        edge = [*zip(curve.x, high, strict=True), *zip(curve.x[::-1], low[::-1], strict=True)]
        path = "L".join(f"{_x(chart, x)} {_y(chart, y)}" for x, y in edge if np.isfinite(y))
        yield f'<path class="band f{curve.style % STYLES}" d="M{path}Z"/>' if path else ""
    kept = np.isfinite(curve.y)
    points = [(_x(chart, x), _y(chart, y)) for x, y in zip(curve.x[kept], curve.y[kept], strict=True)]
    title = f"<title>{escape(curve.label)}</title>" if curve.label else ""
    path = "L".join(f"{x} {y}" for x, y in points)
    yield f'<path d="M{path}" {_stroke(curve.style, plain=curve.plain)}>{title}</path>' if points else ""
    if curve.dots:
        yield from (f'<circle class="f{curve.style % STYLES}" cx="{x}" cy="{y}" r="3"/>' for x, y in points)


def _points(chart: Chart) -> Iterable[str]:
    """Draw the marks, filled or hollow, so that they do not hang on colour; a key stands where it covers no other."""
    places = [(_x(chart, point.x), _y(chart, point.y)) for point in chart.points]
    taken: list[tuple[float, float]] = []
    for point, (x, y) in zip(chart.points, places, strict=True):
        style = point.style % STYLES
        mark = f'<circle class="f{style}" cx="{x}" cy="{y}" r="4.5"/>'
        if point.shape == "diamond":
            mark = f'<path class="curve s{style}" d="M{x} {y - 5:g}l5 5-5 5-5-5Z"/>'
        beside = [(x + dx, y + dy) for dx in (7, -7 - KEY_WIDTH) for dy in (4, -6, 14)]
        others = [(u - KEY_WIDTH / 2, v + 4) for u, v in places if (u, v) != (x, y)]
        # A mark without room for its key is told by its title and by the table.
        free = [place for place in beside if not any(_overlap(place, other) for other in (*taken, *others))]
        key = ""
        if free:
            taken.append(free[0])
            key = f'<text class="end" x="{free[0][0]:g}" y="{free[0][1]:g}">{escape(point.key)}</text>'
        yield f"<g><title>{escape(point.title)}</title>{mark}{key}</g>"


def _overlap(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return abs(one[0] - other[0]) < KEY_WIDTH and abs(one[1] - other[1]) < KEY_HEIGHT


def _labels(chart: Chart, right: int) -> Iterable[str]:
    """Place the labels at the ends of the curves, apart from each other."""
    ends = sorted((_y(chart, c.y[-1]), c.style % STYLES, c.label) for c in chart.curves if len(c.y) and c.label)
    places: list[float] = []
    for y, _, _ in ends:
        places.append(max(y, places[-1] + APART) if places else y)
    # What ran out at the bottom moves up again, the last first.
    limit = float(chart.height - BOTTOM + 10)
    for index in range(len(places) - 1, -1, -1):
        places[index] = min(places[index], limit)
        limit = places[index] - APART
    for place, (y, style, label) in zip(places, ends, strict=True):
        yield f'<path class="curve s{style}" d="M{right} {y}L{right + 8} {place:g}"/>'
        yield f'<text class="end" x="{right + 11}" y="{place + 4:g}">{escape(label)}</text>'


def _stroke(style: int, *, plain: bool) -> str:
    dash = DASHES[min(style // STYLES, len(DASHES) - 1)]
    dashed = f' stroke-dasharray="{dash}"' if dash and not plain else ""
    return f'class="curve {"plain" if plain else f"s{style % STYLES}"}"{dashed}'


def _room(chart: Chart) -> int:
    """Return how much is left free at the right."""
    longest = max((len(curve.label) for curve in chart.curves), default=0)
    return min(round(LETTER * longest) + 14, chart.width // 2) if chart.direct else RIGHT


def _x(chart: Chart, value: float) -> float:
    width = chart.width - LEFT - _room(chart)
    return float(f"{LEFT + width * min(max(chart.x.place(float(value)), 0.0), 1.0):.1f}")


def _y(chart: Chart, value: float) -> float:
    height = chart.height - TOP - BOTTOM
    return float(f"{chart.height - BOTTOM - height * min(max(chart.y.place(float(value)), 0.0), 1.02):.1f}")
