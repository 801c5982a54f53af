"""Where harness and metrics meet: what a worker makes of a log."""

import math
import pickle

import numpy as np
import pytest
from torquebench.evaluation.metrics.resilience import EVENT_METRICS
from torquebench.scenarios.events import LoadEvent, event_window
from torquebench.scoring import score, score_events

TICKS, DT = 8000, 1e-3


class Log:
    """Four laps of 2 s whose error is a constant and a bump after an event at 4 s."""

    def __init__(self, *, bump):
        self.t, self.dt, self.lap = np.arange(TICKS) * DT, DT, 2.0
        self.q_ref, self.p_ref = np.zeros((TICKS, 7)), np.zeros((TICKS, 3))
        after = np.where(self.t >= 4.0, np.exp(-(self.t - 4.0) / 0.4), 0.0)
        self.q, self.p = self.q_ref.copy(), self.p_ref.copy()
        self.call_time = np.full(TICKS, 2e-5)
        self.q[:, 0] = 0.01 + bump * after
        self.p[:, 0] = 0.001 + 0.1 * bump * after


@pytest.fixture
def event():
    """2 kg more at 4 s, judged against runs without a bump."""
    return LoadEvent(time=4.0, until=8.0, mass_change=2.0, old=Log(bump=0.0), new=Log(bump=0.0))


def test_an_event_becomes_a_window_of_plain_values(event):
    """A decay of 0.05 rad with 0.4 s: 0.02 rad s in all, below a quarter of 10 mrad after 0.4 ln 20."""
    (window,) = (found := score_events(Log(bump=0.05), [event]))
    values = found[window]
    assert window == event_window(4.0) == "event@4"
    assert values["excess_integral"]["value"] == pytest.approx(0.02, rel=2e-3)
    assert values["recovery_time_settled"]["value"] == pytest.approx(0.4 * math.log(20.0), abs=2e-3)
    assert set(values["excess_integral"]) >= {"value", "unit", "status", "n"}


def test_a_lost_twin_is_undefined_in_every_metric(event):
    """The reason stands with each value: no figure without the runs that it is the difference of."""
    lost = LoadEvent(time=4.0, until=8.0, mass_change=2.0, old=None, new=None, reason="twin 'x' failed: nan")
    found = score_events(Log(bump=0.05), [lost])["event@4"]
    assert set(found) == set(EVENT_METRICS)
    assert {(value["status"], value["reason"]) for value in found.values()} == {("undefined", lost.reason)}


def test_a_log_that_ended_at_once_has_windows_too():
    """A run may fail at its first tick; its events are undefined, not an error of the harness."""
    log = Log(bump=0.0)
    for name in ("t", "q", "q_ref", "p", "p_ref"):
        setattr(log, name, getattr(log, name)[:0])
    lost = LoadEvent(time=4.0, until=8.0, mass_change=2.0, old=None, new=None, reason="the run failed: nan")
    assert {value["status"] for value in score_events(log, [lost])["event@4"].values()} == {"undefined"}


def test_both_callables_go_to_worker_processes():
    """By name, like any function of a module."""
    assert pickle.loads(pickle.dumps((score, score_events))) == (score, score_events)
