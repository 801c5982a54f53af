"""The catalogue of metrics as Markdown, made from the registry: ``python -m torquebench.evaluation.metrics.catalogue``.

The command writes it to the end of the page that it is given, below the marker.
"""

import re
import sys
from collections.abc import Iterable, Mapping
from itertools import groupby
from pathlib import Path

from .builtin import METRICS
from .registry import Metric

MARKER = "<!-- Below: made by python -m torquebench.evaluation.metrics.catalogue docs/metrics.md -->\n"
COLUMNS = ("Id", "What", "Unit", "Better", "Needs", "Source", "Version")
TITLES = {"iso": "ISO 9283 style"}
KINDS = {
    "log": "a log",
    "twins": "a run with load events and its twins",
    "table": "values or curves of several runs",
    "timing": "wall times; never among the results of a run",
}


def catalogue(metrics: Mapping[str, Metric[...]] = METRICS) -> str:
    """Return a table for each family and kind of metric, in the order of the registry.

    Args:
        metrics: The metrics by id.
    """
    return "\n".join(
        _table(family, kind, list(members))
        for (family, kind), members in groupby(metrics.values(), lambda m: (m.family, m.kind))
    )


def page_with(text: str, tables: str) -> str:
    """Return a page with tables in place of what stood below its marker.

    Args:
        text: The page.
        tables: Markdown, ending with a new line.
    """
    return f"{text.partition(MARKER)[0]}{MARKER}\n{tables}"


def _table(family: str, kind: str, members: Iterable[Metric[...]]) -> str:
    title = f"### {TITLES.get(family, family.capitalize())}, of {KINDS[kind]}"
    rule = "| --- " * len(COLUMNS) + "|"
    return "\n".join([title, "", _row(COLUMNS), rule, *(_row(_cells(found)) for found in members), ""])


def _cells(found: Metric[...]) -> tuple[str, ...]:
    first = re.sub(r":\w+:`([^`]*)`", r"`\1`", (found.__doc__ or "").strip().partition("\n")[0])
    needs = ", ".join(f"`{name}`" for name in found.needs)
    return f"`{found.id}`", first, found.unit, found.better, needs, found.source, str(found.version)


def _row(cells: Iterable[str]) -> str:
    # A bar inside a cell would end it.
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def main(page: Path) -> None:
    """Renew the catalogue of a page."""
    page.write_text(page_with(page.read_text(encoding="utf-8"), catalogue()), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
