"""Tables of efficiency: counts, estimates, the host's time and mechanical energy, each alone."""

from collections.abc import Callable, Sequence

from ..energy import energy_table
from ..metrics import METRICS
from ..summary import summary
from .cells import controller_column, why_none
from .efficiency import Computing, Efficiency
from .findings import POSITION, WINDOW, Findings
from .numbers import capitalised, significant, unit_on_page
from .table import Cell, Column, Reading, Table, columns_to_rows, head_cells, number_cells, word_cell

MEGA, KILO = 1e-6, 1e-3
DEFINED, DONE, LEARNING, MEMORY = "Synaptic, as defined", "As carried out", "Learning", "Memory"
COUNTED: tuple[tuple[str, str, str, str], ...] = (
    ("dense", "Dense", DEFINED, "every weight of a network at every step (NeuroBench); laws have no synapses"),
    ("effective_macs", "MAC", DEFINED, "of them products of non-zero weight and non-zero analogue input"),
    ("effective_acs", "AC", DEFINED, "of them weights added for a spike"),
    ("macs", "MAC", DONE, "multiply-accumulates of networks, solvers and matrix formulas as the code does them"),
    ("acs", "AC", DONE, ""),
    ("multiplications", "\N{MULTIPLICATION SIGN}", DONE, "outside of those"),
    ("additions", "\N{PLUS-MINUS SIGN}", DONE, "additions and subtractions outside of those"),
    ("divisions", "\N{DIVISION SIGN} \N{SQUARE ROOT}", DONE, ""),
    ("transcendentals", "sin, cos", DONE, "and other transcendental functions"),
    ("comparisons", "Comparisons", DONE, ""),
    ("membrane_updates", "Membranes", DONE, "neuron-steps that moved a potential"),
    ("random_draws", "Draws", DONE, ""),
    ("arithmetic", "All", DONE, "a MAC as two, everything else as one; learning apart"),
    ("learning_macs", "MAC", LEARNING, "backward passes and online updates, as the code does them"),
    ("parameter_updates", "Parameters moved", LEARNING, ""),
)
"""Count, its column, the header that it shares, and what a reader must know."""
MEASURED_NOTE = "over the cells of the ranking; empty where runs of these are missing"
MECHANICAL = ("energy_positive", "energy_net", "energy_abs", "energy_per_path", "effort_torque_sq")
"""Metrics of mechanical energy and effort that are shown where they are registered."""


def count_table(findings: Findings, efficiency: Efficiency) -> Table:
    """Return the operations of every controller: facts, no energy."""
    bytes_each = energy_table().bytes_per_number
    columns = [controller_column()]
    cells = [_heads(findings, efficiency)]
    for name, text, group, note in COUNTED:
        columns.append(Column(text, "10\N{SUPERSCRIPT SIX}/s", group=group, note=note))
        cells.append(_scaled(efficiency, _counted(name)))
    kept: tuple[tuple[str, str, Callable[[Computing], float]], ...] = (
        ("Parameters", "kB", lambda found: KILO * bytes_each * found.costs.parameters),
        ("State", "kB", lambda found: KILO * bytes_each * found.costs.state),
        ("Touched", "MB/s", lambda found: MEGA * bytes_each * found.counts.touched),
    )
    notes = (f"at {bytes_each} bytes a number for everybody", "", "weights, constants, inputs, outputs, states")
    for (text, unit, read), note in zip(kept, notes, strict=True):
        columns.append(Column(text, unit, group=MEMORY, note=note))
        cells.append(_scaled(efficiency, read))
    columns.append(Column("How counted", numeric=False))
    cells.append([Cell(found.costs.how, kind="wide") for found in efficiency.found.values()])
    return _table(findings, "counts", "Operations for a second of simulated time", columns, cells)


def estimate_table(findings: Findings, efficiency: Efficiency) -> Table:
    """Return the estimates beside the error that they buy; nothing in it but the error was measured."""
    shown = unit_on_page(METRICS[POSITION].unit)
    labels = list(efficiency.found)
    readings = [Reading(efficiency.errors.get(label), "undefined") for label in labels]
    front = [_front(label, efficiency) for label in labels]
    columns = [
        controller_column(),
        Column("Number", note="in the figures"),
        Column("Position error", shown.text, group="Measured", note=MEASURED_NOTE),
        Column("Inference", "\N{MICRO SIGN}W", group="Estimate, arithmetic"),
        Column("Learning", "\N{MICRO SIGN}W", group="Estimate, arithmetic"),
        Column("Both", "\N{MICRO SIGN}W", group="Estimate, arithmetic"),
        Column("Memory", numeric=False, group="Estimate, with memory", note="the smallest that holds what is kept"),
        Column("Arithmetic and traffic", "\N{MICRO SIGN}W", group="Estimate, with memory"),
        Column("On a front", numeric=False),
    ]
    cells = [
        _heads(findings, efficiency),
        [Cell(str(number), number) for number in range(1, len(labels) + 1)],
        number_cells(readings, METRICS[POSITION].unit),
        _scaled(efficiency, lambda found: found.estimate.inference),
        _scaled(efficiency, lambda found: found.estimate.learning),
        _scaled(efficiency, lambda found: found.estimate.arithmetic),
        [Cell(found.estimate.level) for found in efficiency.found.values()],
        _scaled(efficiency, lambda found: found.estimate.with_memory),
        [Cell(word) for word in front],
    ]
    prices = energy_table()
    caption = f"Estimates, not measurements: counts at the prices of {prices.technology}, {prices.number}"
    return _table(findings, "estimates", caption, columns, cells)


def host_table(findings: Findings, machines: Sequence[str]) -> Table:
    """Return the time that the controllers' calls took on the machine that ran them.

    Args:
        findings: The world's findings.
        machines: Those of the campaigns, in words.
    """
    labels = [label for label in findings.order if findings.timing(label, "call_us_median") is not None]
    shares = [_time_share(findings, label) for label in labels]
    medians = [findings.timing(label, "call_us_median") for label in labels]
    columns = [
        controller_column(),
        Column("Time", "ms/s", note="of all calls, knowledge of the load included, for a second of simulated time"),
        Column("Median call", "\N{MICRO SIGN}s"),
    ]
    cells = [
        head_cells(labels, (f"#{findings.runs_anchor(label)}" for label in labels)),
        [word_cell("missing") if share is None else Cell(significant(1e3 * share), 1e3 * share) for share in shares],
        [Cell(significant(value or 0.0), value) for value in medians],
    ]
    where = "; ".join(machines) or "an unknown machine"
    return _table(findings, "host", f"Measured on the host, one thread: {where}", columns, cells)


def mechanical_table(findings: Findings) -> Table:
    """Return what moving the arm took, where its metrics are registered and were computed."""
    columns, cells = [controller_column()], [head_cells(findings.order)]
    for name in (name for name in MECHANICAL if name in METRICS):
        found = summary(findings.world.rows, name, WINDOW)
        readings = [Reading(found[label].mean, why_none(found[label])) for label in findings.order]
        if any(reading.value is not None for reading in readings):
            metric = METRICS[name]
            columns.append(Column(capitalised(metric.label), unit_on_page(metric.unit).text))
            cells.append(number_cells(readings, metric.unit))
    caption = "Mechanical energy at the joints, simulated; gears, motors and electronics have no losses here"
    return _table(findings, "mechanical", caption, columns, cells if len(columns) > 1 else [])


def _front(label: str, efficiency: Efficiency) -> str:
    if label not in efficiency.errors:
        return "not compared"
    words = ["arithmetic"] if label in efficiency.fronts[0] else []
    words += ["with memory"] if label in efficiency.fronts[1] else []
    return ", ".join(words) or "dominated"


def _time_share(findings: Findings, label: str) -> float | None:
    """Return the time of all calls over all simulated time: motions last differently long."""
    timings = [run.stored.result.timing for run in findings.runs_of(label)]
    noted = [(float(t["call_s"]), float(t["simulated_s"])) for t in timings if {"call_s", "simulated_s"} <= set(t)]
    simulated = sum(seconds for _, seconds in noted)
    return sum(called for called, _ in noted) / simulated if simulated > 0.0 else None


def _heads(findings: Findings, efficiency: Efficiency) -> list[Cell]:
    return head_cells(efficiency.found, (f"#{findings.runs_anchor(label)}" for label in efficiency.found))


def _counted(name: str) -> Callable[[Computing], float]:
    """Return what reads one count in millions a second."""
    return lambda found: MEGA * float(getattr(found.counts, name))


def _scaled(efficiency: Efficiency, read: Callable[[Computing], float]) -> list[Cell]:
    """Return a column of numbers of very different sizes, each with three digits."""
    values = [read(found) for found in efficiency.found.values()]
    return [Cell("0" if value == 0.0 else significant(value), value) for value in values]


def _table(
    findings: Findings, name: str, caption: str, columns: Sequence[Column], cells: Sequence[Sequence[Cell]]
) -> Table:
    identity = f"{findings.world.id}-{name}"
    return Table(id=identity, caption=caption, columns=columns, rows=columns_to_rows(cells), name=identity)
