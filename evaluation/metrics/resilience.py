"""Load events: a run is judged against twins that share every draw and differ in the load alone."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import excess, peaks, recovery
from .curves import row_at
from .geometry import distances
from .registry import Metric, Value, metric

FAMILIES = (recovery, excess, peaks)

EVENT_METRICS: dict[str, Metric[...]] = {
    found.id: found
    for family in FAMILIES
    for found in vars(family).values()
    if isinstance(found, Metric) and found.function.__module__ == family.__name__
}
"""Every metric of a run with its twins by id, in the order of tables."""


@dataclass(frozen=True)
class EventTwins:
    """A load event with the two runs that it is judged against.

    Attributes:
        time: When the load changes, on the log's clock [s].
        until: Time of the next event, or where the run ends [s]; may be infinite.
        mass_change: New load less old load [kg].
        old: Log of the run in which the event never happens; None if there is none.
        new: Log of the run that carries the new load from the start; None if there is none.
        reason: Why a log is missing.
    """

    time: float
    until: float
    mass_change: float
    old: object | None
    new: object | None
    reason: str = ""

    @property
    def window(self) -> str:
        """The name of the window that the event's metrics are stored under."""
        return f"event@{self.time:g}"


def evaluate_events(log: object, events: Iterable[EventTwins]) -> dict[str, dict[str, Value]]:
    """Compute the metrics of a run with its twins.

    Args:
        log: The run with its events: any object with ``t``, ``dt``, ``lap``, ``q``, ``q_ref`` and, for the metrics of
            the tool point, ``p``, ``p_ref``.
        events: Its events, each with its twins' logs.

    Returns:
        Window to metric id to value. Without both twins every metric of the event is ``undefined``; if the run
        differs from the old load's twin before the event, every one is ``failed``: a seed leaked or a state is hidden.

    Raises:
        UnequalLengths: If a twin has another number of ticks.
    """
    own = _errors(log, "")
    return {event.window: _evaluate(log, own, event) for event in events}


def _evaluate(log: object, own: Mapping[str, np.ndarray], event: EventTwins) -> dict[str, Value]:
    if event.old is None or event.new is None:
        return _all("undefined", event.reason or "a twin is missing")
    curves = {**own, **_errors(event.old, "_old"), **_errors(event.new, "_new")}
    dt = float(log.dt)  # type: ignore[attr-defined]
    for name in own:
        before = row_at(event.time, dt, len(own[name]))
        if not np.array_equal(own[name][:before], curves[f"{name}_old"][:before]):
            return _all("failed", "the run differs from its twin before the event")
    fields: dict[str, Any] = {
        **curves,
        "event": event.time,
        "until": event.until,
        "mass_change": event.mass_change,
        "lap": math.inf if getattr(log, "lap", None) is None else log.lap,  # type: ignore[attr-defined]
        "dt": dt,
    }
    return {m.id: m.value_of(fields) for m in EVENT_METRICS.values() if all(name in fields for name in m.needs)}


def _errors(log: Any, suffix: str) -> dict[str, np.ndarray]:
    """Return the error norms of a log from time 0 on, by the names that metrics know them by."""
    scored = np.asarray(log.t) >= -0.5 * log.dt
    pairs = {"error": ("q", "q_ref"), "position_error": ("p", "p_ref")}
    return {
        f"{name}{suffix}": distances(
            np.asarray(getattr(log, actual), dtype=float)[scored], np.asarray(getattr(log, plan), dtype=float)[scored]
        )
        for name, (actual, plan) in pairs.items()
        if getattr(log, actual, None) is not None and getattr(log, plan, None) is not None
    }


def _all(status: Any, reason: str) -> dict[str, Value]:
    return {m.id: Value(math.nan, m.unit, status, 0, reason) for m in EVENT_METRICS.values()}


@metric(
    unit="1",
    better="higher",
    family="resilience",
    needs=("q", "q_ref", "lower", "upper"),
    source="1 if no joint passed a limit and the joint error norm stayed below 1 rad",
    label="success",
    fail_value=0.0,
)
def success(q: np.ndarray, q_ref: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """Whether an arm stayed within its limits and near its plan throughout.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions of the same ticks, shape (N, n) [rad].
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].

    Returns:
        1 or 0 [1]; NaN if any sample is not finite, which counts as 0.

    Raises:
        EmptyWindow: If there is no sample.
    """
    within = bool(((q >= lower) & (q <= upper)).all())
    return float(within and distances(q, q_ref).max() < 1.0)
