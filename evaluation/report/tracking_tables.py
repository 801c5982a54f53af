"""Tables of what the controllers reached: the headline, and how it splits by trajectory, mass and lap."""

from collections.abc import Callable, Mapping
from typing import Any

from ..comparison import Comparison
from ..intervals import ShapeRange
from ..metrics import METRICS
from ..summary import Summary
from .findings import (
    CHATTER,
    CLIPPED,
    CONTOUR,
    HEADLINES,
    JOINTS,
    LAG,
    LAST_LAP,
    ORIENTATION,
    POSITION,
    RATE_CLIPPED,
    Findings,
)
from .numbers import ratio_text, significant, unit_on_page
from .sentences import SUBJECTS
from .table import Cell, Column, Reading, Table, columns_to_rows, head_cells, number_cells, word_cell

VERDICTS = {"better": ("\N{BLACK DOWN-POINTING TRIANGLE}", "good"), "worse": ("\N{BLACK UP-POINTING TRIANGLE}", "bad")}
UNDECIDED = ("\N{WHITE DIAMOND}", "open")
"""Symbols of a verdict, so that it does not hang on colour."""

ERRORS = ((POSITION, "Position"), (ORIENTATION, "Orientation"), (JOINTS, "Joints"))

RUN_WINDOW = "all whole laps after the lead-in"
CHATTER_NOTE = "root mean square of the torque rate: a limit cycle can hide from the tracking figures, not from this one"
SATURATION_NOTE = (
    "share of ticks whose command was beyond a torque limit; where it exceeds 1 % in a run, the comparison is of "
    "saturated systems"
)
MACHINE_NOTE = "median over runs; depends on the machine"


def headline_table(findings: Findings) -> Table:
    """Return the table of all controllers: failures first, then tracking, ratios, torque and time."""
    pairs = [
        _failure_column(findings),
        *(_mean_column(findings, metric, text, note=_failed_note(findings, metric)) for metric, text in ERRORS),
        _ratio_column(findings, POSITION),
        _ratio_column(findings, ORIENTATION),
        _mean_column(findings, LAST_LAP, "Last lap", "Kind of error", "mean position error over the last lap: what is left once a controller has learnt"),
        _mean_column(findings, LAG, "Time lag", "Kind of error", "mean magnitude over runs that finished"),
        _mean_column(findings, CONTOUR, "Contour", "Kind of error", "distance to the path, whatever the time"),
        _mean_column(findings, CHATTER, "Chatter", "Torque", CHATTER_NOTE),
        _saturation_column(findings),
        _mean_column(findings, RATE_CLIPPED, "At rate limit", "Torque", "share of ticks that the rate limiter changed"),
        _time_column(findings, "call_us_median", "Call", "us", 1.0),
        _time_column(findings, "real_time_factor", "Speed", "x real time", 1.0),
    ]
    return Table(
        id=f"{findings.world.id}-table",
        caption=f"Mean errors over the run window ({RUN_WINDOW}), lowest position error first",
        columns=[_controller_column(), *(column for column, _ in pairs)],
        rows=columns_to_rows([_controllers(findings), *(cells for _, cells in pairs)]),
        name=f"{findings.world.id}-headline",
    )


def trajectory_table(findings: Findings, metric: str) -> Table:
    """Return the mean of each controller on each trajectory."""
    names = list(dict.fromkeys(run.row.trajectory for run in findings.world.runs))
    return _split_table(findings, metric, "trajectory", names, str, lambda s: s.by_trajectory)


def mass_table(findings: Findings, metric: str) -> Table:
    """Return the mean of each controller at each mass."""
    masses = findings.world.distinct(lambda row: row.mass)
    return _split_table(findings, metric, "mass", masses, lambda mass: f"{mass:g} kg", lambda s: s.by_mass)


def shape_table(findings: Findings) -> Table:
    """Return how much the error depends on the path: largest less smallest path mean, group by group."""
    groups = sorted({run.row.group for run in findings.world.runs}, reverse=True)
    columns, cells = [], []
    for metric in HEADLINES:
        for group in groups:
            ranges = {label: findings.summaries[metric][label].by_group.get(group) for label in findings.order}
            readings = [
                Reading(found.value, "ok", Cell("", note=_extremes(found)))
                if found
                else Reading(None, _why_none(findings.summaries[metric][label]))
                for label, found in ranges.items()
            ]
            unit = METRICS[metric].unit
            columns.append(Column(group or "all paths", unit_on_page(unit).text, group=SUBJECTS[metric].capitalize()))
            cells.append(number_cells(readings, unit))
    return Table(
        id=f"{findings.world.id}-shape",
        caption="Shape range: largest less smallest trajectory mean within a group of trajectories",
        columns=[_controller_column(), *columns],
        rows=columns_to_rows([_controllers(findings), *cells]),
        name=f"{findings.world.id}-shape-range",
    )


def lap_table(findings: Findings, metric: str) -> Table:
    """Return the mean of each lap: who wins depends on how long one learns."""
    laps = int(findings.world.facts["Laps"])
    found = findings.by_lap(metric)
    registered = METRICS.get(metric)
    unit, label = (registered.unit, registered.label) if registered else ("m", metric)
    flat = [Reading(found[name][lap]) for name in found for lap in range(laps)]
    cells = number_cells(flat, unit)
    rows = [
        (head, *cells[index * laps : (index + 1) * laps])
        for index, head in enumerate(head_cells(found, (f"#{findings.runs_anchor(name)}" for name in found)))
    ]
    return Table(
        id=f"{findings.world.id}-laps-{metric}",
        caption=f"{label[0].upper()}{label[1:]} by lap, mean over the runs that finished",
        columns=[_controller_column(), *(Column(f"Lap {lap + 1}", unit_on_page(unit).text) for lap in range(laps))],
        rows=rows,
        name=f"{findings.world.id}-laps-{metric}",
    )


def verdict_cell(comparison: Comparison, verdict: str, href: str = "") -> Cell:
    """Return a ratio with its interval and the symbol of its verdict."""
    symbol, kind = VERDICTS.get(verdict, UNDECIDED)
    interval = comparison.interval_new_motions
    note = "one trajectory: no interval"
    if interval is not None:
        note = f"{ratio_text(interval.low)} to {ratio_text(interval.high)}"
    return Cell(f"{symbol} {ratio_text(comparison.gmr)}", comparison.gmr, href, note, kind)  # type: ignore[arg-type]


def _controller_column() -> Column:
    return Column("Controller / knowledge", numeric=False)


def _controllers(findings: Findings) -> list[Cell]:
    return head_cells(findings.order, (f"#{findings.runs_anchor(label)}" for label in findings.order))


def _failure_column(findings: Findings) -> tuple[Column, list[Cell]]:
    cells = []
    for label in findings.order:
        found = findings.summaries[POSITION][label]
        rate = found.failure_rate
        notes = [f"up to {100 * rate.high:.0f} %" if rate and found.failures == 0 else ""]
        if rate and found.failures:
            notes = [f"{100 * rate.low:.0f} to {100 * rate.high:.0f} %"]
        notes += [f"{found.refused} refused"] if found.refused else []
        share = found.failures / found.runs if found.runs else None
        text = f"{found.failures} / {found.runs}"
        kind = "bad" if found.failures else ""
        note = ", ".join(filter(None, notes))
        cells.append(Cell(text, share, f"#{findings.world.id}-failures", note, kind))  # type: ignore[arg-type]
    return Column("Failed", note="failed / runs, with the exact 95 % interval of the rate (Clopper-Pearson)"), cells


def _mean_column(
    findings: Findings, metric: str, text: str, group: str = "Mean error", note: str = ""
) -> tuple[Column, list[Cell]]:
    readings = []
    for label in findings.order:
        found = findings.summaries[metric][label]
        cell = Cell("", href=f"#{findings.runs_anchor(label)}", note=_survivors(found))
        readings.append(Reading(found.mean, _why_none(found), cell))
    unit = METRICS[metric].unit
    return Column(text, unit_on_page(unit).text, group=group, note=note), number_cells(readings, unit)


def _saturation_column(findings: Findings) -> tuple[Column, list[Cell]]:
    column, cells = _mean_column(findings, CLIPPED, "Saturated", "Torque", SATURATION_NOTE)
    flagged = []
    for label, cell in zip(findings.order, cells, strict=True):
        runs = findings.saturated(label)
        note = f"\N{BLACK FLAG} {runs} {'run' if runs == 1 else 'runs'} > 1 %"
        flagged.append(Cell(cell.text, cell.value, cell.href, note, "bad") if runs else cell)
    return column, flagged


def _ratio_column(findings: Findings, metric: str) -> tuple[Column, list[Cell]]:
    world, subject = findings.world, SUBJECTS[metric].capitalize()
    cells = []
    for label in findings.order:
        comparison = findings.comparisons[metric].get(label)
        if world.has_reference and label == world.reference:
            cells.append(Cell("1", 1.0, note="the reference"))
        elif comparison is None:
            cells.append(word_cell("no pair" if world.has_reference else "no reference"))
        else:
            cells.append(verdict_cell(comparison, findings.verdict_alone(comparison), f"#{world.id}-comparisons"))
    note = (
        "geometric mean of the ratio to the reference, with the 95 % interval over trajectories; "
        "\N{BLACK DOWN-POINTING TRIANGLE} lower, \N{BLACK UP-POINTING TRIANGLE} higher, "
        "\N{WHITE DIAMOND} not enough to decide"
    )
    return Column(subject, "1", group="Ratio to the reference", note=note if metric == POSITION else ""), cells


def _time_column(findings: Findings, name: str, text: str, unit: str, factor: float) -> tuple[Column, list[Cell]]:
    times = [findings.timing(label, name) for label in findings.order]
    readings = [Reading(None if time is None else time * factor, "missing") for time in times]
    shown = "\N{MICRO SIGN}s" if unit == "us" else unit
    return Column(text, shown, group="Time (this machine)", note=MACHINE_NOTE), number_cells(readings, unit)


def _split_table(
    findings: Findings,
    metric: str,
    word: str,
    keys: list[Any],
    title: Callable[[Any], str],
    split: Callable[[Summary], Mapping[Any, float]],
) -> Table:
    """Return the means of one metric, one column for each value of what it is split by."""
    unit = METRICS[metric].unit
    summaries = findings.summaries[metric]
    anchors = {label: f"#{findings.runs_anchor(label)}" for label in findings.order}
    readings = []
    for label in findings.order:
        means, status = split(summaries[label]), _why_none(summaries[label])
        readings += [Reading(means.get(key), status if not means else "missing", Cell("", href=anchors[label])) for key in keys]
    cells = number_cells(readings, unit)
    return Table(
        id=f"{findings.world.id}-{word}-{SUBJECTS[metric]}",
        caption=f"Mean {SUBJECTS[metric]} error by {word}, run window",
        columns=[_controller_column(), *(Column(title(key), unit_on_page(unit).text) for key in keys)],
        rows=[
            (head, *cells[index * len(keys) : (index + 1) * len(keys)]) for index, head in enumerate(_controllers(findings))
        ],
        name=f"{findings.world.id}-{SUBJECTS[metric]}-by-{word}",
    )


def _failed_note(findings: Findings, metric: str) -> str:
    """Return what a failed run counts as, if one failed."""
    failed = any(found.failures for found in findings.summaries[metric].values())
    cost = failed_as(metric)
    return f"a failed run counts as {cost}; a mean without the failed is biased, since the hard runs are those that fail" if failed and cost else ""


def failed_as(metric: str) -> str:
    """Return what a failed run counts as in means and ratios, empty if it is left out."""
    cost, shown = METRICS[metric].fail_value, unit_on_page(METRICS[metric].unit)
    return "" if cost is None else f"{significant(shown.of(cost))} {shown.text}"


def _survivors(found: Summary) -> str:
    """Return the mean without failed runs, where they count in the mean."""
    if not found.failures or found.survivors_mean is None or found.survivors_mean == found.mean:
        return ""
    return f"{significant(unit_on_page(found.unit).of(found.survivors_mean))} without the failed"


def _why_none(found: Summary) -> str:
    """Return why a controller may have no mean."""
    if found.runs == 0:
        return "refused"
    return "failed" if found.failures == found.runs else "undefined"


def _extremes(found: ShapeRange) -> str:
    return f"{found.largest} less {found.smallest}" if found.largest != found.smallest else "one path"
