"""Twins: the load histories that an event is judged against."""

from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import twin_schedules

LIGHT, HEAVY = Payload(mass=1.5), Payload(mass=3.5, material="sand")


def history(*loads, every=12.0):
    """Return loads that change every twelve seconds."""
    return LoadSchedule(entries=tuple((i * every, load) for i, load in enumerate(loads)))


def test_a_step_up_and_back_has_three_extra_histories():
    """For the step up: both loads constant; for the step back: the heavy one stays, and the light one, had already."""
    twins = twin_schedules(history(LIGHT, HEAVY, LIGHT))
    assert twins == {
        "constant 1.5 kg": LoadSchedule.constant(LIGHT),
        "constant 3.5 kg sand": LoadSchedule.constant(HEAVY),
        "3.5 kg sand stays": history(LIGHT, HEAVY),
    }


def test_every_event_has_its_old_load_that_stays_and_its_new_load_from_the_start():
    """Both twins share the draws of the run: A5 is their difference and nothing else."""
    loads = (LIGHT, Payload(mass=2.0, material="sand"), HEAVY, Payload(mass=2.5, material="sand"))
    run = history(*loads)
    found = set(twin_schedules(run).values())
    for event in range(1, len(loads)):
        assert LoadSchedule(entries=run.entries[:event]) in found
        assert LoadSchedule.constant(loads[event]) in found


def test_a_run_without_events_has_no_twins():
    """Nothing changes, nothing to compare."""
    assert twin_schedules(LoadSchedule.constant(HEAVY)) == {}


def test_equal_histories_are_run_once():
    """Up, down, up again: two constants, and the prefixes."""
    twins = twin_schedules(history(LIGHT, HEAVY, LIGHT, HEAVY))
    assert len(set(twins.values())) == len(twins) == 4


def test_no_history_loses_its_name_to_another():
    """Twice '3.5 kg stays' are two histories; a dictionary with one key would drop a twin without a word."""
    run = history(LIGHT, HEAVY, LIGHT, HEAVY, LIGHT)
    twins = twin_schedules(run)
    assert set(twins.values()) == {
        LoadSchedule.constant(LIGHT),
        LoadSchedule.constant(HEAVY),
        *(LoadSchedule(entries=run.entries[:event]) for event in (2, 3, 4)),
    }
    assert "3.5 kg sand stays" in twins
    assert "3.5 kg sand stays from 36 s" in twins


def test_a_constant_twin_starts_with_the_run():
    """Its load acts from the first tick, lead-in included, as every first entry does."""
    for twin in twin_schedules(history(LIGHT, HEAVY)).values():
        assert twin.events == ()
