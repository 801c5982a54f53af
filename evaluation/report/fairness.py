"""What each controller was told, and where its settings come from."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence

from ...controllers import discovery
from .findings import Findings
from .table import Cell, Column, Table
from .worlds import Run

LONGEST_VALUE = 90
"""Most characters of a setting's value in the table; summary.json has all of it."""


def knowledge_table(findings: Findings) -> Table:
    """Return what each knowledge level is told about the load."""
    levels: dict[str, list[str]] = {}
    for run in findings.world.runs:
        levels.setdefault(run.stored.specification.knowledge, []).append(run.row.controller)
    rows = [
        (
            Cell(level, kind="head"),
            Cell(_told(level), kind="wide"),
            Cell(", ".join(dict.fromkeys(sorted(labels))), kind="wide"),
        )
        for level, labels in sorted(levels.items())
    ]
    columns = [Column(word, numeric=False) for word in ("Knowledge", "What the model is told", "Rows")]
    return Table(
        id=f"{findings.world.id}-knowledge", caption="What each knowledge level is told; sensors are equal for all",
        columns=columns, rows=rows,
    )  # fmt: skip


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
        learnt = "; ".join(
            dict.fromkeys(str(entry["learnt_before"]) for entry in entries if entry.get("learnt_before"))
        )
        known = Cell(runs[0].stored.specification.knowledge)
        head = Cell(label, href=f"#{findings.runs_anchor(label)}", kind="head")
        rows.append((head, known, Cell(listed), Cell(str(trials), trials), Cell(learnt or "nothing", kind="wide")))
    return Table(
        id=f"{findings.world.id}-tuning",
        caption="What each row knew and how it was tuned",
        columns=[Column(word, numeric=word == "Trials") for word in words],
        rows=rows,
    )


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


def _told(level: str) -> str:
    """Return what a registered provider says of itself."""
    if level not in discovery.names("knowledge"):
        return "not registered here"
    try:
        provider = discovery.load("knowledge", level)
    except Exception as cause:
        return f"cannot be loaded here ({type(cause).__name__})"
    return (provider.__doc__ or "").strip().partition("\n")[0]
