"""Tables of margins: by bisection for each controller and motion, and of loops with the worst joint first."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from .cells import controller_column
from .findings import Findings
from .numbers import AT_LEAST, fixed, significant, unit_on_page
from .robustness import LOOPS, Entry, Robustness, joint_windows
from .table import Cell, Column, Table, columns_to_rows, word_cell

MARGINS = {
    "load_margin": ("Load", "kg", "extra mass in the container's place, in steps of 0.1 kg"),
    "delay_margin": ("Delay", "ms", "extra ticks between command and torque"),
    "gain_margin_up": ("More gain", "%", "every command too large by so much, in steps of 5 %"),
    "gain_margin_down": ("Less gain", "%", "every command too small by so much, in steps of 5 %"),
    "noise_margin": ("Noise", "rad/s", "standard deviation of white noise on every joint velocity, to a factor of 1.5"),
    "friction_margin": ("Friction", "\N{MULTIPLICATION SIGN} nominal", "in steps of half the nominal friction"),
    "init_offset_margin": (
        "Offset",
        "mrad",
        "norm of the joint error at the start, in steps of 20 mrad; 1 rad fails by definition",
    ),
}
"""Header, unit on the page and note of each margin."""

DECIMALS = {
    "load_margin": 1, "delay_margin": 0, "gain_margin_up": 0, "gain_margin_down": 0, "friction_margin": 1,
    "init_offset_margin": 0,
}  # fmt: skip
"""Digits after the point that a margin's grid has, on the page; two significant ones for what has none here."""

LOOP_COLUMNS = {
    "phase_margin": ("Phase", "deg", "One loop broken", "smallest over the gain crossovers"),
    "gain_margin": ("Gain", "\N{MULTIPLICATION SIGN}", "One loop broken", "factor to the edge of stability"),
    "loop_delay_margin": ("Delay", "ms", "One loop broken", "phase margin over crossover frequency"),
    "modulus_margin": ("Modulus", "1", "One loop broken", "smallest distance of the response from \N{MINUS SIGN}1"),
    "crossover": ("Crossover", "rad/s", "One loop broken", ""),
    "disk_margin": ("Alpha", "1", "Disk", "gain and phase of one loop wrong at once, without skew"),
    "disk_gain_margin": ("Gain", "\N{MULTIPLICATION SIGN}", "Disk", ""),
    "disk_phase_margin": ("Phase", "deg", "Disk", ""),
    "scatter": (
        "Scatter",
        "%",
        "",
        "relative standard error of the disk margin's worst line, from period to period: noise and learning",
    ),
}
"""Header, unit on the page, shared header and note of each figure of a loop."""

NOISY = 0.1
"""Scatter above which a loop's figures are marked."""

TOGETHER_NOTE = (
    "a bound: gain and phase of all loops wrong at once and independently by no more than this are safe at the "
    "measured frequencies; the exact margin may be larger"
)


def margin_table(findings: Findings, robustness: Robustness) -> Table:
    """Return the margins of every controller and motion."""
    found = robustness.margins
    shown = [name for name in MARGINS if any(name in entries for entries in found.values())]
    heads = [_head(findings, label) for label, _ in found]
    motions = [Cell(trajectory) for _, trajectory in found]
    cells = [[_margin_cell(name, entries.get(name)) for entries in found.values()] for name in shown]
    columns = [Column(text, unit, note=note) for text, unit, note in (MARGINS[name] for name in shown)]
    return Table(
        id=f"{findings.world.id}-margins",
        caption="Margins by bisection: the worst world that is still come through",
        columns=[controller_column(), Column("Motion", numeric=False), *columns],
        rows=columns_to_rows([heads, motions, *cells]),
        name=f"{findings.world.id}-margins",
    )


def worst_loop_table(findings: Findings, robustness: Robustness) -> Table:
    """Return the loop margins of every controller, each figure that of its worst joint, and all loops together."""
    labels = [label for label in robustness.order if label in robustness.loops]
    worst = {name: [_worst(robustness.loops[label], name) for label in labels] for name in LOOP_COLUMNS}
    cells = [_loop_cells(name, [entry for entry, _ in found]) for name, found in worst.items()]
    named = [
        [replace(cell, note=where) for cell, (_, where) in zip(column, worst[name], strict=True)]
        for name, column in zip(LOOP_COLUMNS, cells, strict=True)
    ]
    together = [robustness.loops[label][LOOPS].get("multiloop_disk_margin") for label in labels]
    columns, place = _loop_columns(), list(LOOP_COLUMNS).index("disk_phase_margin") + 1
    columns.insert(place, Column("All loops", "1", group="Disk", note=TOGETHER_NOTE))
    named.insert(place, _loop_cells("multiloop_disk_margin", together))
    return Table(
        id=f"{findings.world.id}-loops",
        caption="Margins of the measured loops, each figure that of its worst joint",
        columns=[controller_column(), *columns],
        rows=columns_to_rows([[_head(findings, label) for label in labels], *named]),
        name=f"{findings.world.id}-loops",
    )


def loop_table(findings: Findings, robustness: Robustness) -> Table:
    """Return the loop margins of every controller, joint by joint."""
    lines = [
        (label, window, robustness.loops[label][window])
        for label in robustness.order
        if label in robustness.loops
        for window in joint_windows(robustness.loops[label])
    ]
    cells = [_loop_cells(name, [entries.get(name) for _, _, entries in lines]) for name in LOOP_COLUMNS]
    heads = [_head(findings, label) for label, _, _ in lines]
    joints = [Cell(window.split()[-1], float(window.split()[-1])) for _, window, _ in lines]
    return Table(
        id=f"{findings.world.id}-loops-by-joint",
        caption="Margins of the measured loops, joint by joint",
        columns=[controller_column(), Column("Joint"), *_loop_columns()],
        rows=columns_to_rows([heads, joints, *cells]),
        name=f"{findings.world.id}-loops-by-joint",
    )


def without_table(findings: Findings, robustness: Robustness) -> Table:
    """Return what could not be measured, and why."""
    words = ("Controller / knowledge", "Motion", "Measured", "Status", "Reason")
    rows = []
    for run in robustness.without:
        texts = (run.row.trajectory, run.stored.specification.study, run.row.status)
        reason = Cell(run.stored.result.reason, kind="wide")
        rows.append((_head(findings, run.row.controller), *(Cell(text) for text in texts), reason))
    return Table(
        id=f"{findings.world.id}-unmeasured",
        caption="Margins and loops that could not be measured",
        columns=[Column(word, numeric=False) for word in words],
        rows=rows,
        name=f"{findings.world.id}-unmeasured",
    )


def _head(findings: Findings, label: str) -> Cell:
    """Return a row header; whoever only has studies has no runs to lead to."""
    href = f"#{findings.runs_anchor(label)}" if label in findings.order else ""
    return Cell(label, href=href, kind="head")


def _margin_cell(name: str, entry: Entry | None) -> Cell:
    """Return a margin with the digits of its grid: bounds marked, a response that recovers further out flagged."""
    if entry is None:
        return word_cell("missing")
    value = _number(entry)
    if value is None:
        return replace(word_cell(str(entry["status"])), note=str(entry.get("reason", "")))
    shown = unit_on_page(str(entry["unit"])).of(value)
    decimals = DECIMALS.get(name)
    text = significant(shown, 2) if decimals is None else fixed(shown, decimals)
    bound = f"{AT_LEAST} " if entry["status"] == "censored" else ""
    flag = "\N{BLACK FLAG} recovers further out" if entry.get("monotone") is False else ""
    return Cell(f"{bound}{text}", shown, note=flag, kind="open" if flag else "")


def _number(entry: Entry) -> float | None:
    """Return a stored number, None if there is none or it is not finite."""
    value = entry.get("value")
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _loop_columns() -> list[Column]:
    return [Column(text, unit, group=group, note=note) for text, unit, group, note in LOOP_COLUMNS.values()]


def _loop_cells(name: str, entries: Sequence[Entry | None]) -> list[Cell]:
    """Return one figure's column; what no measured frequency reaches is infinite."""
    unit = unit_on_page(next((str(entry["unit"]) for entry in entries if entry is not None), ""))
    cells = []
    for entry in entries:
        if entry is None:
            cells.append(word_cell("missing"))
            continue
        value = _number(entry)
        if value is None:
            cells.append(Cell("\N{INFINITY}" if name != "crossover" else "none", kind="missing"))
            continue
        noisy = name == "scatter" and value > NOISY
        shown = unit.of(value)
        text = fixed(shown, 1 if abs(shown) >= 10.0 else 2)
        cells.append(Cell(f"\N{BLACK FLAG} {text}" if noisy else text, shown, kind="bad" if noisy else ""))
    return cells


def _worst(windows: Mapping[str, Mapping[str, Entry]], name: str) -> tuple[Entry | None, str]:
    """Return the entry of the joint that is worst in a figure, and which that is."""
    found: list[tuple[float, str]] = []
    for window in joint_windows(windows):
        value = _number(windows[window].get(name, {}))
        if value is not None:
            found.append((value, window))
    if not found:
        first = joint_windows(windows)[:1]
        return (windows[first[0]].get(name) if first else None), ""
    if name in ("scatter", "crossover"):
        _, window = max(found)
    elif name == "gain_margin":
        _, window = min(found, key=lambda pair: abs(math.log(pair[0])))
    else:
        _, window = min(found)
    return windows[window][name], f"joint {window.split()[-1]}"
