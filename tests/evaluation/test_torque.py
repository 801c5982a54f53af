"""Laws of smoothness and saturation."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics import (
    clip_fraction,
    clip_fraction_by_joint,
    clip_impulse,
    position_limit_margin_min,
    torque_rate_clip_fraction,
    torque_rate_rms,
    torque_rate_rms_by_joint,
    torque_ripple,
    torque_total_variation,
    velocity_limit_fraction,
)

DT = 1e-3
SECOND = np.arange(1001) * DT
SINE = 10.0 * np.sin(2.0 * np.pi * SECOND)[:, None]


def test_the_torque_rate_of_a_sine_is_its_amplitude_times_its_frequency():
    """10 2 pi / sqrt 2 = 44.4288 N m/s."""
    assert torque_rate_rms(SINE, DT) == pytest.approx(44.4288, abs=1e-3)


def test_the_total_variation_of_a_sine_is_four_amplitudes_a_period():
    """40 N m/s, up and down and up."""
    assert torque_total_variation(SINE, DT) == pytest.approx(40.0, abs=1e-9)


def test_the_rates_of_joints_add_as_squares():
    """The scalar is the norm over joints."""
    tau = np.hstack([SINE, 2.0 * SINE, 0.0 * SINE])
    by_joint = torque_rate_rms_by_joint(tau, DT)
    assert by_joint == pytest.approx(44.4288 * np.array([1.0, 2.0, 0.0]), abs=1e-2)
    assert torque_rate_rms(tau, DT) == pytest.approx(np.linalg.norm(by_joint))


def test_a_constant_torque_is_smooth():
    """Holding a load is no chatter, however heavy."""
    tau = np.full((1001, 7), 40.0)
    assert torque_rate_rms(tau, DT) == 0.0
    assert torque_total_variation(tau, DT) == 0.0
    assert torque_ripple(tau, DT) == pytest.approx(0.0, abs=1e-9)


def test_ripple_keeps_what_is_fast_and_drops_what_is_slow():
    """100 Hz chatter passes, the 1 Hz motion does not; the ends of the log cost the filter 3 %."""
    t = np.arange(4000) * DT
    slow, fast = 10.0 * np.sin(2.0 * np.pi * t), 0.5 * np.sin(2.0 * np.pi * 100.0 * t)
    assert torque_ripple((slow + fast)[:, None], DT) == pytest.approx(0.5 / math.sqrt(2.0), rel=3e-2)
    assert torque_ripple(slow[:, None], DT) < 0.01 * 10.0


def test_ripple_needs_a_clock_that_holds_10_hz():
    """A log at 20 Hz cannot show it: NaN, not zero."""
    assert math.isnan(torque_ripple(SINE, 0.05))


def test_ripple_needs_ticks_for_the_ends_of_its_filter():
    """0.3 s at either end are continued from the log; it must hold as much."""
    assert math.isnan(torque_ripple(SINE[:300], DT))
    assert math.isfinite(torque_ripple(SINE[:301], DT))


def test_the_ends_of_the_filter_do_not_outweigh_the_ripple():
    """One lap of 1 s with 0.1 N m of noise on 20 N m of motion: the motion must not leak in at the ends."""
    t = np.arange(1000) * DT
    noise = 0.1 * np.random.default_rng(0).normal(size=(1000, 1))
    motion = 20.0 * np.cos(2.0 * np.pi * t + 1.0)[:, None]
    assert torque_ripple(motion + noise, DT) == pytest.approx(0.1, rel=0.25)


@pytest.mark.parametrize("metric", [torque_rate_rms, torque_total_variation])
def test_one_sample_has_no_rate(metric):
    """NaN, since a derivative takes two."""
    assert math.isnan(metric(SINE[:1], DT))


EFFORT = np.array([10.0, 5.0])


def test_equality_is_not_clipping():
    """A limiter that lands on the limit changed nothing."""
    assert clip_fraction(np.tile(EFFORT, (10, 1)), EFFORT) == 0.0
    assert velocity_limit_fraction(np.tile(EFFORT, (10, 1)), EFFORT) == 0.0


def test_a_tick_counts_once_however_many_joints_clip():
    """The share is of ticks; the vector says which joint."""
    tau_cmd = np.zeros((10, 2))
    tau_cmd[0] = [11.0, -6.0]
    tau_cmd[1] = [0.0, 6.0]
    assert clip_fraction(tau_cmd, EFFORT) == 0.2
    assert clip_fraction_by_joint(tau_cmd, EFFORT).tolist() == [0.1, 0.2]


def test_the_clipped_impulse_is_the_area_beyond_the_limit():
    """1 N m beyond for 10 ticks and 2 N m for 5: 0.02 N m s."""
    tau_cmd = np.zeros((100, 2))
    tau_cmd[:10, 0] = 11.0
    tau_cmd[:5, 1] = -7.0
    assert clip_impulse(tau_cmd, EFFORT, DT) == pytest.approx(0.02)


def limited(tau_cmd, rate, start=0.0):
    """Return what the shared limiter makes of commands of one joint: effort first, then rate."""
    out, previous = [], start
    for command in np.clip(tau_cmd, -EFFORT[0], EFFORT[0]):
        previous += np.clip(command - previous, -rate * DT, rate * DT)
        out.append(previous)
    return np.array(out)[:, None]


def test_a_step_is_rate_limited_until_the_limiter_has_caught_up():
    """8 N m at 1000 N m/s takes eight ticks; the last lands on the command and is not clipped."""
    tau_cmd = np.concatenate([[0.0], np.full(19, 8.0)])
    clipped = torque_rate_clip_fraction(tau_cmd[:, None], limited(tau_cmd, 1000.0), EFFORT[:1], np.array([1000.0]), DT)
    assert clipped == pytest.approx(7.0 / 19.0)


def test_a_ramp_at_the_rate_limit_is_not_clipped():
    """Rounding of the sums must not count."""
    tau_cmd = np.arange(100) * 0.1
    clipped = torque_rate_clip_fraction(tau_cmd[:, None], limited(tau_cmd, 100.0), EFFORT[:1], np.array([100.0]), DT)
    assert clipped == 0.0


def test_a_command_beyond_the_effort_limit_is_not_also_beyond_the_rate():
    """Causes are counted apart: held at the limit, nothing changes any more."""
    tau_cmd = np.full(50, 100.0)
    lim = limited(tau_cmd, 1000.0, start=10.0)
    assert torque_rate_clip_fraction(tau_cmd[:, None], lim, EFFORT[:1], np.array([1000.0]), DT) == 0.0
    assert clip_fraction(tau_cmd[:, None], EFFORT[:1]) == 1.0


def test_one_tick_has_no_previous_command():
    """NaN, since a change takes two."""
    one = np.zeros((1, 2))
    assert math.isnan(torque_rate_clip_fraction(one, one, EFFORT, np.full(2, 1e3), DT))


def test_the_margin_is_to_the_nearest_limit_of_any_joint():
    """0.1 rad below the upper limit of the second joint, at its furthest."""
    q = np.array([[0.0, 0.0], [0.5, 0.9], [-0.5, 0.0]])
    assert position_limit_margin_min(q, np.array([-1.0, -1.0]), np.array([1.0, 1.0])) == pytest.approx(0.1)


def test_beyond_a_limit_the_margin_is_negative():
    """How far beyond matters to whoever looks for the cause."""
    assert position_limit_margin_min(np.array([[1.2]]), np.array([-1.0]), np.array([1.0])) == pytest.approx(-0.2)


def test_an_arm_without_limits_has_no_margin():
    """A continuous joint has none; infinity would win every table."""
    free = np.array([np.inf])
    assert math.isnan(position_limit_margin_min(np.array([[1.2]]), -free, free))


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 10.0))
def test_torque_metrics_scale_with_the_torque(seed, factor):
    """Twice the chatter is twice the number: they are norms."""
    tau = np.random.default_rng(seed).normal(size=(320, 3))
    for metric in (torque_rate_rms, torque_total_variation, torque_ripple):
        assert metric(factor * tau, DT) == pytest.approx(factor * metric(tau, DT), rel=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_the_torques_sign_is_a_convention(seed):
    """Mirroring every joint's axis changes no smoothness and no saturation."""
    tau = 10.0 * np.random.default_rng(seed).normal(size=(64, 2))
    assert torque_rate_rms(-tau, DT) == torque_rate_rms(tau, DT)
    assert clip_fraction(-tau, EFFORT) == clip_fraction(tau, EFFORT)
    assert clip_impulse(-tau, EFFORT, DT) == clip_impulse(tau, EFFORT, DT)
