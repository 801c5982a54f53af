"""Errors by mass in the manner of the paper: ranges over motions, slow and fast apart, for two controllers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Sheet
from matplotlib.patches import Patch

from ..metrics import METRICS
from ..motion_sets import MOTION_SETS, PAPER, TITLES, rows_in, sets_in
from ..rows import RunRow, read
from .drawing import COLOURS
from .findings import HEADLINES, WINDOW, Findings
from .numbers import capitalised, counting, unit_on_page
from .print_drawing import PAGE
from .sentences import SUBJECTS

HATCHES = ("", "////", "xxxx")
"""One for each group of motions; a third and all beyond share the last."""


@dataclass(frozen=True)
class MassRange:
    """The errors of one controller on one group of motions with one load.

    Attributes:
        low: Smallest mean of a motion over repetitions.
        high: Largest mean of a motion.
        least: Smallest error of a run.
        most: Largest error of a run.
    """

    low: float
    high: float
    least: float
    most: float


def mass_range(rows: Sequence[RunRow], metric: str) -> MassRange | None:
    """Return the range of rows of one controller, group and load; None without a run that finished with a value.

    A failed run has no error to draw, only a cost: the legend says how many there are.
    """
    found: dict[str, list[float]] = {}
    for row in rows:
        reading = read(row, METRICS[metric], WINDOW)
        if reading.magnitude is not None and reading.status != "failed":
            found.setdefault(row.trajectory, []).append(reading.magnitude)
    if not found:
        return None
    means = [float(np.mean(values)) for values in found.values()]
    single = [value for values in found.values() for value in values]
    return MassRange(min(means), max(means), min(single), max(single))


def mass_sheet(findings: Findings, labels: Sequence[str], motions: str = PAPER) -> Sheet | None:
    """Return a panel for each material and headline metric; None with fewer than two loads.

    Args:
        findings: The world's findings.
        labels: The controllers.
        motions: Which set of motions, where a world has several.
    """
    rows = [row for row in findings.world.rows if row.controller in labels]
    rows = rows_in(rows, motions) if sets_in(rows) else rows
    if len({row.mass for row in rows}) < 2:
        return None
    materials = sorted({row.material for row in rows} - {""}) or [""]
    sheet = Sheet(figsize=(PAGE, 2.3 * len(materials)), layout="constrained")
    panels = np.atleast_2d(sheet.subplots(len(materials), len(HEADLINES)))
    groups = sorted({row.group for row in rows}, reverse=True)
    for material, line in zip(materials, panels, strict=True):
        for metric, axes in zip(HEADLINES, line, strict=True):
            # What carries nothing has no material, and belongs to every one.
            _panel(axes, [row for row in rows if row.material in ("", material)], metric, labels, groups)
            axes.set_title(f"{SUBJECTS[metric].capitalize()} error, {material or 'all loads'}", loc="left")
    shown = [
        Patch(facecolor=COLOURS[place % len(COLOURS)], label=_named(label, rows)) for place, label in enumerate(labels)
    ]
    shown += [
        Patch(facecolor="white", edgecolor="black", hatch=_hatch(i), label=g or "all") for i, g in enumerate(groups)
    ]
    words = f"{_motions(rows)}. Bars: from the least to the largest mean of a motion; lines: of a single run"
    sheet.legend(handles=shown, loc="outside lower center", ncols=4, title=words, title_fontsize=6.0)
    return sheet


def _motions(rows: Sequence[RunRow]) -> str:
    """Return the motions of runs: the name of their set, or each by its own."""
    names = {row.trajectory for row in rows}
    whole = [TITLES[name] for name, motions in MOTION_SETS.items() if names == set(motions)]
    title = whole[0] if whole else ", ".join(sorted(names, key=counting))
    return capitalised(title)


def _named(label: str, rows: Sequence[RunRow]) -> str:
    """Return a controller with what of it is not drawn."""
    own = [row for row in rows if row.controller == label and row.status != "refused"]
    failed = sum(row.status == "failed" for row in own)
    return f"{label} ({failed} of {len(own)} runs failed, not drawn)" if failed else label


def _panel(axes: Axes, rows: Sequence[RunRow], metric: str, labels: Sequence[str], groups: Sequence[str]) -> None:
    shown = unit_on_page(METRICS[metric].unit)
    masses = sorted({row.mass for row in rows})
    width = 0.8 / (len(labels) * len(groups))
    for place, mass in enumerate(masses):
        for i, label in enumerate(labels):
            for j, group in enumerate(groups):
                cell = [row for row in rows if (row.mass, row.controller, row.group) == (mass, label, group)]
                found = mass_range(cell, metric)
                if found is not None:
                    x = place - 0.4 + width * (i * len(groups) + j + 0.5)
                    _bar(axes, x, width, found, shown.factor, COLOURS[i % len(COLOURS)], _hatch(j))
    axes.set_xticks(range(len(masses)), [f"{mass:g}" for mass in masses])
    axes.set_xlabel("load beyond the flange [kg]")
    axes.set_ylabel(f"mean error [{shown.text}]")
    axes.set_ylim(bottom=0.0)


def _bar(axes: Axes, x: float, width: float, found: MassRange, factor: float, colour: str, hatch: str) -> None:
    low, high = found.low * factor, found.high * factor
    axes.bar(x, high - low, 0.9 * width, bottom=low, color=colour, hatch=hatch, edgecolor="black", linewidth=0.5)
    axes.vlines(x, found.least * factor, found.most * factor, color="black", linewidth=0.6)


def _hatch(place: int) -> str:
    return HATCHES[min(place + 1, len(HATCHES) - 1)]
