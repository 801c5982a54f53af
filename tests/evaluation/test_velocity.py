"""Velocity tracking: closed forms of a sine that is early, and the final stretch of a motion."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics import (
    joint_error_final,
    joint_error_last_lap,
    joint_error_mean,
    joint_velocity_error_mean,
    joint_velocity_error_rms,
    tcp_angular_velocity_error_mean,
    tcp_orientation_error_final,
    tcp_position_error_final,
    tcp_speed_error_mean,
    tcp_velocity_error_mean,
    velocity_error_ratio,
)

DT = 1e-3
T = np.arange(1000)[:, None] * DT
W = 2.0 * np.pi


def late_by(delay):
    """Velocities of a joint that follows sin(W (t + delay)) with sin(W t)."""
    return W * np.cos(W * T), W * np.cos(W * (T + delay))


@pytest.mark.parametrize(("delay", "error"), [(0.01, 0.27911), (0.0, 0.0), (0.25, W)])
def test_a_delayed_sine_has_the_error_of_its_delay(delay, error):
    """W sqrt(2) sin(W delay / 2) for each joint; 10 ms of a 1 Hz sine are 0.27911 rad/s."""
    assert joint_velocity_error_rms(*late_by(delay)) == pytest.approx(error, abs=1e-5)


def test_the_ratio_is_free_of_amplitude_and_one_for_an_arm_that_rests():
    """What lets slow and fast motions be compared; a plan that rests has none."""
    dq, dq_ref = late_by(0.01)
    assert velocity_error_ratio(dq, dq_ref) == pytest.approx(2.0 * math.sin(W * 0.005))
    assert velocity_error_ratio(7.0 * dq, 7.0 * dq_ref) == pytest.approx(velocity_error_ratio(dq, dq_ref))
    assert velocity_error_ratio(0.0 * dq, dq_ref) == pytest.approx(1.0)
    assert math.isnan(velocity_error_ratio(dq, 0.0 * dq_ref))


@given(st.integers(0, 2**32 - 1))
def test_mean_and_rms_are_ordered_and_speed_is_never_worse_than_velocity(seed):
    """The reverse triangle inequality: a wrong direction is an error of velocity, not of speed."""
    rng = np.random.default_rng(seed)
    dq, dq_ref = rng.normal(size=(2, 30, 5))
    twist, twist_ref = rng.normal(size=(2, 30, 6))
    assert joint_velocity_error_mean(dq, dq_ref) <= joint_velocity_error_rms(dq, dq_ref) + 1e-12
    assert tcp_speed_error_mean(twist, twist_ref) <= tcp_velocity_error_mean(twist, twist_ref) + 1e-12
    order = rng.permutation(5)
    assert joint_velocity_error_mean(dq[:, order], dq_ref[:, order]) == pytest.approx(
        joint_velocity_error_mean(dq, dq_ref)
    )


def test_linear_and_angular_velocity_are_told_apart():
    """Linear stands before angular; a tool that flies backwards has the right speed."""
    ahead = np.tile([0.3, 0.4, 0.0, 0.0, 0.0, 0.2], (10, 1))
    back = np.tile([-0.3, -0.4, 0.0, 0.0, 0.0, 0.5], (10, 1))
    assert tcp_speed_error_mean(back, ahead) == pytest.approx(0.0)
    assert tcp_velocity_error_mean(back, ahead) == pytest.approx(1.0)
    assert tcp_angular_velocity_error_mean(back, ahead) == pytest.approx(0.3)


def test_the_final_error_is_that_of_the_last_fifth_of_a_second():
    """200 ticks of 1 ms, whatever came before; a shorter log has no end to speak of."""
    error = np.where(np.arange(1000) < 800, 9.0, 0.01)
    zero, off = np.zeros((1000, 3)), np.column_stack([error, 0.0 * error, 0.0 * error])
    turned = np.column_stack([np.sin(error / 2.0), 0 * error, 0 * error, np.cos(error / 2.0)])
    level = np.tile([0.0, 0.0, 0.0, 1.0], (1000, 1))
    for value in (
        tcp_position_error_final(off, zero, DT),
        joint_error_final(off, zero, DT),
        tcp_orientation_error_final(turned, level, DT),
    ):
        assert value == pytest.approx(0.01)
    assert math.isnan(joint_error_final(off[:199], zero[:199], DT))


def test_the_settled_joint_error_is_that_of_the_last_lap():
    """Laps of 0.25 s: the last 250 ticks, as for the tool."""
    q, q_ref = np.random.default_rng(4).normal(size=(2, 1000, 7))
    assert joint_error_last_lap(q, q_ref, DT, 0.25) == pytest.approx(joint_error_mean(q[750:], q_ref[750:]))
    assert math.isnan(joint_error_last_lap(q, q_ref, DT, 2.0))
