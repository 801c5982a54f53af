"""The table of all controllers: failures first, then tracking, ratios, torque and time."""

from dataclasses import replace

from ..metrics import METRICS
from ..summary import Summary
from .cells import controller_cells, controller_column, failed_as, verdict_cell, why_none
from .findings import (
    CHATTER,
    CLIPPED,
    CONTOUR,
    JOINTS,
    LAG,
    LAST_LAP,
    ORIENTATION,
    POSITION,
    RATE_CLIPPED,
    Findings,
)
from .numbers import significant, unit_on_page
from .sentences import SUBJECTS
from .table import Cell, Column, Kind, Reading, Table, columns_to_rows, number_cells, word_cell

ERRORS = ((POSITION, "Position"), (ORIENTATION, "Orientation"), (JOINTS, "Joints"))

RUN_WINDOW = "all whole laps after the lead-in"
CHATTER_NOTE = (
    "root mean square of the torque rate: a limit cycle can hide from the tracking figures, not from this one"
)
SATURATION_NOTE = (
    "share of ticks whose command was beyond a torque limit; where it exceeds 1 % in a run, the comparison is of "
    "saturated systems"
)
CALL_NOTE = "median over runs of the median time of one call, knowledge included; depends on the machine"
SPEED_NOTE = "simulated time over wall time, median over runs; depends on the machine"


def headline_table(findings: Findings) -> Table:
    """Return the table of all controllers: failures first, then tracking, ratios, torque and time."""
    pairs = [
        _failure_column(findings),
        *(_mean_column(findings, metric, text, note=_failed_note(findings, metric)) for metric, text in ERRORS),
        _ratio_column(findings, POSITION),
        _ratio_column(findings, ORIENTATION),
        _mean_column(
            findings,
            LAST_LAP,
            "Last lap",
            "Kind of error",
            "mean position error over the last lap: what is left once a controller has learnt",
        ),
        _mean_column(findings, LAG, "Time lag", "Kind of error", "mean magnitude over runs that finished"),
        _mean_column(findings, CONTOUR, "Contour", "Kind of error", "distance to the path, whatever the time"),
        _mean_column(findings, CHATTER, "Chatter", "Torque", CHATTER_NOTE),
        _saturation_column(findings),
        _mean_column(findings, RATE_CLIPPED, "Rate limit", "Torque", "share of ticks that the rate limiter changed"),
        _time_column(findings, "call_us_median", "Call", "\N{MICRO SIGN}s", CALL_NOTE),
        _time_column(findings, "real_time_factor", "Speed", "\N{MULTIPLICATION SIGN} real", SPEED_NOTE),
    ]
    return Table(
        id=f"{findings.world.id}-table",
        caption=f"Mean errors over the run window ({RUN_WINDOW}), {_order(findings)}",
        columns=[controller_column(), *(column for column, _ in pairs)],
        rows=columns_to_rows([controller_cells(findings), *(cells for _, cells in pairs)]),
        name=f"{findings.world.id}-headline",
    )


def _order(findings: Findings) -> str:
    """Say in which order the controllers stand: not that of the column where some ran more than others."""
    shared = len(findings.common_rows) < len(findings.world.rows)
    return "lowest position error first" + (", by the cells that most of them ran" if shared else "")


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
        kind: Kind = "bad" if found.failures else ""
        note = ", ".join(filter(None, notes))
        cells.append(Cell(text, share, f"#{findings.world.id}-failures", note, kind))
    return Column("Failed", note="failed / runs, with the exact 95 % interval of the rate (Clopper-Pearson)"), cells


def _mean_column(
    findings: Findings, metric: str, text: str, group: str = "Mean error", note: str = ""
) -> tuple[Column, list[Cell]]:
    readings = []
    for label in findings.order:
        found = findings.summaries[metric][label]
        cell = Cell("", href=f"#{findings.runs_anchor(label)}", note=_survivors(found))
        readings.append(Reading(found.mean, why_none(found), cell))
    unit = METRICS[metric].unit
    return Column(text, unit_on_page(unit).text, group=group, note=note), number_cells(readings, unit)


def _saturation_column(findings: Findings) -> tuple[Column, list[Cell]]:
    column, cells = _mean_column(findings, CLIPPED, "Saturated", "Torque", SATURATION_NOTE)
    flagged = []
    for label, cell in zip(findings.order, cells, strict=True):
        runs = findings.saturated(label)
        note = f"\N{BLACK FLAG} {runs} {'run' if runs == 1 else 'runs'} > 1 %"
        flagged.append(replace(cell, note=note, kind="bad") if runs else cell)
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
        "\N{WHITE DIAMOND} not enough to decide, each on its own (the statistics below correct for all)"
    )
    return Column(subject, "1", group="Ratio to the reference", note=note if metric == POSITION else ""), cells


def _time_column(findings: Findings, name: str, text: str, unit: str, note: str) -> tuple[Column, list[Cell]]:
    times = [findings.timing(label, name) for label in findings.order]
    readings = [Reading(time, "ok" if time is not None else "missing") for time in times]
    return Column(text, unit, group="Machine", note=note), number_cells(readings, unit)


def _failed_note(findings: Findings, metric: str) -> str:
    """Return what a failed run counts as, if one failed."""
    failed = any(found.failures for found in findings.summaries[metric].values())
    cost = failed_as(metric)
    return (
        f"a failed run counts as {cost}; a mean without the failed is biased, since the hard runs are those that fail"
        if failed and cost
        else ""
    )


def _survivors(found: Summary) -> str:
    """Return the mean without failed runs, where they count in the mean."""
    if not found.failures or found.survivors_mean is None or found.survivors_mean == found.mean:
        return ""
    return f"{significant(unit_on_page(found.unit).of(found.survivors_mean))} without the failed"
