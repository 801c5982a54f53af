"""Tables of the load events: recovery beside the error that it arrives at, and peaks beside their nulls."""

from collections.abc import Sequence
from dataclasses import replace

from .cells import controller_column
from .findings import Findings
from .resilience import Event, Resilience
from .spread import SECONDS, Spread, spread_cell
from .table import Cell, Column, Table

TWINS, CURVES = "Recovery, judged by twins", "Recovery, from the mean curve"
NOMINAL_NOTE = "back to the error as if nothing had happened; it never comes if the new load costs more for good"
SETTLED_NOTE = (
    "first time from which the error stays within a share of the error before the event of what it would be had the "
    "new load always been there, for 0.5 s; a conclusion that changes with the share is none"
)
STEADY_NOTE = (
    "mean joint error of the last lap before the next event, from the curves: a wide band recovers at once, so no "
    "recovery may be read without it"
)
CYCLE_NOTE = (
    "excess over the phase-matched last lap stays below 20 % of its peak, at least 5 mrad; the one constant of the "
    "spiking controller, sigma, was fitted with this: for it, no prediction"
)
PAPER_NOTE = "our reading of the paper: the mean curve stays for 0.5 s in the 10 % wider band of its last two laps"
PEAKS = tuple(f"recovery_peaks_{share}" for share in ("05", "10", "15", "20", "30"))


def event_table(findings: Findings, resilience: Resilience, event: Event) -> Table:
    """Return recovery and excess of every controller after one event."""
    columns = [
        controller_column(),
        Column("Failed", note="failed / runs; medians are over runs that finished, recovery from curves over seeds"),
        Column("Steady error", "mrad", note=STEADY_NOTE),
    ]
    shown: list[tuple[str, str, int]] = [("last_cycle_error", "rad", 1)]
    if event.window:
        columns += [
            Column("25 %", "s", group=TWINS, note=SETTLED_NOTE),
            Column("10 %", "s", group=TWINS),
            Column("50 %", "s", group=TWINS),
            Column("Nominal", "s", group=TWINS, note=NOMINAL_NOTE),
        ]
        shown += [(f"recovery_time_settled{share}", "s", SECONDS) for share in ("", "_10", "_50")]
        shown += [("recovery_time_nominal", "s", SECONDS)]
    columns += [
        Column("Cycle band", "s", group=CURVES, note=CYCLE_NOTE),
        Column("Paper style", "s", group=CURVES, note=PAPER_NOTE),
        Column("Raw peak", "mrad", group="Size", note="largest mean error until the next event, 20 ms average"),
    ]
    shown += [("recovery_time_cycle_band", "s", SECONDS), ("recovery_time_paper_style", "s", SECONDS)]
    shown += [("error_peak_raw", "rad", 1)]
    if event.window:
        columns += [
            Column("Excess peak", "mrad", group="Size", note="over the run without the event, within 2.5 s"),
            Column("Residual", "mrad", group="Size", note="mean excess of the last lap: what never came back"),
            Column("Position, 25 %", "s", group="Tool point", note="settled, judged on the tool point"),
            Column("Excess peak", "mm", group="Tool point"),
        ]
        shown += [("excess_peak", "rad", 1), ("residual_excess", "rad", 2)]
        shown += [("recovery_time_settled_position", "s", SECONDS), ("excess_peak_position", "m", 1)]
    rows = []
    for label in findings.order:
        found = resilience.found[event, label]
        cells = [spread_cell(found.get(name, Spread()), unit, decimals) for name, unit, decimals in shown]
        rows.append((*_head(findings, label), *cells))
    name = f"{findings.world.id}-event-{event.time:g}"
    columns = [replace(column, note="") if _explained(resilience, event, column) else column for column in columns]
    return Table(id=name, caption=_caption(event), columns=columns, rows=rows, name=name)


def peak_table(findings: Findings, resilience: Resilience, event: Event) -> Table:
    """Return how many peaks follow an event, at five ideas of what a peak is."""
    columns = [
        controller_column(),
        *(Column(f"{int(name[-2:])} %", "1", group="Peaks of the excess, by least prominence") for name in PEAKS),
        Column("Stable", numeric=False, note="equal at 10, 15 and 20 % in every run; only then it is a count"),
        Column("With event", "1", group="Peaks of the error itself", note="as the paper counts, prominence 15 %"),
        Column("Without", "1", group="Peaks of the error itself", note="the same motion without any event"),
    ]
    rows = []
    for label in findings.order:
        found = resilience.found[event, label]
        counts = [spread_cell(found[name], "", 0) for name in PEAKS]
        raw = [spread_cell(found[name], "", 0) for name in ("recovery_peaks_raw", "recovery_peaks_raw_null")]
        head = Cell(label, href=f"#{findings.runs_anchor(label)}", kind="head")
        rows.append((head, *counts, _stable(found["recovery_peaks_stable"], found[PEAKS[2]]), *raw))
    name = f"{findings.world.id}-peaks-{event.time:g}"
    return Table(id=name, caption=f"Peaks within 2.5 s of {event.title}", columns=columns, rows=rows, name=name)


def rate_table(findings: Findings, resilience: Resilience) -> Table:
    """Return how the cost of the same change develops from event to event."""
    changes = list(dict.fromkeys(words for words, _ in resilience.rates))
    note = "slope of the logarithm of the integrated excess (Theil-Sen), for each further event; negative is better"
    columns = [Column(words, "1", note="" if place else note) for place, words in enumerate(changes)]
    rows = [
        (
            Cell(label, href=f"#{findings.runs_anchor(label)}", kind="head"),
            *(spread_cell(resilience.rates.get((words, label), Spread()), "", 3) for words in changes),
        )
        for label in findings.order
        if changes
    ]
    name = f"{findings.world.id}-improvement"
    caption = "Improvement from event to event, median over runs"
    return Table(id=name, caption=caption, columns=[controller_column(), *columns], rows=rows, name=name)


def unjudged_table(findings: Findings, resilience: Resilience) -> Table:
    """Return the events that the twins could not judge."""
    words = ("Controller / knowledge", "Trajectory", "Repetition", "Event", "Status")
    rows = [
        (
            Cell(run.row.controller, href=f"#{run.anchor}", kind="head"),
            *(Cell(text) for text in (run.row.trajectory, str(run.row.repetition), event.title, status)),
            Cell(reason, kind="wide"),
        )
        for run, event, status, reason in resilience.unjudged
    ]
    columns = [*(Column(word, numeric=False) for word in words), Column("Reason", numeric=False)]
    caption = "Events that could not be judged by twins"
    return Table(id=f"{findings.world.id}-unjudged", caption=caption, columns=columns, rows=rows)


def _explained(resilience: Resilience, event: Event, column: Column) -> bool:
    """Return whether a column has been explained below the table of an earlier event."""
    of_start = column.group in ("", CURVES) or column.text == "Raw peak"
    return event != resilience.events[0 if of_start else 1]


def _head(findings: Findings, label: str) -> Sequence[Cell]:
    runs = findings.runs_of(label)
    failed, ran = (sum(run.row.status in words for run in runs) for words in (("failed",), ("ok", "failed")))
    head = Cell(label, href=f"#{findings.runs_anchor(label)}", kind="head")
    share = failed / ran if ran else None
    return head, Cell(f"{failed} / {ran}", share, kind="bad" if failed else "")


def _stable(stable: Spread, counted: Spread) -> Cell:
    """Say whether the count means anything, run by run."""
    runs = len(stable.values) + stable.others.get("undefined", 0)
    if not counted.values or not runs:
        return Cell("\N{EMPTY SET} not counted", kind="missing")
    if len(stable.values) == runs:
        return Cell("\N{CHECK MARK} stable", kind="good")
    return Cell(f"\N{BALLOT X} unstable in {runs - len(stable.values)} of {runs}", kind="bad")


def _caption(event: Event) -> str:
    """Return what a table shows."""
    over = "median over runs" if event.window else "median over seeds, from the mean curves: a start has no twin"
    return f"{event.title}: {over}"
