"""What the page loads when a run is opened: its figures, the command that repeats it, and its trace, as a script."""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence

import numpy as np

from ...controllers import InvalidInput
from ...scenarios.store import Store
from ..metrics import METRICS
from .numbers import Unit, significant, unit_on_page
from .series import Series, quantised, thinned
from .table import WORDS
from .worlds import RUN, Run, World

FRAME = 0.02
"""Time between two pictures of the replay [s]."""
WINDOWS = ("run", "steady")
SHOWN = tuple((name, metric.label, unit_on_page(metric.unit)) for name, metric in METRICS.items())
"""Id, label and unit on the page of each metric."""
DRAWN = ("t", "q", "q_ref", "p", "p_ref", "quat", "quat_ref", "tau")


def file_name(run: Run) -> str:
    """Return the name of a run's script without its suffix: hexadecimal digits, whatever the run is called."""
    stored, result = run.stored, run.stored.result
    if result.role == RUN and stored.specification.repetitions == 1:
        return stored.address[:16]
    told_apart = hashlib.sha256(f"{result.role}\n{result.repetition}".encode()).hexdigest()
    return f"{stored.address[:16]}-{told_apart[:8]}"


def row_data(world: World, run: Run) -> dict[str, str]:
    """Return what the page's script has to know of a run's row: its file, its cell, its controller."""
    row, result = run.row, run.stored.result
    cell = (world.id, row.trajectory, run.load, str(row.repetition), result.role, run.stored.specification.study)
    return {"run": file_name(run), "cell": "|".join(cell), "label": row.controller}


def run_script(run: Run, store: Store) -> str:
    """Return the script of one run; it puts one record into the page's ``torquebench.runs``.

    Args:
        run: The run.
        store: The open store that it comes from.
    """
    text = json.dumps(_record(run, store), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return f'torquebench.runs["{file_name(run)}"]={text};\n'


def robot_key(run: Run) -> str:
    """Return what the page calls the skeleton of a run's arm."""
    return json.dumps([run.stored.specification.robot, run.stored.specification.tool])


def _record(run: Run, store: Store) -> dict[str, object]:
    stored, result = run.stored, run.stored.result
    return {
        "label": run.row.controller,
        "cell": [run.row.trajectory, run.load, run.row.repetition, result.role],
        "status": result.status,
        "reason": result.reason,
        "address": stored.address,
        "command": stored.command,
        "robot": robot_key(run),
        "events": _events(run),
        "metrics": _metric_rows(result.metrics),
        "timing": {name: _finite(value) for name, value in result.timing.items()},
        "trace": _trace(run, store),
    }


def _events(run: Run) -> list[tuple[float, str]]:
    """Return time and new load of each change; a twin has a load history of its own, which its name tells."""
    if run.stored.result.role != RUN:
        return []
    return [(time, f"{load.mass:g} kg") for time, load in run.stored.specification.schedule.entries[1:]]


def _finite(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _metric_rows(metrics: Mapping[str, Mapping[str, Mapping[str, object]]]) -> list[list[str]]:
    """Return label, unit and the text of each window for every metric that was computed, in the registry's order."""
    stored = [metrics.get(window, {}) for window in WINDOWS]
    rows = []
    for name, label, unit in SHOWN:
        entries = [found.get(name) for found in stored]
        if any(entry is not None for entry in entries):
            rows.append([label, "" if unit.text == "1" else unit.text, *(_text(entry, unit) for entry in entries)])
    return rows


def _text(entry: Mapping[str, object] | None, unit: Unit) -> str:
    if entry is None:
        return ""
    value = _finite(entry.get("value"))
    status = str(entry.get("status", "undefined"))
    return WORDS.get(status, status) if value is None else significant(unit.of(value))


def _trace(run: Run, store: Store) -> dict[str, object] | None:
    """Return what is drawn of a run's trace; None if none was kept, or it is missing or damaged."""
    if not run.stored.trace:
        return None
    try:
        trace = store.trace(run.stored.trace, DRAWN)
        return _drawn({name: trace[name].astype(float) for name in DRAWN})
    except (InvalidInput, KeyError, ValueError, IndexError):
        # A trace that cannot be read costs its drawing, not the page.
        return None


def _drawn(trace: Mapping[str, np.ndarray]) -> dict[str, object]:
    t = trace["t"]
    if len(t) < 2:
        raise ValueError("one sample is no curve")
    dt = float(np.round((t[-1] - t[0]) / (len(t) - 1), 9))
    stride = max(1, round(FRAME / dt))
    return {
        "start": float(np.round(t[0], 6)),
        "dt": dt,
        "samples": len(t),
        "frame": stride * dt,
        "q": [quantised(column) for column in trace["q"][::stride].T],
        "q_ref": [quantised(column) for column in trace["q_ref"][::stride].T],
        "position": _curve(1e3 * np.linalg.norm(trace["p"] - trace["p_ref"], axis=1)),
        "orientation": _curve(1e3 * _angles(trace["quat"], trace["quat_ref"])),
        "joints": _curve(1e3 * np.linalg.norm(trace["q"] - trace["q_ref"], axis=1)),
        "torque": [_curve(column) for column in trace["tau"].T],
    }


def _curve(values: np.ndarray) -> Series:
    """Return a series for a plot, and how many samples of the trace two of its own stand for."""
    kept, part = thinned(values)
    return {**quantised(kept), "part": part}


def _angles(actual: np.ndarray, planned: np.ndarray) -> np.ndarray:
    """Return the angles between attitudes, xyzw, shape (K, 4) each [rad]; small ones survive single precision."""
    vector = actual[:, 3:] * -planned[:, :3] + planned[:, 3:] * actual[:, :3] - np.cross(planned[:, :3], actual[:, :3])
    scalar = np.sum(actual * planned, axis=1)
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(vector, axis=1), np.abs(scalar)))


def all_runs(worlds: Sequence[World]) -> list[Run]:
    """Return every row of the store that the page lists, twins too."""
    return [run for world in worlds for run in (*world.runs, *world.twins)]
