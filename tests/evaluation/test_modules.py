"""Modules of the spiking controller: torques, weights, gains and spikes with a known answer."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics import (
    METRICS,
    equivalent_load,
    gain_correlation,
    gain_correlation_by_joint,
    gain_correlation_within_laps,
    gain_variation,
    gravity_torque_bias,
    gravity_torque_bias_by_joint,
    gravity_torque_nrmse,
    less_lap_mean,
    spike_rate,
    thalamus_weight_slope,
)

RNG = np.random.default_rng(3)
GRAVITY = RNG.normal(0.0, 20.0, (500, 7)) * np.array([0.0, 1, 1, 1, 0.3, 0.3, 0.0])
PER_KG = RNG.normal(0.0, 5.0, (500, 7))
T = np.arange(2000) * 1e-2


def test_a_torque_a_tenth_too_large_has_an_error_of_a_tenth():
    """A joint without gravity torque divides by nothing: the norm is over joints."""
    assert gravity_torque_nrmse(1.1 * GRAVITY, GRAVITY) == pytest.approx(0.1, abs=1e-12)
    assert math.isnan(gravity_torque_nrmse(GRAVITY, np.zeros_like(GRAVITY)))


def test_a_bias_is_found_joint_by_joint():
    bias = np.array([0.0, 0.3, 0.0, -0.4, 0.0, 0.0, 0.0])
    assert gravity_torque_bias_by_joint(GRAVITY + bias, GRAVITY) == pytest.approx(bias, abs=1e-12)
    assert gravity_torque_bias(GRAVITY + bias, GRAVITY) == pytest.approx(0.5)


def test_the_weight_grows_by_a_half_per_kilogram():
    assert thalamus_weight_slope(np.array([0.0, 0.5, 1.0]), np.array([1.0, 2.0, 3.0])) == pytest.approx(0.5)
    assert math.isnan(thalamus_weight_slope(np.array([0.0, 0.5, 0.6]), np.array([1.0, 2.0, 2.0])))


@given(st.floats(-1.0, 4.0))
def test_the_load_that_a_torque_is_right_for_is_recovered(mass):
    assert equivalent_load(GRAVITY + mass * PER_KG, GRAVITY, PER_KG) == pytest.approx(mass, abs=1e-9)


def test_a_load_that_exerts_no_torque_is_undefined():
    assert math.isnan(equivalent_load(GRAVITY, GRAVITY, np.zeros_like(GRAVITY)))


def test_gains_in_opposition_correlate_at_minus_one():
    stiffness, damping = (1.0 + sign * np.sin(T)[:, None] for sign in (1.0, -1.0))
    assert gain_correlation(stiffness, damping) == pytest.approx(-1.0)


def test_two_ramps_correlate_and_mean_nothing():
    """Noise on two ramps: the raw series says 1, within laps nothing is left."""
    ramps = [np.floor(T / 2.0)[:, None] + 0.1 * np.random.default_rng(s).normal(size=(2000, 3)) for s in (1, 2)]
    assert gain_correlation(*ramps) > 0.99
    assert abs(gain_correlation_within_laps(*ramps, 2.0, 1e-2)) < 0.1


def test_a_gain_that_does_not_change_has_no_correlation():
    """A joint at its clamp is left out, not counted as zero."""
    stiffness = np.stack([np.sin(T), np.full_like(T, 0.1)], axis=1)
    r = gain_correlation_by_joint(stiffness, np.stack([np.sin(T), np.cos(T)], axis=1))
    assert r[0] == pytest.approx(1.0)
    assert np.isnan(r[1])
    assert math.isnan(gain_correlation(stiffness[:, 1:], stiffness[:, :1]))
    assert METRICS["gain_correlation"].value_of({"stiffness": stiffness[:1], "damping": stiffness[:1]}).status == (
        "undefined"
    )


def test_every_whole_lap_loses_its_own_mean():
    series = np.repeat([[1.0], [5.0], [9.0]], 100, axis=0)
    assert less_lap_mean(series[:250], 1.0, 1e-2) == pytest.approx(np.zeros((200, 1)))
    assert len(less_lap_mean(series, 9.0, 1e-2)) == 0


def test_the_variation_is_that_of_the_middle_joint():
    swing = np.array([0.1, 0.2, 0.9])
    stiffness = 100.0 * (1.0 + swing * np.where(np.arange(1000) % 2, 1.0, -1.0)[:, None])
    assert gain_variation(stiffness) == pytest.approx(0.2)


def test_a_spike_in_every_second_step_is_a_rate_of_a_half():
    assert spike_rate(np.full(8, 50.0), 10, 80) == pytest.approx(0.5)
    assert math.isnan(spike_rate(np.zeros(3), 0, 80))
