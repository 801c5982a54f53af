"""From a log to its metrics, window by window."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..errors import UnknownMetric, UnknownWindow
from .builtin import METRICS
from .laps import lap_bounds
from .registry import CONSTANTS, Metric, Value
from .shared import sharing

WINDOWS = ("run", "steady")
"""``run``: all whole laps from time 0, the end of the lead-in; ``steady``: from the second lap on."""


def window_rows(t: np.ndarray, window: str, dt: float, lap: float | None) -> slice:
    """Return the rows of a log that belong to a window.

    Args:
        t: Time since the end of the lead-in, shape (N,) [s]; negative in the lead-in.
        window: ``"run"`` or ``"steady"``.
        dt: Control period [s].
        lap: Duration of one lap [s]; None or infinite for a motion that is no cycle, whose run is everything from 0
            and which has no steady window.

    Returns:
        A slice, empty if the log does not reach into the window.

    Raises:
        UnknownWindow: If the window has no definition.
    """
    if window not in WINDOWS:
        raise UnknownWindow(window, WINDOWS)
    # Half a tick of grace: a clock that sums its period may put tick 0 a rounding error before 0.
    start = int(np.searchsorted(t, -0.5 * dt))
    if lap is None or not math.isfinite(lap):
        return slice(start, len(t) if window == "run" else start)
    bounds = start + lap_bounds(len(t) - start, lap, dt)
    return slice(bounds[0] if window == "run" else bounds[min(1, len(bounds) - 1)], bounds[-1])


def evaluate(
    log: object,
    ids: Iterable[str] | None = None,
    windows: Iterable[str] = WINDOWS,
    metrics: Mapping[str, Metric[...]] = METRICS,
) -> dict[str, dict[str, Value]]:
    """Compute metrics of a log.

    A metric whose fields the log does not have, or has as None, is left out, see :func:`missing_fields`; so is one of
    several runs or of a run with its twins, and a window without a sample.

    Args:
        log: Any object with attributes of the contract's field names: ``t``, ``dt``, and what the metrics need.
        ids: Which metrics of a log; all that are possible if None.
        windows: Which windows; see :data:`WINDOWS`.
        metrics: The metrics by id; a program with plug-ins passes its own table.

    Returns:
        Window to metric id to value, in the order asked for.

    Raises:
        UnknownMetric: If an id is not in ``metrics``.
        UnknownWindow: If a window has no definition.
        UnequalLengths: If fields of the log hold different numbers of ticks.
    """
    asked = list(metrics.values()) if ids is None else [_lookup(name, metrics) for name in ids]
    chosen = [m for m in asked if m.kind == "log"]
    fields = _fields(log, chosen)
    possible = [m for m in chosen if all(name in fields for name in m.needs)]
    dt, lap = float(log.dt), getattr(log, "lap", None)  # type: ignore[attr-defined]
    t = np.asarray(log.t)  # type: ignore[attr-defined]
    run = window_rows(t, "run", dt, lap)
    whole = {name: field[run] if _is_series(name, field) else field for name, field in fields.items()}
    result = {}
    with sharing() as memory:
        for window in windows:
            rows = window_rows(t, window, dt, lap)
            if rows.stop > rows.start:
                part = slice(rows.start - run.start, rows.stop - run.start)
                cut = {name: memory.part(f, part) if _is_series(name, f) else f for name, f in whole.items()}
                result[window] = {m.id: m.value_of(cut) for m in possible}
    return result


def missing_fields(
    log: object, ids: Iterable[str] | None = None, metrics: Mapping[str, Metric[...]] = METRICS
) -> dict[str, tuple[str, ...]]:
    """Return the metrics of a log that :func:`evaluate` leaves out, with the fields that they lack.

    Args:
        log: As for :func:`evaluate`.
        ids: Which metrics; all if None.
        metrics: The metrics by id.

    Raises:
        UnknownMetric: If an id is not in ``metrics``.
    """
    asked = list(metrics.values()) if ids is None else [_lookup(name, metrics) for name in ids]
    lacking = {m.id: tuple(name for name in m.needs if getattr(log, name, None) is None) for m in asked}
    return {m.id: lacking[m.id] for m in asked if m.kind == "log" and lacking[m.id]}


def _lookup(name: str, metrics: Mapping[str, Metric[...]]) -> Metric[...]:
    if name not in metrics:
        raise UnknownMetric(name, list(metrics))
    return metrics[name]


def _fields(log: object, chosen: Iterable[Metric[...]]) -> dict[str, Any]:
    """Return the fields that the metrics need and the log has; arrays once as floats, so that results are shared."""
    names = dict.fromkeys(name for m in chosen for name in m.needs)
    found = {name: getattr(log, name, None) for name in names}
    return {name: np.asarray(f, dtype=float) if np.ndim(f) else f for name, f in found.items() if f is not None}


def _is_series(name: str, field: Any) -> bool:
    return name not in CONSTANTS and np.ndim(field) > 0
