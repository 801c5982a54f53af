"""What the harness does around a controller's call: sensors, limiter, drive, log, in their order."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.scenarios.tick import (
    DIVERGED,
    NOT_FINITE,
    OVERSPEED,
    POSITION_LIMIT,
    RUNNING,
    begin_tick,
    end_tick,
    frame_dtype,
    memory_dtype,
    run_constants,
    start_memory,
    target_dtype,
)
from torquebench.scenarios.tiers import build_tier

PERIOD = 0.001
HELD = np.array([12.0, -3.0])
"""Gravity torque that holds the two-joint arm at the start [N m]."""
PLAIN = build_tier("plain", {"plain": {}}, np.zeros(2))


class Bench:
    """Sensors and drives of a two-joint arm on a bench: the test moves the arm and gives the commands."""

    def __init__(self, tier, *, latency=0, effort=100.0, velocity=5.0, bias=None, noise=None, ticks=400):
        n = 2
        self.constants = run_constants(
            tier,
            effort=np.full(n, effort),
            velocity=np.full(n, velocity),
            lower=np.full(n, -3.0),
            upper=np.full(n, 3.0),
            bias=np.zeros(6) if bias is None else bias,
            latency=latency,
        )
        self.noise = np.zeros((1, 6)) if noise is None else noise
        self.frame, self.target = np.zeros(1, frame_dtype(n)), np.zeros(1, target_dtype(n))
        self.memory = np.zeros(1, memory_dtype(n, delay=tier.delay_ticks))
        self.log, self.table = np.zeros(ticks, frame_dtype(n)), np.zeros(ticks, target_dtype(n))
        self.q, self.dq, self.wrench, self.k = np.zeros(n), np.zeros(n), np.zeros(6), 0
        self.theta, self.dtheta = self.q, self.dq
        self.state = (self.q, self.dq, self.theta, self.dtheta, self.wrench)

    def records(self):
        """Return what both kernels of a tick work on."""
        return {"frame": self.frame, "target": self.target, "memory": self.memory, "constants": self.constants}

    def start(self, q=(0.0, 0.0), wrench=None):
        """Hold the arm at a position."""
        self.q[:] = q
        self.wrench[:] = np.zeros(6) if wrench is None else wrench
        start_memory(self.memory, self.constants, self.theta, self.wrench, HELD)
        return self

    def sense(self):
        """Read the sensors."""
        begin_tick(k=self.k, **self.records(), table=self.table, state=self.state, noise=self.noise)
        return self.frame[0]

    def act(self, command, *, call=0):
        """Give a command, computed in some nanoseconds, and return the verdict."""
        self.frame["command"], self.frame["call_time"] = command, call
        verdict = end_tick(k=self.k, **self.records(), log=self.log)
        self.k += 1
        return verdict

    def tick(self, command, *, call=0):
        """Do a whole tick and return its row of the log."""
        self.sense()
        self.act(command, call=call)
        return self.log[self.k - 1]


def tier_with(**constants):
    """Return a plain tier with some flaws."""
    return replace(PLAIN, **constants)


def test_a_plain_drive_gives_the_command_in_the_same_tick():
    """No delay, no lag, no limit in the way: torque exact."""
    bench = Bench(PLAIN).start()
    row = bench.tick([5.0, -7.0])
    assert row["torque"].tolist() == row["limited"].tolist() == row["command"].tolist() == [5.0, -7.0]


@pytest.mark.parametrize("delay", [0, 1, 2, 5])
def test_a_delay_is_exactly_that_many_ticks(delay):
    """The command of tick k acts in tick k + d, before that the torque that held the arm."""
    bench = Bench(tier_with(delay_ticks=delay)).start()
    torques = np.array([bench.tick([k + 1.0, -k - 1.0])["torque"] for k in range(12)])
    assert np.array_equal(torques[:delay], np.tile(HELD, (delay, 1)))
    assert torques[delay:, 0].tolist() == list(range(1, 13 - delay))


@pytest.mark.parametrize("latency", [0, 1, 3])
def test_a_latency_is_exactly_that_many_ticks(latency):
    """Of the controller, not of the drive: the limiter sees the late command."""
    bench = Bench(PLAIN, latency=latency).start()
    rows = [bench.tick([k + 1.0, 0.0]) for k in range(10)]
    limited = np.array([row["limited"][0] for row in rows])
    assert limited[:latency].tolist() == [HELD[0]] * latency
    assert limited[latency:].tolist() == list(range(1, 11 - latency))


def test_latency_comes_before_the_limiter_and_the_limiter_before_the_delay():
    """Two ticks late, then clipped to 20, then one tick of delay."""
    bench = Bench(tier_with(delay_ticks=1), latency=2, effort=20.0).start()
    rows = [bench.tick([50.0, 0.0]) for _ in range(5)]
    assert [row["limited"][0] for row in rows] == [12.0, 12.0, 20.0, 20.0, 20.0]
    assert [row["torque"][0] for row in rows] == [12.0, 12.0, 12.0, 20.0, 20.0]
    assert bench.memory["clipped"][0, 0].tolist() == [3, 0]


def acting(bench, calls):
    """Return the tick whose command acts at each tick, -1 before any, for calls of some milliseconds."""
    rows = [bench.tick([k, 0.0], call=round(1e6 * call)) for k, call in enumerate(calls)]
    return [-1 if row["limited"][0] == HELD[0] else round(row["limited"][0]) for row in rows]


@pytest.mark.parametrize(("call", "late"), [(0.02, 0), (0.999, 0), (1.001, 1), (1.9, 1), (2.3, 2), (7.5, 7)])
def test_a_measured_command_is_late_by_the_whole_ticks_of_its_own_call(call, late):
    """A call that ends within its tick is on time, one of 2.3 ms comes two ticks late."""
    assert acting(Bench(PLAIN, latency="measured").start(), [call] * 11) == [-1] * late + list(range(11 - late))


def test_a_measured_command_never_replaces_a_newer_one():
    """One slow call among fast ones is never felt: when it ends, a newer command acts."""
    assert acting(Bench(PLAIN, latency="measured").start(), [0, 0, 3.5, 0, 0, 0, 0]) == [0, 1, 1, 3, 4, 5, 6]


def test_while_a_call_lasts_the_newest_finished_command_acts():
    """Call 2 ends in tick 6, call 3 in tick 5, call 4 in tick 9, call 5 in tick 7."""
    calls = [0, 0, 4.2, 2.2, 5.2, 2.2, 9, 9, 9, 9]
    assert acting(Bench(PLAIN, latency="measured").start(), calls) == [0, 1, 1, 1, 1, 3, 3, 5, 5, 5]


@given(calls=st.lists(st.floats(0.0, 12.0), min_size=1, max_size=30))
def test_whatever_the_calls_took_the_newest_that_has_ended_acts(calls):
    """The rule, computed again from all calls at every tick."""
    ends = [k + int(round(1e6 * call) * 1e-6) for k, call in enumerate(calls)]
    expected = [max((j for j in range(k + 1) if ends[j] <= k), default=-1) for k in range(len(calls))]
    # Torque 12 is the one that holds the arm: commands count from 20.
    bench = Bench(PLAIN, latency="measured").start()
    rows = [bench.tick([20.0 + k, 0.0], call=round(1e6 * call)) for k, call in enumerate(calls)]
    assert [round(row["limited"][0]) - 20 for row in rows] == [k if k >= 0 else -8 for k in expected]


def test_calls_that_end_within_their_tick_leave_every_bit_as_it_is(rng):
    """A fast controller's run does not depend on whether its latency is measured."""
    tier = tier_with(delay_ticks=1, torque_lag=0.0015, torque_rate=np.array([2000.0, 1000.0]))
    benches = Bench(tier).start(), Bench(tier, latency="measured").start()
    for command in rng.normal(scale=20.0, size=(50, 2)):
        plain, measured = (bench.tick(command, call=900_000) for bench in benches)
        assert plain.tobytes() == measured.tobytes()


def test_a_torque_step_follows_one_minus_the_exponential():
    """A first-order lag sampled exactly: 1 - exp(-t / T) at the end of each tick."""
    bench = Bench(tier_with(torque_lag=0.0015)).start()
    torques = np.array([bench.tick([40.0, 40.0])["torque"] for _ in range(15)])
    t = PERIOD * np.arange(1, 16)
    expected = HELD + (40.0 - HELD) * (1.0 - np.exp(-t[:, None] / 0.0015))
    assert np.allclose(torques, expected, rtol=0, atol=1e-12)


def test_the_rate_limit_starts_from_the_torque_that_holds_the_arm():
    """Not from zero: a run must not begin with a drop."""
    bench = Bench(tier_with(torque_rate=np.array([2000.0, 1000.0]))).start()
    rows = np.array([bench.tick([20.0, 3.0])["limited"] for _ in range(8)])
    assert rows[:, 0].tolist() == [14.0, 16.0, 18.0, 20.0, 20.0, 20.0, 20.0, 20.0]
    assert rows[:, 1].tolist() == [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0]
    assert bench.memory["clipped"][0, 1].tolist() == [3, 5]


def test_exact_sensors_show_the_state_to_the_bit():
    """The ideal tier."""
    bench = Bench(PLAIN).start()
    bench.q[:], bench.dq[:], bench.wrench[:] = [0.1, -0.2], [0.3, 0.4], np.arange(6.0)
    frame = bench.sense()
    assert np.array_equal(frame["q_measured"], bench.q)
    assert np.array_equal(frame["dq_measured"], bench.dq)
    assert np.array_equal(frame["wrench_measured"], bench.wrench)


@pytest.mark.parametrize("exact", [True, False])
def test_positions_are_measured_at_the_links_and_velocities_at_the_motors(exact):
    """Where a spring lies between; elsewhere both are one array."""
    bench = Bench(PLAIN if exact else tier_with(encoder_quantum=1e-9)).start()
    bench.theta, bench.dtheta = np.array([0.0, 0.0]), np.array([0.4, -0.2])
    bench.state = (bench.q, bench.dq, bench.theta, bench.dtheta, bench.wrench)
    bench.q[:], bench.theta[:], bench.dq[:] = (0.5, 0.6), PERIOD * bench.dtheta, (9.0, 9.0)
    seen = bench.sense()
    assert np.allclose(seen["q_measured"], [0.5, 0.6], rtol=0, atol=1e-6)
    assert np.allclose(seen["dq_measured"], [0.4, -0.2], rtol=0, atol=1e-3)
    assert np.array_equal(seen["dq"], [9.0, 9.0])


def test_an_encoder_reads_whole_quanta():
    """Never further from the truth than half of one."""
    quantum = 2 * np.pi / 2**10
    bench = Bench(tier_with(encoder_quantum=quantum)).start()
    for angle in np.linspace(-1.0, 1.0, 50):
        bench.q[:] = angle
        reading = bench.sense()["q_measured"]
        assert np.allclose(reading / quantum, np.round(reading / quantum), rtol=0, atol=1e-9)
        assert np.all(np.abs(reading - angle) <= 0.5 * quantum + 1e-15)


def test_velocity_is_the_filtered_difference_of_quantised_positions():
    """At constant speed the filter's step response, 1 - exp(-2 pi f t), apart from the quantisation."""
    speed, corner = 0.7, 150.0
    bench = Bench(tier_with(encoder_quantum=1e-12, velocity_filter_hz=corner)).start()
    readings = []
    for k in range(1, 20):
        bench.q[:] = speed * PERIOD * k
        readings.append(bench.sense()["dq_measured"][0])
    expected = speed * (1.0 - np.exp(-2 * np.pi * corner * PERIOD * np.arange(1, 20)))
    assert np.allclose(readings, expected, rtol=0, atol=1e-8)


def test_one_encoder_count_is_a_velocity_spike_of_the_filters_gain():
    """quantum / h through a gain of 1 - exp(-2 pi f h), then decaying: what low-speed noise looks like."""
    quantum, corner = 6e-6, 150.0
    bench = Bench(tier_with(encoder_quantum=quantum, velocity_filter_hz=corner)).start()
    bench.q[:] = quantum
    decay = np.exp(-2 * np.pi * corner * PERIOD)
    readings = [bench.sense()["dq_measured"][0] for _ in range(4)]
    assert np.allclose(readings, quantum / PERIOD * (1 - decay) * decay ** np.arange(4), rtol=1e-9, atol=0)


def test_a_velocity_filter_works_without_an_encoder_too():
    """A tier that publishes a filter must have it, or controllers design for a lag that is not there."""
    bench = Bench(tier_with(velocity_filter_hz=50.0)).start()
    bench.q[:], bench.dq[:] = 0.001, 1.0
    assert bench.sense()["dq_measured"][0] == pytest.approx(1.0 - np.exp(-2 * np.pi * 50.0 * PERIOD), rel=1e-12)


def test_at_rest_nothing_moves_in_the_sensors():
    """The start is at rest wherever it is: the encoder's memory begins there and the velocity reads zero."""
    bench = Bench(tier_with(encoder_quantum=6e-6, velocity_filter_hz=150.0)).start(q=(1.234567891, -0.5))
    assert not bench.sense()["dq_measured"].any()


def test_the_force_sensor_starts_settled_on_its_reading_with_bias():
    """A filter that started at zero would show a load growing in the first ticks."""
    bias, weight = np.array([0.5, -0.3, 0.2, 0.01, 0.02, -0.01]), np.array([0.0, 0.0, 34.335, 0.0, 0.0, 0.0])
    bench = Bench(tier_with(wrench_filter_hz=100.0), bias=bias).start(wrench=weight)
    for _ in range(5):
        frame = bench.tick(HELD)
        assert np.allclose(frame["wrench_measured"], weight + bias, rtol=0, atol=1e-12)
        assert np.array_equal(frame["wrench"], weight)


def test_a_load_step_passes_the_force_filter_as_a_first_order_lag():
    """1 - exp(-2 pi f t), the new load's first tick counting as one."""
    bench = Bench(tier_with(wrench_filter_hz=100.0)).start()
    bench.wrench[2] = 20.0
    readings = [bench.sense()["wrench_measured"][2] for _ in range(10)]
    expected = 20.0 * (1.0 - np.exp(-2 * np.pi * 100.0 * PERIOD * np.arange(1, 11)))
    assert np.allclose(readings, expected, rtol=0, atol=1e-12)


def test_force_noise_is_the_drawn_row_of_each_tick(rng):
    """All controllers of a repetition see the same noise at the same tick."""
    noise = rng.normal(size=(20, 6))
    bench = Bench(PLAIN, noise=noise).start()
    readings = np.array([bench.tick(HELD)["wrench_measured"] for _ in range(20)])
    assert np.allclose(readings, noise, rtol=0, atol=1e-15)


def test_a_row_of_the_log_is_the_state_before_its_torque_acts():
    """The torque of row k is on the way to the state of row k + 1: an off-by-one costs 0.44 mm at 0.44 m/s."""
    bench = Bench(PLAIN).start()
    for k in range(3):
        bench.q[:] = k
        bench.dq[:] = 0.1 * k
        bench.sense()
        bench.q[:] = 99.0
        bench.act([10.0 + k, 0.0])
    assert bench.log["q"][:3, 0].tolist() == [0.0, 1.0, 2.0]
    assert bench.log["torque"][:3, 0].tolist() == [10.0, 11.0, 12.0]


def test_the_plan_of_a_tick_is_its_row_of_the_table():
    """Row k at tick k."""
    bench = Bench(PLAIN).start()
    bench.table["q"][:, 0] = np.arange(400)
    for k in range(3):
        bench.sense()
        assert bench.target["q"][0, 0] == k
        bench.act(HELD)


@pytest.mark.parametrize("torque", [np.nan, np.inf, -np.inf])
def test_a_torque_that_is_no_number_ends_the_run(torque):
    """Before it reaches limiter or drive; the row shows it."""
    bench = Bench(PLAIN).start()
    bench.sense()
    assert bench.act([0.0, torque]) == NOT_FINITE
    assert not np.isfinite(bench.log["command"][0, 1])
    assert np.array_equal(bench.memory["previous"][0], HELD)


@pytest.mark.parametrize(
    ("q", "dq", "q_ref", "verdict"),
    [
        ([2.999, -2.999], [0.0, 0.0], [2.9, -2.9], RUNNING),
        ([3.001, 0.0], [0.0, 0.0], [2.9, 0.0], POSITION_LIMIT),
        ([0.0, -3.001], [0.0, 0.0], [0.0, -2.9], POSITION_LIMIT),
        ([0.0, 0.0], [19.99, 0.0], [0.0, 0.0], RUNNING),
        ([0.0, 0.0], [0.0, -20.01], [0.0, 0.0], OVERSPEED),
        ([0.7, 0.7], [0.0, 0.0], [0.0, 0.0], RUNNING),
        ([0.8, 0.8], [0.0, 0.0], [0.0, 0.0], DIVERGED),
        ([0.0, 0.0], [np.nan, 0.0], [0.0, 0.0], OVERSPEED),
        ([np.nan, 0.0], [0.0, 0.0], [0.0, 0.0], DIVERGED),
    ],
)
def test_what_ends_a_run_is_a_position_limit_twenty_radians_a_second_or_one_radian(q, dq, q_ref, verdict):
    """A state that is not a number never passes as a good one."""
    bench = Bench(PLAIN).start()
    bench.q[:], bench.dq[:], bench.table["q"][0] = q, dq, q_ref
    bench.sense()
    assert bench.act(HELD) == verdict


def test_a_velocity_limit_is_counted_and_never_fatal():
    """By joint, tick by tick."""
    bench = Bench(PLAIN, velocity=2.0).start()
    for speed in (1.9, 2.1, 2.2):
        bench.dq[:] = [speed, -2.5]
        bench.sense()
        assert bench.act(HELD) == RUNNING
    assert bench.memory["overspeed"][0].tolist() == [2, 3]


@pytest.mark.parametrize("latency", [0, 3, "measured"])
def test_a_tick_allocates_nothing(latency):
    """A thousand times a second: what a tick leaves behind is not measurable."""
    bench = Bench(tier_with(encoder_quantum=6e-6, delay_ticks=1), latency=latency)
    bench.start()
    command, records = bench.frame["command"][0], bench.records()

    def run(first, last):
        for k in range(first, last):
            begin_tick(k=k, **records, table=bench.table, state=bench.state, noise=bench.noise)
            command[:] = HELD
            end_tick(k=k, **records, log=bench.log)

    run(0, 50)
    tracemalloc.start()
    try:
        run(50, 100)
        before, _ = tracemalloc.get_traced_memory()
        run(100, 300)
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 1024
