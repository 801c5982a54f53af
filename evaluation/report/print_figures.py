"""The figures of a report for print: the headline ones, and those of the paper where a store has what they show."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as Sheet

from ...controllers import InvalidInput, UnknownName
from ...scenarios.store import Store
from ..errors import UnknownMotionSet
from ..motion_sets import MOTION_SETS, PAPER
from .charts import Chart, around
from .figures import Figure, ratio_figure, trajectory_figure
from .findings import HEADLINES, POSITION, Findings, find_all
from .panels import ModulesPanel, Panels, ResiliencePanel, panels_of
from .print_drawing import FORMATS, PAGE, draw_chart, draw_rows, look, marks_legend, shared_legend, written
from .print_masses import mass_sheet
from .worlds import SPIKING, worlds_of


def print_figures(store_folder: Path, out: Path, controllers: Sequence[str] = (), motions: str = PAPER) -> list[Path]:
    """Write every figure of a run store as SVG and PDF; the same store gives the same bytes.

    Args:
        store_folder: Folder of the store.
        out: Folder of the figures.
        controllers: Labels of the controllers by mass and over time; the reference and the spiking one if empty.
        motions: Set of motions of the figures by mass, where a world has several.

    Returns:
        The files.

    Raises:
        UnknownMotionSet: If there is no such set.
        InvalidInput: If the folder holds no run store, or the figures cannot be written.
        UnknownName: If no run has such a label.
    """
    if motions not in MOTION_SETS:
        raise UnknownMotionSet(motions, tuple(MOTION_SETS))
    with Store.read(store_folder) as store:
        findings = find_all(worlds_of(store.runs(), store.campaigns()))
        panels = [panels_of(found, store) for found in findings]
    known = {label for found in findings for label in found.world.labels}
    for label in controllers:
        if label not in known:
            raise UnknownName("controller in this store", label, sorted(known))
    files = []
    with look():
        for found, extra in zip(findings, panels, strict=True):
            for name, sheet in _sheets(found, extra, chosen(found, controllers), motions):
                files += _write(sheet, out, f"{found.world.id}-{name}")
    return files


def chosen(findings: Findings, controllers: Sequence[str]) -> list[str]:
    """Return the controllers of the figures that show few: those asked for, else the reference and the spiking one.

    Where either did not run, the best in position takes its place.
    """
    world = findings.world
    if controllers:
        return [label for label in controllers if label in world.labels]
    spiking = [run.row.controller for run in world.runs if run.stored.specification.controller == SPIKING]
    wanted = [*spiking[:1], *([world.reference] if world.has_reference else []), *findings.ranked(POSITION)]
    return list(dict.fromkeys(wanted))[:2]


def _write(sheet: Sheet, out: Path, name: str) -> list[Path]:
    files = [out / f"{name}.{suffix}" for suffix in FORMATS]
    try:
        out.mkdir(parents=True, exist_ok=True)
        for file in files:
            file.write_bytes(written(sheet, file.suffix[1:]))
    except OSError as cause:
        raise InvalidInput(
            f"cannot be written ({cause.strerror})", str(out), "name another folder with --out"
        ) from cause
    return files


def _sheets(findings: Findings, panels: Panels, labels: Sequence[str], motions: str) -> Iterator[tuple[str, Sheet]]:
    """Yield name and sheet of every figure that a world has data for."""
    ratios = [ratio_figure(findings, metric) for metric in HEADLINES]
    dots = [trajectory_figure(findings, metric) for metric in HEADLINES]
    for name, figures in (("intervals", ratios), ("errors-by-trajectory", dots)):
        if able := [figure for figure in figures if figure is not None]:
            yield name, _rows(able)
    if (masses := mass_sheet(findings, labels, motions)) is not None:
        yield "errors-by-mass", masses
    if panels.laps:
        yield "errors-by-lap", _side_by_side(panels.laps)
    if panels.modules is not None:
        yield from _modules(panels.modules)
    if panels.resilience is not None and panels.resilience.curves:
        yield "resilience", _resilience(panels.resilience, labels)


def _rows(figures: Sequence[Figure]) -> Sheet:
    sheet = Sheet(figsize=(PAGE, 1.1 + 0.22 * len(figures[0].lines)), layout="constrained")
    drawn: list[str] = []
    for axes, figure in zip(np.ravel(sheet.subplots(1, len(figures))), figures, strict=True):
        draw_rows(axes, figure)
        if drawn == [line.label for line in figure.lines]:
            axes.set_yticklabels([])
        drawn = [line.label for line in figure.lines]
    marks_legend(sheet, figures[0])
    return sheet


def _side_by_side(charts: Sequence[Chart], titles: Mapping[str, str] | None = None) -> Sheet:
    sheet = Sheet(figsize=(PAGE, 2.4), layout="constrained")
    for axes, chart in zip(np.ravel(sheet.subplots(1, len(charts))), charts, strict=True):
        draw_chart(axes, chart, title=(titles or {}).get(chart.id, ""))
    return sheet


def _modules(panel: ModulesPanel) -> Iterator[tuple[str, Sheet]]:
    """Yield error and weight by load, and the gains over time, as the paper has them."""
    if panel.loads:
        yield "modules", _side_by_side(panel.loads)
    drawn = [charts for _, charts, _ in panel.gains if charts]
    if drawn:
        sheet = _side_by_side(drawn[0])
        shared_legend(sheet, sheet.axes)
        yield "gains", sheet


def _resilience(panel: ResiliencePanel, labels: Sequence[str]) -> Sheet:
    """Return the error over time above, and the time after each event below."""
    drawn = {chart.title: chart for chart in panel.curves}
    able = [drawn[label] for label in labels if label in drawn] or list(panel.curves[:1])
    curves = [replace(chart.curves[-1], style=style) for style, chart in enumerate(able)]
    # The page cuts a curve that would leave no room for others, and says so; on paper it is whole.
    whole = replace(able[0], curves=curves, y=around("joint error [mrad]", [curve.y for curve in curves], zero=True))
    zooms = list(panel.zooms)
    if not zooms:
        return _side_by_side([whole], {whole.id: "Joint error over time"})
    sheet = Sheet(figsize=(PAGE, 4.2), layout="constrained")
    grid = sheet.add_gridspec(2, len(zooms))
    above = sheet.add_subplot(grid[0, :])
    draw_chart(above, whole, title="Joint error over time")
    above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(curves))
    below = [sheet.add_subplot(grid[1, place]) for place in range(len(zooms))]
    for axes, chart in zip(below, zooms, strict=True):
        draw_chart(axes, chart)
    shared_legend(sheet, below)
    return sheet
