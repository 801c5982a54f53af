"""The command line that repeats a run: its specification written out as changes of a benchmark that ships."""

import json
import re
import shlex
from collections.abc import Mapping, Sequence

from ..controllers import discovery
from .loads import NO_MATERIAL, LoadSchedule, Payload
from .specification import CARRIED, RunSpecification

BASE = "quick"
"""A benchmark without run tables: each of its keys can be replaced."""


def repeating_command(run: RunSpecification) -> str:
    """Return the shell command that repeats a run, empty if there is none.

    It names everything that a specification holds, so with the same code the run gets the same address. Of repeated
    cells it also runs the repetitions before; a controller that was a Python object has no name to give.

    Args:
        run: The run.
    """
    if ":" not in run.controller and run.controller not in discovery.names("controllers"):
        return ""
    if "null" in json.dumps(run.settings):
        # TOML has no word for nothing.
        return ""
    load = "schedule" if run.schedule.events else "loads"
    changes: dict[str, object] = {
        "controllers": [run.controller],
        "knowledge": [run.knowledge],
        "settings": {run.controller: dict(run.settings)} if run.settings else {},
        "trajectories": [run.trajectory],
        load: _loads(run.schedule),
        "twins": run.twins,
        "laps": run.laps,
        "lead_in": run.lead_in,
        "repetitions": run.repetitions if run.protocol == CARRIED else run.repetition + 1,
        "protocol": run.protocol,
        "perturbation": run.perturbation.as_table(),
        "studies": [run.study] if run.study else [],
        "robot": run.robot,
        "tool": run.tool,
        "plant": run.plant,
        "tier": run.tier,
        "latency": run.latency,
        "tare": run.tare,
        "seed": run.campaign,
        "draws": run.draws,
    }
    said = (f"{key}={_toml(value)}" for key, value in changes.items() if not _is_left_out(value))
    return " ".join([f"torquebench run {BASE}", *(f"--set {shlex.quote(text)}" for text in said)])


def _loads(schedule: LoadSchedule) -> list[dict[str, object]]:
    """Return the load history as a benchmark has it: a constant load has no time."""
    if not schedule.events:
        return [_load(schedule.entries[0][1])]
    return [{"at": time, **_load(load)} for time, load in schedule.entries]


def _load(load: Payload) -> dict[str, object]:
    return {"mass": load.mass} if load.material == NO_MATERIAL else {"mass": load.mass, "material": load.material}


def _is_left_out(value: object) -> bool:
    """Return whether a value says what the benchmark says already: empty tables and lists, and False."""
    return value is False or value in ("", [], {})


def _toml(value: object) -> str:
    """Return a value as inline TOML; its strings are those of JSON, escapes included."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(str(key))} = {_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    # JSON in ASCII writes some letters in halves that TOML does not know, and TOML wants DEL escaped.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _toml(name)
