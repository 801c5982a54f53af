"""Load events on logs that are written down by hand: who is compared with whom, until when, and who may not be."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.scenarios.events import (
    COMPARED,
    LoadEvent,
    event_window,
    hidden_difference,
    judge_events,
    load_events,
    twins_of_event,
)
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.specification import twin_schedules
from torquebench.scenarios.trial import Trial

DT, LAP, LEAD_IN = 0.01, 1.0, 0.2
LIGHT, MIDDLE, HEAVY = (Payload(mass=mass, material="sand") for mass in (1.5, 2.5, 3.5))


def history(*loads, times=(0.0, 2.0, 4.0, 6.0, 8.0)):
    """Return loads that change every second lap."""
    return LoadSchedule(entries=tuple(zip(times, loads, strict=False)))


def moving_arm(laps=6):
    """A log of an arm that swings with a lap of 1 s, lead-in included."""
    t = np.round(np.arange(round((LEAD_IN + laps * LAP) / DT)) * DT - LEAD_IN, 9)
    wave = np.sin(2.0 * np.pi * t / LAP)[:, None]
    rows = {name: wave * np.arange(1.0, 8.0) for name in ("q", "dq", "tau_cmd", "tau")}
    return SimpleNamespace(t=t, dt=DT, lap=LAP, wrench=wave * np.arange(1.0, 7.0), **rows)


def trial(log=None, role="run", status="ok", reason=""):
    """Return a trial that ended in a status."""
    return Trial(result=RunResult(role=role, status=status, reason=reason), log=log)


@pytest.fixture
def cast(run_of):
    """Builds the specification of a load history, and sound trials of the run and of all its twins."""

    def build(schedule, laps=6):
        roles = ("run", *twin_schedules(schedule))
        specification = run_of(schedule=schedule, twins=True, laps=laps)
        return specification, {role: trial(moving_arm(laps), role) for role in roles}

    return build


def by_window(log, events):
    """Judge every event by its status alone."""
    return {
        event_window(event.time): {"a5": {"value": 1.0, "status": "ok" if event.old else "undefined"}}
        for event in events
    }


@pytest.mark.parametrize(("time", "name"), [(12.0, "event@12"), (0.5, "event@0.5"), (1e-3, "event@0.001")])
def test_a_window_is_named_by_the_time_of_its_event(time, name):
    """The name is a key of the row; 12 and 12.0 are one event."""
    assert event_window(time) == name


def test_the_twins_of_an_event_are_what_would_have_been_and_what_always_was():
    """The second event of three: its old load came with the first, its new load was there from the start."""
    schedule = history(LIGHT, HEAVY, MIDDLE, LIGHT)
    twins = twin_schedules(schedule)
    for number, load in enumerate((HEAVY, MIDDLE, LIGHT), start=1):
        old, new = twins_of_event(schedule, number)
        assert twins[old].entries == schedule.entries[:number]
        assert twins[new] == LoadSchedule.constant(load)


def test_an_event_lasts_until_the_next_one_or_the_end_of_the_run(cast):
    """What the next load does to the error must not be counted for this one."""
    specification, trials = cast(history(LIGHT, HEAVY, MIDDLE))
    first, second = load_events(specification, trials)
    assert (first.time, first.until, second.time, second.until) == (2.0, 4.0, 4.0, 6.0)
    assert (first.mass_change, second.mass_change) == (2.0, -1.0)
    assert first.reason == second.reason == ""


def test_an_event_ends_with_the_run_even_if_another_was_planned_after_it(cast):
    """Five laps and an event at 6 s: it never comes, and the one before it ends where the run does."""
    specification, trials = cast(history(LIGHT, HEAVY, MIDDLE, LIGHT), laps=5)
    events = load_events(specification, trials)
    assert [event.until for event in events] == [4.0, 5.0, 5.0]
    assert [event.reason for event in events] == ["", "", "the run ends at 5 s"]


def test_every_event_holds_the_logs_of_its_own_twins(cast):
    """Not those of its neighbour: a swap would compare the heavy load with itself."""
    schedule = history(LIGHT, HEAVY, LIGHT)
    specification, trials = cast(schedule)
    for number, event in enumerate(load_events(specification, trials), start=1):
        old, new = twins_of_event(schedule, number)
        assert event.old is trials[old].log
        assert event.new is trials[new].log


def test_a_lost_twin_takes_only_its_own_events(cast):
    """The step up has both of its runs; the step back needs the one that was lost."""
    schedule = history(LIGHT, HEAVY, LIGHT)
    specification, trials = cast(schedule)
    (lost, _) = twins_of_event(schedule, 2)
    trials[lost] = trial(None, lost, "failed", "joint 4 moves at 21 rad/s")
    up, back = load_events(specification, trials)
    assert up.reason == ""
    assert back.reason == f"twin {lost!r} failed: joint 4 moves at 21 rad/s"
    assert back.old is None and back.new is None


@pytest.mark.parametrize("name", COMPARED)
def test_one_bit_before_an_event_is_a_leak_that_is_named(name):
    """Until the event the run and its old-load twin are the same simulation: a difference is hidden state or a seed."""
    run, old = moving_arm(), moving_arm()
    row = 137
    array = getattr(old, name)
    array[row, 3] = np.nextafter(array[row, 3], np.inf)
    event = LoadEvent(time=2.0, until=4.0, mass_change=2.0, old=old, new=moving_arm())
    assert hidden_difference(run, event) == (
        f"{name} differs from the old-load twin at {run.t[row]:.3f} s already: hidden state or seed"
    )


def test_at_its_own_tick_an_event_is_there_already():
    """The load changes before the tick is sensed: from that row on a difference is what the event is for."""
    run, old = moving_arm(), moving_arm()
    row = int(np.flatnonzero(run.t == 2.0)[0])
    event = LoadEvent(time=2.0, until=4.0, mass_change=2.0, old=old, new=old)
    old.wrench[row:] += 9.81
    assert hidden_difference(run, event) == ""
    old.wrench[row - 1] += 9.81
    assert "wrench differs" in hidden_difference(run, event)


def test_the_first_difference_is_the_one_that_is_named():
    """A leak grows; where it begins says what leaked."""
    run, old = moving_arm(), moving_arm()
    old.q[50:] += 1e-12
    event = LoadEvent(time=2.0, until=4.0, mass_change=2.0, old=old, new=old)
    assert f"at {run.t[50]:.3f} s" in hidden_difference(run, event)


def test_a_judged_run_has_the_windows_of_its_events_beside_its_own(cast):
    """The run's own metrics stay; a note says of each event what it was judged against."""
    specification, trials = cast(history(LIGHT, HEAVY, LIGHT))
    sound = replace(trials["run"].result, metrics={"run": {"error": {"value": 0.1}}}, provenance={"group": "fast"})
    trials["run"] = replace(trials["run"], result=sound)
    row = judge_events(specification, trials, by_window)
    assert list(row.metrics) == ["run", "event@2", "event@4"]
    assert row.metrics["run"] == {"error": {"value": 0.1}}
    assert row.provenance["group"] == "fast"
    assert [(note["window"], note["mass_change"], note["status"]) for note in row.provenance["events"]] == [
        ("event@2", 2.0, "ok"),
        ("event@4", -2.0, "ok"),
    ]
    assert [(note["old"], note["new"]) for note in row.provenance["events"]] == [
        twins_of_event(specification.schedule, number) for number in (1, 2)
    ]


def test_a_leak_fails_its_event_and_every_metric_in_it(cast):
    """The numbers could be computed, and would be wrong: the status says so, the reason says where."""
    specification, trials = cast(history(LIGHT, HEAVY, LIGHT))
    old, _ = twins_of_event(specification.schedule, 1)
    trials[old].log.tau[60, 0] += 1e-9
    row = judge_events(specification, trials, by_window)
    assert row.metrics["event@2"]["a5"]["status"] == "failed"
    assert row.metrics["event@4"]["a5"]["status"] == "ok"
    first, second = row.provenance["events"]
    assert (first["status"], second["status"]) == ("failed", "ok")
    assert first["reason"].startswith("tau differs from the old-load twin at 0.400 s")
    assert row.status == "ok"


def test_an_event_that_cannot_be_judged_is_noted_with_its_reason(cast):
    """A reader of the row asks why there is no figure; the row answers."""
    specification, trials = cast(history(LIGHT, HEAVY, MIDDLE, LIGHT), laps=5)
    notes = judge_events(specification, trials, by_window).provenance["events"]
    assert [(note["status"], note["reason"]) for note in notes] == [
        ("ok", ""),
        ("ok", ""),
        ("undefined", "the run ends at 5 s"),
    ]


def test_a_run_without_a_log_is_returned_as_it_came(cast):
    """Nothing was simulated: there is no event to speak of, and the row keeps its own reason."""
    specification, trials = cast(history(LIGHT, HEAVY))
    trials["run"] = trial(None, status="refused", reason="gain margin 0.4 < 1")

    def never(log, events):
        raise AssertionError("nothing to judge")

    assert judge_events(specification, trials, never) is trials["run"].result
