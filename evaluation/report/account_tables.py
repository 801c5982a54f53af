"""Tables that account for the result: comparisons, failures, fairness, definitions, provenance, runs."""

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence

from ...controllers import discovery
from ..comparison import Comparison
from ..intervals import Interval
from ..metrics import METRICS
from .findings import COMPARED, ORIENTATION, POSITION, SUMMARISED, WINDOW, Findings
from .numbers import p_value, ratio_text, unit_on_page
from .table import Cell, Column, Table, columns_to_rows, number_cells, stored_reading
from .tracking_tables import verdict_cell
from .worlds import Run

LONGEST_VALUE = 90
"""Most characters of a setting's value in the table; summary.json has all of it."""


def comparison_table(findings: Findings) -> Table:
    """Return every comparison with the reference, with what is known of its certainty."""
    ratio = "95 % interval of the ratio"
    columns = [
        Column("Metric", numeric=False),
        Column("Controller / knowledge", numeric=False),
        Column("Ratio", note="geometric mean over trajectories of controller / reference; below it the t interval over trajectories"),
        Column("this suite", group=ratio, note="over repetitions, trajectories fixed"),
        Column("bootstrap", group=ratio, note="BCa over trajectories; narrower than it should be with few of them"),
        Column("Ratio of means", note="the paper's percentage; large errors dominate it"),
        Column("P(better)", note="probability that a run beats a run of the reference"),
        Column("p", note="exact sign-flip test over trajectories"),
        Column("p, Holm", note="corrected for all opponents of the reference"),
        Column("Trajectories"),
        Column("Pairs"),
        Column("Verdict alone", numeric=False, note="as if it had been the only comparison asked for"),
        Column("Verdict in family", numeric=False, note="corrected for all opponents on this metric"),
        Column("Remarks", numeric=False),
    ]
    rows = [
        _comparison_row(findings, comparison)
        for metric in COMPARED
        for label in findings.order
        if (comparison := findings.comparisons[metric].get(label)) is not None
    ]
    caption = f"Each controller against {findings.world.reference}, runs paired by trajectory, load and repetition"
    return Table(id=f"{findings.world.id}-pairs", caption=caption, columns=columns, rows=rows, name=f"{findings.world.id}-pairs")


def failure_table(findings: Findings) -> Table:
    """Return what failed or was refused, when and why."""
    words = ("Controller / knowledge", "Trajectory", "Load", "Repetition", "Status", "When", "Cause", "Reason")
    rows = []
    for run in findings.failures:
        result = run.stored.result
        when = "before the start" if result.failed_at is None else f"{result.failed_at:.3f} s"
        texts = (run.row.trajectory, run.load, str(run.row.repetition), result.status, when, result.cause)
        head = Cell(run.row.controller, href=f"#{run.anchor}", kind="head")
        rows.append((head, *(Cell(text) for text in texts), Cell(result.reason, kind="wide")))
    return Table(
        id=f"{findings.world.id}-failed",
        caption="Runs that failed or were refused",
        columns=[Column(word, numeric=False) for word in words],
        rows=rows,
        name=f"{findings.world.id}-failed",
    )


def knowledge_table(findings: Findings) -> Table:
    """Return what each knowledge level is told about the load."""
    levels: dict[str, list[str]] = {}
    for run in findings.world.runs:
        levels.setdefault(run.stored.specification.knowledge, []).append(run.row.controller)
    rows = [
        (Cell(level, kind="head"), Cell(_told(level), kind="wide"), Cell(", ".join(dict.fromkeys(sorted(labels))), kind="wide"))
        for level, labels in sorted(levels.items())
    ]
    columns = [Column(word, numeric=False) for word in ("Knowledge", "What the model is told", "Rows")]
    return Table(
        id=f"{findings.world.id}-knowledge", caption="What each knowledge level is told; sensors are equal for all",
        columns=columns, rows=rows,
    )  # fmt: skip


def ledger_table(findings: Findings) -> Table:
    """Return where every setting of every controller comes from."""
    words = ("Controller / knowledge", "Setting", "Value", "Source", "Trials", "Learnt before the run", "Note")
    rows = []
    for label in findings.order:
        for entry, values in ledger_of(findings.runs_of(label)):
            value = values[0] if len(values) == 1 else f"{len(values)} values, one for each task"
            short = value if len(value) <= LONGEST_VALUE else f"{value[:LONGEST_VALUE]} ..."
            trials = entry.get("trials", 0)
            texts = (str(entry.get("setting", "")), short, str(entry.get("source", "")), str(trials))
            learnt = str(entry.get("learnt_before") or "nothing")
            note = Cell(str(entry.get("note", "")), kind="wide")
            rows.append((Cell(label, kind="head"), *(Cell(text) for text in texts), Cell(learnt), note))
    return Table(
        id=f"{findings.world.id}-ledger",
        caption="Where the settings come from, as each controller declares it",
        columns=[Column(word, numeric=word == "Trials") for word in words],
        rows=rows,
        name=f"{findings.world.id}-ledger",
    )


def tuning_table(findings: Findings) -> Table:
    """Return for each controller how many of its settings come from where, and what the searches spent."""
    words = ("Controller / knowledge", "Knowledge", "Settings by source", "Trials", "Learnt before the run")
    rows = []
    for label in findings.order:
        runs = findings.runs_of(label)
        entries = [entry for entry, _ in ledger_of(runs)]
        sources = Counter(str(entry.get("source", "not given")) for entry in entries)
        listed = ", ".join(f"{count} {source}" for source, count in sorted(sources.items())) or "none declared"
        trials = sum(int(str(entry.get("trials") or 0)) for entry in entries)
        learnt = "; ".join(dict.fromkeys(str(entry["learnt_before"]) for entry in entries if entry.get("learnt_before")))
        known = Cell(runs[0].stored.specification.knowledge)
        head = Cell(label, href=f"#{findings.runs_anchor(label)}", kind="head")
        rows.append((head, known, Cell(listed), Cell(str(trials), trials), Cell(learnt or "nothing", kind="wide")))
    return Table(
        id=f"{findings.world.id}-tuning",
        caption="What each row knew and how it was tuned",
        columns=[Column(word, numeric=word == "Trials") for word in words],
        rows=rows,
    )


def ledger_of(runs: Sequence[Run]) -> list[tuple[Mapping[str, object], list[str]]]:
    """Return the ledger of a controller: each entry once, with its distinct values over the runs."""
    found: dict[str, tuple[Mapping[str, object], list[str]]] = {}
    for run in runs:
        for entry in run.stored.result.ledger:
            identity = json.dumps({key: value for key, value in entry.items() if key != "value"}, sort_keys=True)
            _, values = found.setdefault(identity, (entry, []))
            value = entry.get("value")
            text = value if isinstance(value, str) else json.dumps(value)
            if text not in values:
                values.append(text)
    return list(found.values())


def run_table(findings: Findings, label: str) -> Table:
    """Return the runs of one controller."""
    runs = findings.runs_of(label)
    cells = [
        [Cell(run.row.trajectory, kind="head") for run in runs],
        [Cell(f"{run.row.mass:g}", run.row.mass) for run in runs],
        [Cell(run.row.material or "none") for run in runs],
        [Cell(str(run.row.repetition), run.row.repetition) for run in runs],
        [Cell(run.row.status, kind="" if run.row.status == "ok" else "bad") for run in runs],
        *(_run_cells(runs, metric) for metric in (POSITION, ORIENTATION)),
        [Cell(run.stored.address[:12], kind="") for run in runs],
    ]
    mm, mrad = (unit_on_page(METRICS[metric].unit).text for metric in (POSITION, ORIENTATION))
    columns = [
        Column("Trajectory", numeric=False), Column("Mass", "kg"), Column("Material", numeric=False),
        Column("Repetition"), Column("Status", numeric=False), Column("Position", mm), Column("Orientation", mrad),
        Column("Address", numeric=False),
    ]  # fmt: skip
    return Table(
        id=findings.runs_anchor(label),
        caption=f"Runs of {label}",
        columns=columns,
        rows=columns_to_rows(cells),
        row_ids=[run.anchor for run in runs],
    )


def twin_table(findings: Findings) -> Table:
    """Return the twins: they judge events and enter no comparison."""
    words = ("Controller / knowledge", "Trajectory", "Twin", "Status", "Address")
    rows = [
        tuple(Cell(text) for text in (
            twin.row.controller, twin.row.trajectory, twin.stored.result.role, twin.row.status, twin.stored.address[:12],
        ))
        for twin in findings.world.twins
    ]  # fmt: skip
    columns = [Column(word, numeric=False) for word in words]
    return Table(id=f"{findings.world.id}-twins", caption="Twins, in no comparison", columns=columns, rows=rows)


def definition_table() -> Table:
    """Return the definition of every metric that the page uses, from the registry."""
    columns = [Column(word, numeric=False) for word in ("Id", "Name", "Unit", "Better", "Counts as, if failed", "Source", "Definition")]
    rows = []
    for name in SUMMARISED:
        metric = METRICS[name]
        failed = "left out" if metric.fail_value is None else f"{metric.fail_value:.3g} {metric.unit}"
        first_line = re.sub(r":\w+:`([^`]*)`", r"\1", (metric.__doc__ or "").strip().partition("\n")[0])
        texts = (metric.label, metric.unit, metric.better, failed, metric.source)
        rows.append((Cell(name, kind="head"), *(Cell(text) for text in texts), Cell(first_line, kind="wide")))
    return Table(id="definitions-table", caption="Metrics on this page, in stored units", columns=columns, rows=rows)


def gate_table(number: int, gate: object) -> Table:
    """Return the checks that a plant had to pass before the campaign."""
    checks = [check for check in gate if isinstance(check, Mapping)] if isinstance(gate, list) else []
    rows = []
    for check in checks:
        passed = bool(check.get("passed"))
        figures = (_plain(check.get("deviation")), _plain(check.get("allowed")))
        mark = Cell("\N{CHECK MARK} passed" if passed else "\N{BALLOT X} failed", kind="good" if passed else "bad")
        rows.append((Cell(str(check.get("name", "")), kind="head"), Cell(str(check.get("plant", ""))), *figures, mark))
    columns = [
        Column("Check", numeric=False), Column("Plant", numeric=False), Column("Deviation"), Column("Allowed"),
        Column("Result", numeric=False),
    ]  # fmt: skip
    return Table(id=f"gate-{number}", caption="Physics gate before the campaign", columns=columns, rows=rows)


def _comparison_row(findings: Findings, comparison: Comparison) -> tuple[Cell, ...]:
    label = METRICS[comparison.metric].label
    alone = findings.verdict_alone(comparison)
    holm = comparison.p_holm
    return (
        Cell(label),
        Cell(comparison.controller, href=f"#{findings.runs_anchor(comparison.controller)}", kind="head"),
        verdict_cell(comparison, alone),
        _interval_cell(comparison.interval_suite, "one repetition: none"),
        _interval_cell(comparison.bca, "below five trajectories: none"),
        Cell(ratio_text(comparison.ratio_of_means), comparison.ratio_of_means),
        Cell(f"{comparison.prob_improvement:.2f}", comparison.prob_improvement),
        Cell(p_value(comparison.p_sign_flip), comparison.p_sign_flip),
        Cell("none" if holm is None else p_value(holm), holm),
        Cell(str(comparison.n_trajectories), comparison.n_trajectories),
        Cell(str(comparison.n_pairs), comparison.n_pairs),
        Cell(alone),
        Cell(comparison.verdict),
        Cell("; ".join(comparison.remarks), kind="wide"),
    )


def _interval_cell(interval: Interval | None, none: str) -> Cell:
    if interval is None:
        return Cell(none, kind="missing")
    note = "degenerate" if interval.status == "degenerate" else ""
    return Cell(f"{ratio_text(interval.low)} to {ratio_text(interval.high)}", interval.low, note=note)


def _run_cells(runs: Sequence[Run], metric: str) -> list[Cell]:
    readings = [stored_reading(run.row.metrics, WINDOW, metric) for run in runs]
    cells = number_cells(readings, METRICS[metric].unit)
    return [
        cell if run.row.status == "ok" else Cell(f"\N{EMPTY SET} {run.row.status}", kind="missing")
        for run, cell in zip(runs, cells, strict=True)
    ]


def _told(level: str) -> str:
    """Return what a registered provider says of itself."""
    if level not in discovery.names("knowledge"):
        return "not registered here"
    try:
        provider = discovery.load("knowledge", level)
    except Exception as cause:
        return f"cannot be loaded here ({type(cause).__name__})"
    return (provider.__doc__ or "").strip().partition("\n")[0]


def _plain(value: object) -> Cell:
    if not isinstance(value, int | float):
        return Cell("not given", kind="missing")
    return Cell(f"{value:.2g}", float(value))
