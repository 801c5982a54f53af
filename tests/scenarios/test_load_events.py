"""Load events: a run and its twins are the same simulation until the event, and are compared where both are sound."""

import numpy as np
import pytest
from torquebench.controllers import Controller
from torquebench.scenarios.events import event_window, twins_of_event
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import Scores
from torquebench.scenarios.workers import Duty, run_in_workers
from torquebench.scoring import score, score_events

LIGHT, HEAVY = Payload(mass=1.5), Payload(mass=3.5, material="sand")
STEP = LoadSchedule(entries=((0.0, LIGHT), (0.5, HEAVY), (1.25, LIGHT)))


class Law(Controller):
    """Computed torque."""

    def reset(self, task):
        self.robot = task.robot

    def compute(self, observation, target):
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        return self.robot.inverse_dynamics(observation.q, observation.dq, target.ddq + 400 * error + 40 * error_rate)


class Leaks(Law):
    """Has a state that survives in the class: the run and its twins are no longer the same simulation."""

    runs = 0

    def reset(self, task):
        super().reset(task)
        Leaks.runs += 1

    def compute(self, observation, target):
        return super().compute(observation, target) * (1.0 + 1e-15 * Leaks.runs)


class FailsUnderSand(Law):
    """Works with the light load only."""

    def compute(self, observation, target):
        torque = super().compute(observation, target)
        return torque if observation.wrench[2] < 30.0 else np.full(7, np.nan)


class FailsWithSandAtTheStart(Law):
    """Works if the sand comes later."""

    def reset(self, task):
        super().reset(task)
        self.ticks = 0

    def compute(self, observation, target):
        self.ticks += 1
        broken = self.ticks == 1 and observation.wrench[2] > 30.0
        return np.full(7, np.nan) if broken else super().compute(observation, target)


def nothing(_):
    """Score a log by nothing."""
    return Scores(metrics={"run": {}})


@pytest.fixture
def judged(run_of):
    """Runs a law with twins and returns its row, all rows by role, and the events that were judged."""

    def run(law=Law, schedule=STEP, **changes):
        seen = []

        def evaluate(log, events):
            seen.extend(events)
            status = ["ok" if event.old is not None else "undefined" for event in events]
            return {event_window(e.time): {"a5": {"status": s}} for e, s in zip(events, status, strict=True)}

        specification = run_of(schedule=schedule, twins=True, **{"tier": "actuated"} | changes)
        rows = execute(specification, evaluate=nothing, evaluate_events=evaluate, traces="none", plug_ins={"mine": law})
        return rows[0], {row.role: row for row in rows}, seen

    return run


def test_every_event_is_judged_against_its_old_and_its_new_load(judged):
    """Up: both constants. Down: the sand that stays, and the constant light load. Each until the next event."""
    row, _, (up, down) = judged()
    assert (up.time, up.until, up.mass_change) == (0.5, 1.25, 2.0)
    assert (down.time, down.until, down.mass_change) == (1.25, pytest.approx(2.0), -2.0)
    weights = [np.linalg.norm(log.wrench[-1, :3]) for log in (up.old, up.new, down.old, down.new)]
    assert weights == pytest.approx([1.5 * 9.81, 3.5 * 9.81, 3.5 * 9.81, 1.5 * 9.81], rel=0.1)
    assert row.metrics == {"run": {}, "event@0.5": {"a5": {"status": "ok"}}, "event@1.25": {"a5": {"status": "ok"}}}
    assert [note["old"] for note in row.provenance["events"]] == ["constant 1.5 kg", "3.5 kg sand stays"]


def test_twins_are_named_as_their_rows(judged):
    """A report goes from the event to the rows of its twins."""
    row, rows, _ = judged()
    roles = {note[side] for note in row.provenance["events"] for side in ("old", "new")}
    assert roles == set(rows) - {"run"}
    assert twins_of_event(STEP, 2) == ("3.5 kg sand stays", "constant 1.5 kg")


def test_the_old_load_twin_agrees_to_the_bit_until_the_event(judged):
    """State at the event's own tick included; from the next one on the load tells."""
    row, _, (up, down) = judged()
    assert [note["status"] for note in row.provenance["events"]] == ["ok", "ok"]
    tick = int(np.searchsorted(up.old.t, 0.5))
    assert not np.array_equal(up.old.q[tick + 1], up.new.q[tick + 1])
    assert np.array_equal(up.old.q[: tick + 1], down.new.q[: tick + 1])


def test_a_hidden_state_fails_the_event_and_not_the_run(judged):
    """A difference before the event would be counted as what the event did."""
    row, _, events = judged(Leaks)
    assert row.status == "ok"
    assert row.metrics["event@0.5"] == {"a5": {"status": "failed"}}
    assert "differs from the old-load twin at" in row.provenance["events"][0]["reason"]
    assert all(event.old is None and event.new is None for event in events)


def test_a_failed_twin_leaves_its_events_undefined_with_the_reason(judged):
    """The run's own row stands: its other windows are as good as ever."""
    row, rows, (up, down) = judged(FailsWithSandAtTheStart)
    assert (row.status, rows["constant 3.5 kg sand"].status) == ("ok", "failed")
    assert [note["status"] for note in row.provenance["events"]] == ["undefined", "ok"]
    assert up.reason.startswith("twin 'constant 3.5 kg sand' failed: torque of joint 1 is nan")
    assert (up.old, down.reason) == (None, "")
    assert row.metrics["event@0.5"] == {"a5": {"status": "undefined"}}


def test_a_failed_run_has_its_events_undefined_with_the_reason(judged):
    """No crash, and nothing that looks like a measurement."""
    row, _, events = judged(FailsUnderSand)
    assert (row.status, row.cause) == ("failed", "nan torque")
    assert all("the run failed: torque of joint 1 is nan" in event.reason for event in events)
    assert {row.metrics[window]["a5"]["status"] for window in ("event@0.5", "event@1.25")} == {"undefined"}


def test_a_run_that_never_began_has_no_events(judged):
    """There is no log that they could be windows of."""

    def refuse(self, task):
        return "needs eight joints"

    row, _, events = judged(type("Refuses", (Law,), {"supports": refuse}))
    assert (row.status, row.metrics, events) == ("refused", {}, [])


def test_an_event_after_the_end_is_undefined(judged):
    """``--set laps=1`` must not turn a campaign into errors."""
    late = LoadSchedule(entries=((0.0, LIGHT), (0.5, HEAVY), (9.0, LIGHT)))
    row, _, events = judged(schedule=late)
    assert events[0].until == pytest.approx(2.0)
    assert events[1].reason == "the run ends at 2 s"
    assert row.metrics["event@9"] == {"a5": {"status": "undefined"}}


@pytest.mark.parametrize("options", [{}, {"twins": False}], ids=["no callable", "no twins"])
def test_events_need_a_callable_and_twins(run_of, options):
    """Either may be left out; the run itself is the same."""
    (row, *_) = execute(
        run_of(schedule=STEP, **{"twins": True} | options), evaluate=nothing, traces="none", plug_ins={"mine": Law}
    )
    assert (row.status, row.metrics) == ("ok", {"run": {}})


def test_the_metrics_of_events_come_through_worker_processes(run_of, tmp_path):
    """Both callables are picklable, and a row with infinite recovery or a reason survives the way."""
    plug = tmp_path / "plug.py"
    plug.write_text(
        "class Law:\n"
        "    def reset(self, task):\n        self.robot = task.robot\n"
        "    def compute(self, o, t):\n"
        "        e = 400 * (t.q - o.q) + 40 * (t.dq - o.dq)\n"
        "        return self.robot.inverse_dynamics(o.q, o.dq, t.ddq + e)\n"
    )
    schedule = LoadSchedule(entries=((0.0, LIGHT), (2.0, HEAVY)))
    specification = run_of(controller=f"{plug}:Law", schedule=schedule, twins=True, laps=2)
    duty = Duty(evaluate=score, evaluate_events=score_events, traces="none", plug_ins={})
    ((_, rows),) = run_in_workers([specification], duty, workers=1)
    found = rows[0].metrics["event@2"]
    assert {value["status"] for value in found.values()} <= {"ok", "censored", "undefined"}
    assert found["excess_integral"]["value"] > 0.0
    assert rows[0].metrics["run"]["tcp_position_error_mean"]["status"] == "ok"
