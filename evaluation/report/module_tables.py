"""Tables of the modules: correlations of gains, spike rates, and operations in two ways of counting."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from .cells import controller_column
from .findings import Findings
from .modules import ALL_MODULES, LAYERS, MODULES, Gains, Modules
from .numbers import significant
from .spread import Spread, spread_cell
from .table import Cell, Column, Table

DEFINED, EXECUTED, LEARNING, BESIDE = "Forward, as defined", "Forward, as executed", "Learning", "Beside"
COUNTED = (
    ("effective_macs", "MAC", DEFINED),
    ("effective_acs", "AC", DEFINED),
    ("executed_macs", "MAC", EXECUTED),
    ("executed_acs", "AC", EXECUTED),
    ("learning_macs", "MAC, as defined", LEARNING),
    ("executed_learning_macs", "MAC, as executed", LEARNING),
    ("parameter_updates", "Parameter updates", LEARNING),
    ("membrane_updates", "Membrane updates", BESIDE),
    ("random_draws", "Random draws", BESIDE),
    ("other", "Other", BESIDE),
)
"""Count, its column, and the header that it shares."""
NOTES = {
    "effective_macs": "NeuroBench's definition: products of a non-zero weight and a non-zero analogue input, each step",
    "effective_acs": "the same where the input is spikes",
    "executed_macs": "what the kernels do: a constant input once a window, a linear readout once on its trace",
    "learning_macs": "backward passes as twice the dense forward count; outside NeuroBench's definitions",
}
MEGA = 1e-6


def correlation_table(findings: Findings, label: str, gains: Gains) -> Table:
    """Return how each joint's two gains move together, in three cuts of the same series."""
    columns = [
        Column("Joint", numeric=False),
        Column("Raw", note="the whole run at the controller's own updates, as the paper prints it"),
        Column("Less lap means", note="each lap less its own mean: two ramps correlate without any relation"),
        Column("Without first 3 s", note="what is left when the start-up is left out"),
    ]
    cuts = [gains.correlations[cut] for cut in ("raw", "laps", "late")]
    rows = [
        (Cell(str(joint + 1), kind="head"), *(spread_cell(cut[joint], "", 2) for cut in cuts))
        for joint in range(len(cuts[0]))
    ]
    place = findings.order.index(label) + 1
    runs = f"{gains.runs} {'run' if gains.runs == 1 else 'runs'}"
    variation = f"; stiffness varies by {significant(100 * gains.variation.median, 2)} % of its mean"
    return Table(
        id=f"{findings.world.id}-gains-{place}",
        caption=f"{label}: correlation of stiffness and damping, median of {runs}"
        + (variation if gains.variation.values else ""),
        columns=columns,
        rows=rows,
        name=f"{findings.world.id}-gain-correlation-{place}",
    )


def spike_table(findings: Findings, modules: Modules) -> Table:
    """Return how often the neurons of each layer fire."""
    layers = [name for name in LAYERS if any(name in found for found in modules.spikes.values())]
    note = "spikes by neuron and time step of a window, at the paper's layer sizes"
    columns = [controller_column(), *(Column(LAYERS[name][0], "%") for name in layers)]
    columns[1:2] = [Column(columns[1].text, "%", note=note)] if layers else []
    labels = [label for label in findings.order if modules.spikes.get(label)]
    rows = [(_head(findings, label), *(_rate(modules.spikes[label].get(name)) for name in layers)) for label in labels]
    name = f"{findings.world.id}-spikes"
    return Table(id=name, caption="Spike rates, median over runs", columns=columns, rows=rows, name=name)


def operation_table(findings: Findings, modules: Modules) -> Table:
    """Return the operations of every controller that counts them by module, over all of its modules."""
    rows = [
        (_head(findings, label), *_counts(modules.operations[label], ALL_MODULES))
        for label in findings.order
        if any(f"{ALL_MODULES}_{count}" in modules.operations.get(label, {}) for count, _, _ in COUNTED)
    ]
    return _operation_table(findings, "operations", "Operations, all modules together", controller_column(), rows)


def module_operation_table(findings: Findings, label: str, modules: Modules) -> Table:
    """Return the operations of one controller, module by module."""
    found = modules.operations[label]
    rows = [
        (Cell(module.replace("_", " ").capitalize(), kind="head"), *_counts(found, module))
        for module in MODULES
        if any(name.startswith(f"{module}_") for name in found)
    ]
    head = Column("Module", numeric=False)
    place = findings.order.index(label) + 1
    table = _operation_table(findings, f"operations-{place}", f"Operations of {label} by module", head, rows)
    # The table of all controllers above has explained them.
    return replace(table, columns=[replace(column, note="") for column in table.columns])


def _operation_table(
    findings: Findings, name: str, caption: str, head: Column, rows: Sequence[tuple[Cell, ...]]
) -> Table:
    unit = "10\N{SUPERSCRIPT SIX}/s"
    return Table(
        id=f"{findings.world.id}-{name}",
        caption=f"{caption}: counts by second of simulated time, no energy; median over runs",
        columns=[
            head,
            *(Column(text, unit, group=group, note=NOTES.get(count, "")) for count, text, group in COUNTED),
        ],
        rows=rows,
        name=f"{findings.world.id}-{name}",
    )


def _counts(found: Mapping[str, Spread], module: str) -> list[Cell]:
    """Return the counts of a module, or of all together, in millions a second."""
    cells = []
    for count, _, _ in COUNTED:
        spread = found.get(f"{module}_{count}")
        total = spread.median * MEGA if spread else 0.0
        text = "0" if total == 0.0 else significant(total) if total >= 1e-3 else "< 0.001"
        cells.append(Cell(text, total) if spread else Cell("\N{EMPTY SET} not counted", kind="missing"))
    return cells


def _rate(spread: Spread | None) -> Cell:
    """Return a spike rate; an ablation has no such layer."""
    return Cell("no layer", kind="missing") if spread is None else spread_cell(spread, "1", 1)


def _head(findings: Findings, label: str) -> Cell:
    return Cell(label, href=f"#{findings.runs_anchor(label)}", kind="head")
