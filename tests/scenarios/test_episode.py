"""One run: what a controller sees, what its failures become, what is left behind."""

import gc
import re
import signal
import time

import numpy as np
import pytest
from torquebench.controllers import Oracle
from torquebench.scenarios import episode as episodes
from torquebench.scenarios.loads import LoadSchedule, Payload

HEAVY = Payload(mass=3.5, material="sand")


def test_at_the_first_tick_command_and_torque_are_the_gravity_torque_of_arm_and_gripper(world_of, play, holds, rizon):
    """The plant's own buffers start at the true one, 3.5 kg in: showing it would give the load away."""
    world = world_of(schedule=LoadSchedule.constant(HEAVY), tier="actuated")
    start, true = world.plant.q.copy(), world.plant.gravity()
    outcome = play(world, holds)
    nominal = rizon.model().gravity(start)
    assert np.allclose(holds.seen[0]["command"], nominal, rtol=0, atol=1e-12)
    assert np.allclose(holds.seen[0]["torque"], nominal, rtol=0, atol=1e-12)
    assert np.allclose(outcome.log["torque"][0], true, rtol=0, atol=1e-12)
    assert np.abs(true - nominal).max() > 5.0


def test_an_arm_commanded_its_gravity_torque_holds_still(world_of, play, holds, plant_name):
    """At rest, ideal tier: what the model knows is what the plant has."""
    outcome = play(world_of(plant=plant_name, knowledge="oracle"), holds, Oracle())
    assert outcome.failure is None
    assert np.abs(outcome.log["q"] - outcome.log["q"][0]).max() < 1e-12


def test_it_holds_still_behind_real_drives_too(world_of, play, holds):
    """Delay, lag, friction, encoders: no kick in the first ticks."""
    outcome = play(world_of(tier="actuated", schedule=LoadSchedule.constant(HEAVY)), holds, Oracle())
    assert np.abs(outcome.log["q"] - outcome.log["q"][0]).max() < 1e-5
    assert not outcome.memory["clipped"].any()


def test_observations_run_on_the_plans_clock(world_of, play, holds):
    """Zero is the end of the lead-in, negative before, a millisecond apart to the last digit."""
    play(world_of(), holds)
    times = [float(seen["time"]) for seen in holds.seen]
    assert times == [round(-0.2 + 0.001 * k, 9) for k in range(100)]


def test_what_acted_last_is_what_is_shown_next(world_of, play, follows):
    """``command`` after the limiter, ``torque`` after delay and lag, both of the tick before."""
    log = play(world_of(tier="actuated"), follows).log
    for k in range(1, len(log)):
        assert np.array_equal(follows.seen[k]["command"], log["limited"][k - 1])
        assert np.array_equal(follows.seen[k]["torque"], log["torque"][k - 1])


def test_the_log_keeps_what_was_seen_and_what_was_true(world_of, play, follows):
    """Measured beside true, row by row."""
    log = play(world_of(tier="actuated"), follows).log
    for k in (0, 17, 99):
        assert np.array_equal(log["q_measured"][k], follows.seen[k]["q"])
        assert np.array_equal(log["wrench_measured"][k], follows.seen[k]["wrench"])
    assert np.abs(log["q_measured"] - log["q"]).max() < 6e-6
    assert not np.array_equal(log["q_measured"], log["q"])


def test_a_row_is_the_state_before_its_torque_acts(world_of, play, follows, rizon):
    """q of row k + 1 follows from q, dq and torque of row k by the plant's own equation."""
    world = world_of()
    log = play(world, follows).log
    model = rizon.model(rotor_inertia=world.tier.rotor_inertia)
    model.set_payload(world.truth.parameters)
    for k in (0, 50, 98):
        state = model.at(log["q"][k].copy(), log["dq"][k].copy())
        dq = log["dq"][k] + 0.001 * np.linalg.solve(state.mass_matrix, log["torque"][k] - state.bias)
        assert np.allclose(log["dq"][k + 1], dq, rtol=0, atol=1e-11)
        assert np.allclose(log["q"][k + 1], log["q"][k] + 0.001 * log["dq"][k + 1], rtol=0, atol=1e-15)


def test_the_oracle_follows_a_load_step_at_its_tick(world_of, play, follows, rizon):
    """From 1.5 to 3.5 kg at 10 ms into the lap: the model of that tick has the new load."""
    schedule = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.01, HEAVY)))
    world = world_of(seconds=0.25, schedule=schedule)
    known = []

    class Watches(type(follows)):
        def compute(self, observation, target):
            known.append((observation.time, self.robot.payload[0]))
            return super().compute(observation, target)

    watcher = Watches()
    play(world, watcher, Oracle())
    for when, mass in known:
        assert mass == pytest.approx(2.314 if when >= 0.01 else 0.314, abs=1e-12), when
    assert world.truth.revision == 1


def test_a_load_step_is_felt_in_the_same_tick(world_of, play, follows, holds):
    """Under no knowledge the run leaves that of the constant load at the event and not before."""
    step = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.01, HEAVY)))
    stepped, constant = (
        play(world_of(seconds=0.25, schedule=step), follows),
        play(world_of(seconds=0.25), holds_like(follows)),
    )
    same = np.all(stepped.log["q"] == constant.log["q"], axis=1)
    event = 210
    assert same[: event + 1].all()
    assert not same[event + 1 :].any()


def holds_like(controller):
    """Return a second controller of the same kind."""
    return type(controller)()


FAILURES = {
    "nan": (lambda k: np.where(np.arange(7) == 2, np.nan, 0.0), "nan torque", "torque of joint 3 is nan at -0.1"),
    "inf": (lambda k: np.full(7, np.inf), "nan torque", "torque of joint 1 is inf at"),
    "exception": (lambda k: np.zeros(7) * (1 // 0), "exception", "ZeroDivisionError: .* in <lambda>"),
    "short": (lambda k: np.zeros(3), "wrong shape", r"returned shape \(3,\), expected an array of shape \(7,\)"),
    "column": (lambda k: np.zeros((7, 1)), "wrong shape", r"returned shape \(7, 1\)"),
    "list": (lambda k: [0.0] * 7, "wrong shape", "returned list, expected"),
    "none": (lambda k: None, "wrong shape", "returned NoneType, expected"),
    "text": (lambda k: np.array(["0"] * 7), "exception", "TypeError: Cannot cast"),
    "complex": (lambda k: np.full(7, 1j), "exception", "TypeError: Cannot cast"),
    "fling": (lambda k: np.array([0, 0, 0, 0, 0, 0, 1e6]), "divergence", "joint 7 moves at 2.* rad/s"),
}


@pytest.mark.parametrize(("answer", "cause", "reason"), FAILURES.values(), ids=FAILURES)
def test_each_failure_has_a_cause_and_a_line(world_of, play, says, answer, cause, reason):
    """From the tenth tick on; the rows before it are kept, nothing is raised."""
    world = world_of()
    model = world.robot.model()
    sound = model.gravity(world.plant.q)
    outcome = play(world, says(lambda k: sound if k < 10 else answer(k)))
    assert outcome.failure is not None
    assert outcome.failure.cause == cause
    assert "\n" not in outcome.failure.reason
    assert re.search(reason, outcome.failure.reason), outcome.failure.reason
    assert 10 <= len(outcome.log) < 100


def test_a_joint_beyond_its_limit_ends_the_run_by_name(world_of, play, holds):
    """By how much, and when."""
    world = world_of()
    upper = world.robot.upper.copy()
    upper[3] = world.plant.q[3] - 0.002
    outcome = play(world, holds, upper=upper)
    assert outcome.failure.cause == "limit violation"
    assert outcome.failure.reason.startswith("joint 4 is 0.002 rad beyond its position limit at -0.200 s")
    assert len(outcome.log) == 1


def test_a_lost_plan_ends_the_run_at_one_radian(world_of, play, holds):
    """The arm stays, the plan goes on: T7 is 1 rad away within its lap."""
    outcome = play(world_of(seconds=4.2, trajectory="T7"), holds, Oracle())
    assert outcome.failure.cause == "divergence"
    assert "joint error norm 1" in outcome.failure.reason


def test_an_int_torque_is_a_torque(world_of, play, says):
    """A law may return whole numbers."""
    assert play(world_of(seconds=0.005), says(lambda k: np.zeros(7, dtype=int))).failure is None


def test_a_law_may_return_its_own_buffer(world_of, play, follows):
    """The harness copies at once: what the law does to it later changes no log."""
    buffer = np.zeros(7)

    class Reuses(type(follows)):
        def compute(self, observation, target):
            buffer[:] = super().compute(observation, target)
            return buffer

    reused, plain = play(world_of(), Reuses()), play(world_of(), follows)
    assert np.array_equal(reused.log["command"], plain.log["command"])


def test_inputs_cannot_be_written(world_of, play, says):
    """They are views of the harness's own record."""

    class Scribbles(says):
        def compute(self, observation, target):
            observation.q[0] = 0.0

    outcome = play(world_of(), Scribbles(None))
    assert outcome.failure.cause == "exception"
    assert "read-only" in outcome.failure.reason


def test_a_call_that_took_too_long_ends_the_run(world_of, play, says, monkeypatch):
    """Its row is kept with its time."""
    monkeypatch.setattr(episodes, "CALL_LIMIT", 0.3)

    def slow(k):
        time.sleep(0.36 if k == 3 else 0.0)
        return np.zeros(7)

    outcome = play(world_of(), says(slow))
    assert outcome.failure.cause == "time-out"
    assert outcome.failure.reason == "one call took 0.4 s, allowed 0.3 s"
    assert len(outcome.log) == 4
    assert outcome.log["call_time"][3] > 3.5e8


def test_a_call_that_does_not_return_is_ended_from_outside(world_of, play, says, monkeypatch):
    """An endless loop in Python; the alarm looks once a second."""
    monkeypatch.setattr(episodes, "CALL_LIMIT", 0.9)
    before = signal.getsignal(signal.SIGALRM)

    def hang(k):
        while k == 2:
            time.sleep(0.01)
        return np.zeros(7)

    outcome = play(world_of(), says(hang))
    assert outcome.failure.cause == "time-out"
    assert "did not return within 0.9 s (tick 2)" in outcome.failure.reason
    assert len(outcome.log) == 2
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_the_collector_is_paused_for_the_loop_and_no_longer(world_of, play, says):
    """A collection in the middle would be charged to whoever computes."""
    states = []

    def look(k):
        states.append(gc.isenabled())
        return np.zeros(7)

    play(world_of(seconds=0.003), says(look))
    assert states == [False] * 3
    assert gc.isenabled()


def test_latency_shifts_what_acts_by_its_ticks(run_of, world_of, play, says):
    """Applied by the harness to everyone, before the limiter."""
    outcome = play(world_of(latency=3), says(lambda k: np.full(7, 0.01 * k)))
    assert np.array_equal(outcome.log["limited"][3:, 0], outcome.log["command"][:-3, 0])


def test_measured_latency_is_that_of_the_wall_time_of_each_call(world_of, play, says):
    """A call that sleeps is late by what it slept; every row obeys its own times, whatever the machine did."""

    def slow(k):
        time.sleep(2.3e-3 if k == 20 else 0.0)
        return np.full(7, 0.01 * k)

    log = play(world_of(seconds=0.05, latency="measured"), says(slow)).log
    ends = np.arange(50) + (log["call_time"] * 1e-6).astype(int)
    assert ends[20] >= 22
    newest = [max((j for j in range(k + 1) if ends[j] <= k), default=-1) for k in range(50)]
    assert all(np.array_equal(log["limited"][k], log["command"][j]) for k, j in enumerate(newest) if j >= 0)


class TestDiagnostics:
    """What a controller shows of itself."""

    @pytest.fixture
    def shows(self, holds):
        """A controller that shows its tick."""

        class Shows(type(holds)):
            period = 1

            def reset(self, task):
                super().reset(task)
                self.tick = np.full(2, -1.0)

            def diagnostics(self):
                return {"tick": (self.tick, self.period)}

            def compute(self, observation, target):
                self.tick += 1
                return super().compute(observation, target)

        return Shows()

    @pytest.mark.parametrize("period", [1, 7, 100, 1000])
    def test_rows_are_copied_at_their_period(self, world_of, play, shows, period):
        """Tick 0, then every so many."""
        shows.period = period
        rows, every = play(world_of(), shows).diagnostics["tick"]
        assert every == period
        assert rows[:, 0].tolist() == list(range(0, 100, period))

    def test_a_failed_run_shows_no_tick_that_was_not_finished(self, world_of, play, shows):
        """A row of zeros would look like a value."""
        world = world_of()
        upper = world.robot.upper.copy()
        upper[3] = world.plant.q[3] - 0.002
        assert len(play(world, shows, upper=upper).diagnostics["tick"][0]) == 0

    @pytest.mark.parametrize("broken", [lambda: 1 // 0, lambda: {"x": (np.zeros(2), 0)}, lambda: {"x": np.zeros(3)}])
    def test_broken_diagnostics_are_a_failure_of_the_controller(self, world_of, play, shows, broken):
        """Not of the campaign."""
        shows.diagnostics = broken
        outcome = play(world_of(), shows)
        assert outcome.failure.cause == "exception"
        assert outcome.failure.reason.startswith("in diagnostics: ")
