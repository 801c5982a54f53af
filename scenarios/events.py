"""Load events: what a run with twins is judged against, and whether it may be.

An event is judged by the difference between the run and two twins: the old load that stays, and the new load from the
start. Until the event the run and its old-load twin are the same simulation, so they must agree to the bit.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from .loads import LoadSchedule
from .log import RunLog
from .result import FAILED, OK, RunResult
from .specification import RunSpecification, twin_schedules
from .trial import Trial

COMPARED = ("q", "dq", "tau_cmd", "tau", "wrench")
"""What has to agree to the bit before an event."""


@dataclass(frozen=True, kw_only=True)
class LoadEvent:
    """A change of the load during a run.

    Attributes:
        time: When [s].
        until: Time of the next event, or the end of the run [s].
        mass_change: New mass minus old mass [kg].
        old: The twin whose old load stays; None if there is none to judge by.
        new: The twin with the new load from the start; None if there is none to judge by.
        reason: Why there is none, one line; empty otherwise.
    """

    time: float
    until: float
    mass_change: float
    old: RunLog | None
    new: RunLog | None
    reason: str = ""


EventScores = Mapping[str, Mapping[str, Mapping[str, object]]]
"""Window of an event to metric id to value, status, unit and number of samples."""

EvaluateEvents = Callable[[RunLog, Sequence[LoadEvent]], EventScores]


def event_window(time: float) -> str:
    """Return the name of the window of an event, for example ``event@12``."""
    return f"event@{time:g}"


def judge_events(
    specification: RunSpecification, trials: Mapping[str, Trial], evaluate_events: EvaluateEvents
) -> RunResult:
    """Return the row of a run with the windows of its events in it.

    Args:
        specification: The run.
        trials: Role to trial, of the run and all its twins.
        evaluate_events: Compares the run with its twins.
    """
    run = trials["run"]
    if run.log is None:
        return run.result
    events = load_events(specification, trials)
    leaks = [hidden_difference(run.log, event) if event.old is not None else "" for event in events]
    judged = [
        replace(event, old=None, new=None, reason=leak) if leak else event
        for event, leak in zip(events, leaks, strict=True)
    ]
    found = {name: dict(values) for name, values in evaluate_events(run.log, judged).items()}
    for event, leak in zip(events, leaks, strict=True):
        if leak:
            window = event_window(event.time)
            found[window] = {name: {**value, "status": FAILED} for name, value in found.get(window, {}).items()}
    notes = [_note(event, leak, specification) for event, leak in zip(judged, leaks, strict=True)]
    return replace(
        run.result,
        metrics={**run.result.metrics, **found},
        provenance={**run.result.provenance, "events": notes},
    )


def load_events(specification: RunSpecification, trials: Mapping[str, Trial]) -> tuple[LoadEvent, ...]:
    """Return the events of a run with the logs of their twins.

    Args:
        specification: The run.
        trials: Role to trial, of the run and all its twins.
    """
    run, entries = trials["run"], specification.schedule.entries
    end = specification.laps * run.log.lap if run.log is not None else 0.0
    found = []
    for number, ((_, old), (time, new)) in enumerate(pairwise(entries), start=1):
        until = min(entries[number + 1][0], end) if number + 1 < len(entries) else end
        twins = twins_of_event(specification.schedule, number)
        reason = _why_not(run, time, end, {role: trials[role] for role in twins})
        old_log, new_log = (None if reason else trials[role].log for role in twins)
        change = new.mass - old.mass
        found.append(LoadEvent(time=time, until=until, mass_change=change, old=old_log, new=new_log, reason=reason))
    return tuple(found)


def twins_of_event(schedule: LoadSchedule, number: int) -> tuple[str, str]:
    """Return the roles of the twins of an event: the old load that stays, and the new load from the start.

    Args:
        schedule: The load history.
        number: Which event, from 1.
    """
    roles = {history: role for role, history in twin_schedules(schedule).items()}
    stays = LoadSchedule(entries=schedule.entries[:number])
    return roles[stays], roles[LoadSchedule.constant(schedule.entries[number][1])]


def hidden_difference(log: RunLog, event: LoadEvent) -> str:
    """Say in one line where a run and its old-load twin differ before an event; empty if they agree to the bit.

    Args:
        log: The run.
        event: An event with its old-load twin.
    """
    # The state at the event's own tick is still the same, the load is not.
    rows = int(np.searchsorted(log.t, event.time - 0.5 * log.dt))
    for name in COMPARED:
        one, two = getattr(log, name)[:rows], getattr(event.old, name)[:rows]
        differ = np.flatnonzero((one != two).any(axis=1))
        if differ.size:
            tick = int(differ[0])
            return f"{name} differs from the old-load twin at {log.t[tick]:.3f} s already: hidden state or seed"
    return ""


def _why_not(run: Trial, time: float, end: float, twins: Mapping[str, Trial]) -> str:
    """Return why an event cannot be judged, one line; empty if it can."""
    if run.result.status != OK:
        return f"the run {run.result.status}: {run.result.reason}"
    if not time < end - 1e-9:
        return f"the run ends at {end:g} s"
    for role, twin in twins.items():
        if twin.result.status != OK:
            return f"twin {role!r} {twin.result.status}: {twin.result.reason}"
    return ""


def _note(event: LoadEvent, leak: str, specification: RunSpecification) -> dict[str, object]:
    """Return what a report says of an event besides its metrics."""
    number = specification.schedule.events.index(event.time) + 1
    old, new = twins_of_event(specification.schedule, number)
    status = FAILED if leak else "undefined" if event.reason else OK
    return {
        "window": event_window(event.time),
        "time": event.time,
        "until": event.until,
        "mass_change": event.mass_change,
        "old": old,
        "new": new,
        "status": status,
        "reason": event.reason,
    }
