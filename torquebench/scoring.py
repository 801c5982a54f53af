"""Joins harness and metrics: scores a log in the worker, at full rate."""

import math
from collections.abc import Sequence

from .evaluation.metrics import (
    WARM_UP,
    EventTwins,
    error_by_lap,
    evaluate,
    evaluate_events,
    orientation_error_by_lap,
)
from .plug_in_metrics import all_metrics
from .scenarios.events import EventScores, LoadEvent
from .scenarios.log import RunLog
from .scenarios.result import Scores


def score(log: RunLog) -> Scores:
    """Return all metrics of a log by window, those of plug-ins too, the errors of each whole lap, and call times.

    Args:
        log: A finished run.
    """
    values = evaluate(log, metrics=all_metrics())
    scored = log.t >= -0.5 * log.dt
    position = error_by_lap(log.p[scored], log.p_ref[scored], log.lap, log.dt)
    orientation = orientation_error_by_lap(log.quat[scored], log.quat_ref[scored], log.lap, log.dt)
    return Scores(
        metrics={window: {name: value.as_dict() for name, value in found.items()} for window, found in values.items()},
        laps={
            "tcp_position_error_mean": position.tolist(),
            "tcp_orientation_error_mean": orientation.tolist(),
        },
        timing=score_calls(log),
    )


def score_calls(log: RunLog) -> dict[str, float]:
    """Return the metrics of a run's call times; wall times belong to a machine and stand apart from the results.

    Args:
        log: A run.
    """
    calls = log.call_time[WARM_UP:]
    if not len(calls):
        return {}
    fields = {"call_time": calls, "dt": log.dt}
    values = {m.id: m.value_of(fields).value for m in all_metrics().values() if m.kind == "timing"}
    return {name: value for name, value in values.items() if math.isfinite(value)}


def score_events(log: RunLog, events: Sequence[LoadEvent]) -> EventScores:
    """Return the metrics of the load events of a run, by window.

    Args:
        log: The run.
        events: Its events, with the logs of the twins that they are judged against.
    """
    twins = [
        EventTwins(
            time=event.time,
            until=event.until,
            mass_change=event.mass_change,
            old=event.old,
            new=event.new,
            reason=event.reason,
        )
        for event in events
    ]
    values = evaluate_events(log, twins)
    return {window: {name: value.as_dict() for name, value in found.items()} for window, found in values.items()}
