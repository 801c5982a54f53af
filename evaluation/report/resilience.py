"""How controllers came through the load events of a world: judged by twins, and from the curves as the paper does."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...scenarios.store import Store
from ..metrics import METRICS, Value
from .numbers import MINUS
from .spread import Spread, gathered
from .traces import Curves, read_curves
from .worlds import Run, World

SERIES = ("last_cycle_error", "recovery_time_cycle_band", "recovery_time_paper_style", "error_peak_raw")
"""Figures that come from the curves, averaged over the trajectories of a seed."""
STEADY_TWIN = "constant "
"""How the roles of twins begin whose load never changes."""
REPEATED = 3
"""How often the same change must happen to have a rate of improvement."""


@dataclass(frozen=True, kw_only=True)
class Event:
    """A change of the load, or the start.

    Attributes:
        time: When [s].
        until: Time of the next one; infinite for the last [s].
        words: What happens, for example ``+2 kg``.
        window: Window of its metrics; empty for the start, which has no twin.
    """

    time: float
    until: float
    words: str
    window: str

    @property
    def title(self) -> str:
        """The event in words."""
        return f"{self.words} at {self.time:g} s" if self.window else "Start-up at 0 s"


@dataclass(frozen=True, kw_only=True)
class MeanCurve:
    """The joint error of one controller over time, averaged over trajectories.

    Attributes:
        dt: Time between samples [s].
        seeds: One curve for each repetition in which every trajectory finished, shape (S, N) [rad].
        repetitions: The number of each of these repetitions.
        paths: How many trajectories were averaged.
    """

    dt: float
    seeds: np.ndarray
    repetitions: Sequence[int]
    paths: int

    @property
    def t(self) -> np.ndarray:
        """Time of each sample, shape (N,) [s]."""
        return np.arange(self.seeds.shape[1]) * self.dt


@dataclass(frozen=True, kw_only=True)
class Resilience:
    """The load events of one world.

    Attributes:
        events: The start, then every change of the load.
        found: By event and controller, metric id to its values; series metrics have a value for each seed.
        curves: Mean curve of each controller that has one.
        constant: Controller to constant load, in words, to the mean curve of the twins that had it from the start on.
        without: Controllers without a mean curve, and why.
        unjudged: Run, event, status and reason for everything that the twins could not judge.
        rates: By change and controller, how the cost of the same change develops from event to event; only changes
            that happen at least three times.
    """

    events: Sequence[Event]
    found: Mapping[tuple[Event, str], Mapping[str, Spread]]
    curves: Mapping[str, MeanCurve]
    constant: Mapping[str, Mapping[str, MeanCurve]]
    without: Mapping[str, str]
    unjudged: Sequence[tuple[Run, Event, str, str]]
    rates: Mapping[tuple[str, str], Spread]

    @property
    def dt(self) -> float | None:
        """The coarsest time between samples of the curves [s]; None without a curve."""
        return max((curve.dt for curve in self.curves.values()), default=None)


def events_of(world: World) -> list[Event]:
    """Return the start and the load events of a world, empty if the load never changes."""
    entries = world.runs[0].stored.specification.schedule.entries if world.runs else ()
    if len(entries) < 2:
        return []
    times = [0.0, *(time for time, _ in entries[1:]), math.inf]
    words = ["start", *(_change(new.mass - old.mass) for (_, old), (_, new) in pairwise(entries))]
    return [
        Event(time=time, until=until, words=word, window=f"event@{time:g}" if place else "")
        for place, ((time, until), word) in enumerate(zip(pairwise(times), words, strict=True))
    ]


def _change(mass: float) -> str:
    """Return a change of the load: ``+2 kg``."""
    return f"{MINUS if mass < 0.0 else '+'}{abs(mass):g} kg"


def resilience_of(world: World, store: Store) -> Resilience | None:
    """Return what is known of a world's load events; None if its load never changes.

    Args:
        world: The world.
        store: The open store that it comes from.
    """
    events = events_of(world)
    if not events:
        return None
    laps = int(world.facts["Laps"])
    curves: dict[str, MeanCurve] = {}
    without: dict[str, str] = {}
    found: dict[tuple[Event, str], dict[str, Spread]] = {}
    for label in world.labels:
        runs = [run for run in world.runs if run.row.controller == label]
        curve = _mean_curve((run, read_curves(store, run)) for run in runs)
        if isinstance(curve, MeanCurve):
            curves[label] = curve
        else:
            without[label] = curve
        for event in events:
            found[event, label] = {**_judged(runs, event), **(_series(curves.get(label), event, laps))}
    return Resilience(
        events=events,
        found=found,
        curves=curves,
        constant={label: _constant(world, label, store) for label in curves},
        without=without,
        unjudged=list(_unjudged(world.runs, events)),
        rates=_rates(world, events),
    )


def _constant(world: World, label: str, store: Store) -> dict[str, MeanCurve]:
    """Return the mean curves of a controller's twins whose load never changes, by their role."""
    own = [twin for twin in world.twins if twin.row.controller == label]
    roles = sorted({twin.stored.result.role for twin in own if twin.stored.result.role.startswith(STEADY_TWIN)})
    found = {
        role: _mean_curve((twin, read_curves(store, twin)) for twin in own if twin.stored.result.role == role)
        for role in roles
    }
    return {role: curve for role, curve in found.items() if isinstance(curve, MeanCurve)}


def _judged(runs: Sequence[Run], event: Event) -> dict[str, Spread]:
    """Return the values of every metric of a run with its twins, over the runs that finished."""
    entries = [run.row.metrics.get(event.window, {}) for run in runs if run.row.status == "ok"]
    ids = [name for name, metric in METRICS.items() if metric.kind == "twins"]
    return {name: gathered(entry.get(name) for entry in entries) for name in ids} if event.window else {}


def _rates(world: World, events: Sequence[Event]) -> dict[tuple[str, str], Spread]:
    """Return the rates of improvement of each change of the load that is repeated, run by run."""
    changes: dict[str, list[Event]] = {}
    for event in events[1:]:
        changes.setdefault(event.words, []).append(event)
    found: dict[tuple[str, str], Spread] = {}
    for words, same in changes.items():
        for run in world.runs if len(same) >= REPEATED else ():
            costs = [run.row.metrics.get(event.window, {}).get("excess_integral", {}).get("value") for event in same]
            able = [math.nan if cost is None else float(cost) for cost in costs]
            if run.row.status == "ok":
                value = METRICS["improvement_rate"].value_of({"excess_integrals": np.array(able)})
                status = "undefined" if value.status == "failed" else value.status
                found.setdefault((words, run.row.controller), Spread()).add(value.value, status)
    return found


def _series(curve: MeanCurve | None, event: Event, laps: int) -> dict[str, Spread]:
    """Return the figures of the curves, seed by seed."""
    found = {name: Spread() for name in SERIES}
    for name, spread in found.items():
        for value in values_by_seed(curve, name, event, laps) if curve is not None else ():
            spread.add(value.value, value.status)
    return found


def values_by_seed(curve: MeanCurve, name: str, event: Event, laps: int) -> list[Value]:
    """Return a figure of :data:`SERIES` for each seed of a mean curve, whatever its status.

    Args:
        curve: The curve.
        name: Id of the metric.
        event: After which change of the load.
        laps: Laps of the run.
    """
    count = curve.seeds.shape[1]
    fields = {"event": event.time, "until": event.until, "dt": curve.dt, "lap": count * curve.dt / laps}
    return [METRICS[name].value_of({**fields, "errors": errors[None, :]}) for errors in curve.seeds]


def _mean_curve(read: Iterable[tuple[Run, Curves | None]]) -> MeanCurve | str:
    """Return the mean over trajectories of each seed that has them all, or why there is none."""
    listed = list(read)
    paths = sorted({run.row.trajectory for run, _ in listed})
    seeds: dict[tuple[float, str, int], dict[str, Curves]] = {}
    for run, curves in listed:
        if curves is not None:
            key = (run.row.mass, run.row.material, run.row.repetition)
            seeds.setdefault(key, {})[run.row.trajectory] = curves
    whole = {key: seed for key, seed in sorted(seeds.items(), key=lambda item: str(item[0])) if len(seed) == len(paths)}
    if not seeds:
        return "no trace was kept" if any(run.row.status == "ok" for run, _ in listed) else "no run finished"
    if not whole:
        return "no seed finished on every trajectory with its trace kept"
    shapes = {(curves.dt, len(curves.error)) for seed in whole.values() for curves in seed.values()}
    if len(shapes) > 1:
        return "its trajectories last differently long"
    means = [np.mean([seed[path].error for path in paths], axis=0) for seed in whole.values()]
    repetitions = [repetition for _, _, repetition in whole]
    return MeanCurve(dt=shapes.pop()[0], seeds=np.array(means), repetitions=repetitions, paths=len(paths))


def _unjudged(runs: Sequence[Run], events: Sequence[Event]) -> Iterable[tuple[Run, Event, str, str]]:
    """Return every event of a finished run that has no value for want of a twin, or because it differs from one."""
    for run in runs:
        noted = run.stored.result.provenance.get("events")
        notes = [note for note in noted if isinstance(note, Mapping)] if isinstance(noted, list) else []
        reasons = {note.get("time"): str(note.get("reason") or "") for note in notes}
        for event in events:
            values = run.row.metrics.get(event.window, {}).values()
            statuses = {str(value.get("status")) for value in values}
            if event.window and run.row.status == "ok" and len(statuses) == 1 and statuses <= {"undefined", "failed"}:
                reason = reasons.get(event.time) or next((str(v["reason"]) for v in values if v.get("reason")), "")
                yield run, event, statuses.pop(), reason or "no reason on record"
