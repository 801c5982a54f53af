"""From a run with its twins to the metrics of its events."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.evaluation import METRICS, EventTwins, UnequalLengths, compare, evaluate, evaluate_events
from torquebench.evaluation.metrics import EVENT_METRICS, success
from torquebench.evaluation.rows import RunRow, read

DT = 1e-2


def run(excess=0.0, event=4.0, joints=7, until=10.0):
    """A second of lead-in, then ten seconds with laps of 2 s; from the event on the first joint is further off."""
    t = np.arange(-100, round(until / DT)) * DT
    q = np.zeros((len(t), joints))
    q[:, 0] = 0.02
    since = t - event
    q[:, 0] += np.where(since > -DT / 2, excess * np.exp(-since / 0.4), 0.0)
    return SimpleNamespace(t=t, dt=DT, lap=2.0, q=q, q_ref=np.zeros_like(q), p=q[:, :3], p_ref=np.zeros((len(t), 3)))


def twins(old=None, new=None, **changes):
    return EventTwins(time=4.0, until=math.inf, mass_change=2.0, old=old, new=new, **changes)


def test_an_event_is_a_window_of_its_own_with_every_metric():
    found = evaluate_events(run(0.05), [twins(run(), run())])
    assert list(found) == ["event@4"]
    assert list(found["event@4"]) == list(EVENT_METRICS)
    assert {value.status for value in found["event@4"].values()} == {"ok"}
    assert found["event@4"]["recovery_time_settled"].value == pytest.approx(0.4 * math.log(10.0), abs=DT)


def test_the_lead_in_is_no_part_of_it():
    """Before time 0 an arm may do what it likes."""
    calm, wild = run(0.05), run(0.05)
    wild.q[:100] += 0.3
    ours, theirs = (evaluate_events(log, [twins(run(), run())])["event@4"] for log in (calm, wild))
    assert ours == theirs


@pytest.mark.parametrize("missing", ["old", "new"])
def test_without_a_twin_the_event_is_undefined_with_the_reason(missing):
    logs = {"old": run(), "new": run(), missing: None}
    found = evaluate_events(run(0.05), [twins(**logs, reason="twin 'constant 3.5 kg' failed: divergence")])
    assert {(v.status, v.reason) for v in found["event@4"].values()} == {
        ("undefined", "twin 'constant 3.5 kg' failed: divergence")
    }


def test_a_run_that_differs_from_its_twin_before_the_event_is_failed():
    """To the last bit: anything else is hidden state or a leaked seed."""
    leaked = run()
    leaked.q[450, 3] = 1e-15
    leaked.q[450, 0] += 1e-15
    found = evaluate_events(run(0.05), [twins(leaked, run())])
    assert {value.status for value in found["event@4"].values()} == {"failed"}
    assert all("before the event" in value.reason for value in found["event@4"].values())


def test_a_twin_of_another_length_is_an_error():
    with pytest.raises(UnequalLengths):
        evaluate_events(run(0.05), [twins(run(until=9.0), run())])


def test_a_log_without_a_tool_point_has_no_metrics_of_it():
    logs = [run(0.05), run(), run()]
    for log in logs:
        log.p = None
    found = evaluate_events(logs[0], [twins(*logs[1:])])["event@4"]
    assert "recovery_time_settled" in found
    assert not [name for name in found if name.endswith("_position")]


def test_metrics_of_a_run_with_twins_are_not_computed_for_a_log_alone():
    assert not set(EVENT_METRICS) & set(evaluate(run(), windows=("run",))["run"])
    assert evaluate(run(), ids=["recovery_time_settled"], windows=("run",)) == {"run": {}}


def test_a_motion_that_is_no_cycle_has_excess_but_no_recovery():
    """A threshold is made of a lap."""
    logs = [run(0.05), run(), run()]
    for log in logs:
        log.lap = None
    found = evaluate_events(logs[0], [twins(*logs[1:])])["event@4"]
    assert found["recovery_time_settled"].status == "undefined"
    assert found["excess_integral"].status == "ok"


def test_success_is_within_limits_and_near_the_plan():
    q = np.zeros((5, 2))
    limits = (np.full(2, -1.0), np.full(2, 1.0))
    assert success(q, q, *limits) == 1.0
    assert success(q + 1.5, q + 1.5, *limits) == 0.0
    assert success(q, q + 0.8, np.full(2, -9.0), np.full(2, 9.0)) == 0.0
    assert METRICS["success"].fail_value == 0.0


def row(controller, trajectory, value, status="ok"):
    stored = json.loads(json.dumps({"value": value, "unit": "s", "status": status, "n": 5}))
    return RunRow(
        controller=controller, trajectory=trajectory, group="", mass=1.5, material="", repetition=0, status="ok",
        metrics={"event@12": {"recovery_time_settled": stored}},
    )  # fmt: skip


def test_a_recovery_that_never_came_is_ranked_worst_and_enters_no_ratio():
    """Infinity has no logarithm; leaving the run out of the ranks would reward it."""
    ours = [row("a", f"T{i}", 1.0) for i in range(8)]
    theirs = [row("b", f"T{i}", 2.0) for i in range(7)] + [row("b", "T7", math.inf, "censored")]
    found = compare([*ours, *theirs], "a", "b", "recovery_time_settled", window="event@12")
    assert found.prob_improvement == 1.0
    assert found.win_rate == 1.0
    assert found.n_pairs == 7
    assert len(found.without_ratio) == 1
    reading = read(theirs[-1], METRICS["recovery_time_settled"], "event@12")
    assert (reading.status, reading.magnitude) == ("censored", None)
    assert reading.rank(METRICS["recovery_time_settled"]) == math.inf
