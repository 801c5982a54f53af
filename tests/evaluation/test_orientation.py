"""Laws of the attitude error."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from torquebench.evaluation.metrics import (
    tcp_orientation_error_euler_raw,
    tcp_orientation_error_euler_wrapped,
    tcp_orientation_error_last_lap,
    tcp_orientation_error_max,
    tcp_orientation_error_mean,
    tcp_orientation_error_p95,
    tcp_orientation_error_rms,
)
from torquebench.evaluation.metrics.geometry import roll_pitch_yaw, rotation_angles

GEODESIC = (
    tcp_orientation_error_mean,
    tcp_orientation_error_rms,
    tcp_orientation_error_p95,
    tcp_orientation_error_max,
)

seeds = st.integers(0, 2**32 - 1)


def about(axis, angle):
    """Return the quaternion of one rotation as a log of one tick."""
    return Rotation.from_rotvec(angle * np.asarray(axis, dtype=float)).as_quat()[None]


STRAIGHT, DOWN = about([1, 0, 0], 0.0), about([1, 0, 0], math.pi)
ALMOST_DOWN = about([1, 0, 0], -math.pi + 0.02)


def attitudes(seed, count=6):
    """Return random attitudes."""
    return Rotation.random(count, rng=np.random.default_rng(seed)).as_quat()


@pytest.mark.parametrize("metric", GEODESIC)
def test_a_turn_about_one_axis_is_its_angle(metric):
    """The closed form of the geodesic, whatever the average."""
    assert metric(about([0, 0, 1], 0.1), STRAIGHT) == pytest.approx(0.1, abs=1e-15)


@pytest.mark.parametrize("metric", GEODESIC)
def test_tool_down_against_itself_is_exactly_zero(metric):
    """The working attitude is the one where the arc-cosine and Euler forms break."""
    assert metric(DOWN, DOWN) == 0.0


def test_a_nanoradian_is_resolved():
    """The arc cosine of the trace returns 0 here."""
    assert tcp_orientation_error_mean(about([0, 1, 0], 1e-9), STRAIGHT) == pytest.approx(1e-9, rel=1e-6)


def test_the_wrapped_euler_form_survives_tool_down():
    """Rx(pi) and Rx(-pi + 0.02) are 0.02 rad apart."""
    assert tcp_orientation_error_euler_wrapped(ALMOST_DOWN, DOWN) == pytest.approx(0.02, abs=1e-12)


def test_the_raw_euler_form_does_not_survive_tool_down():
    """Why the paper's formula is not a metric here: the same 0.02 rad read 6.26 rad."""
    assert tcp_orientation_error_euler_raw(ALMOST_DOWN, DOWN) == pytest.approx(6.2631853, abs=1e-7)


def test_the_wrapped_euler_form_equals_the_geodesic_near_tool_down():
    """So printed numbers in the paper's form are comparable with the honest one there."""
    rng = np.random.default_rng(0)
    shaken = (Rotation.from_rotvec(0.01 * rng.normal(size=(2000, 3))) * Rotation.from_quat(DOWN[0])).as_quat()
    reference = np.tile(DOWN, (2000, 1))
    geodesic = tcp_orientation_error_mean(shaken, reference)
    assert tcp_orientation_error_euler_wrapped(shaken, reference) == pytest.approx(geodesic, rel=4e-3)


def test_the_raw_euler_form_is_wrong_by_a_radian_in_half_of_all_ticks():
    """The size of the trap, measured: noise of 10 mrad around tool-down."""
    rng = np.random.default_rng(0)
    shaken = (Rotation.from_rotvec(0.01 * rng.normal(size=(2000, 3))) * Rotation.from_quat(DOWN[0])).as_quat()
    raw = [tcp_orientation_error_euler_raw(tick[None], DOWN) for tick in shaken]
    assert np.mean(np.array(raw) > 1.0) == pytest.approx(0.5, abs=0.05)


@given(seeds)
def test_q_and_minus_q_are_the_same_attitude(seed):
    """A quaternion's sign is a choice of the simulator."""
    quat, reference = attitudes(seed), attitudes(seed + 1)
    assert tcp_orientation_error_mean(-quat, reference) == pytest.approx(tcp_orientation_error_mean(quat, reference))


@given(seeds)
def test_the_angle_is_scipys_magnitude(seed):
    """An independent implementation agrees on random attitudes."""
    quat, reference = attitudes(seed), attitudes(seed + 1)
    expected = (Rotation.from_quat(reference).inv() * Rotation.from_quat(quat)).magnitude()
    assert rotation_angles(quat, reference) == pytest.approx(expected, abs=1e-9)


@given(seeds)
def test_a_common_rotation_of_the_base_changes_no_angle(seed):
    """The error must not depend on where the arm is bolted."""
    quat, reference, base = attitudes(seed), attitudes(seed + 1), Rotation.from_quat(attitudes(seed + 2, 1)[0])
    turned = (base * Rotation.from_quat(quat)).as_quat(), (base * Rotation.from_quat(reference)).as_quat()
    assert tcp_orientation_error_rms(*turned) == pytest.approx(tcp_orientation_error_rms(quat, reference), abs=1e-9)


@given(seeds)
def test_no_angle_exceeds_half_a_turn(seed):
    """Beyond half a turn the other way round is shorter."""
    assert tcp_orientation_error_max(attitudes(seed), attitudes(seed + 1)) <= math.pi


@given(seeds)
def test_mean_rms_and_maximum_are_ordered(seed):
    """The same order as for positions."""
    mean, rms, _, largest = (metric(attitudes(seed), attitudes(seed + 1)) for metric in GEODESIC)
    assert mean <= rms + 1e-12
    assert rms <= largest + 1e-12


@given(seeds)
def test_roll_pitch_yaw_are_scipys_fixed_axes_angles(seed):
    """The convention is stated once and checked against a library that states it too."""
    quat = attitudes(seed)
    assert roll_pitch_yaw(quat) == pytest.approx(Rotation.from_quat(quat).as_euler("xyz"), abs=1e-7)


def test_the_last_lap_is_the_settled_angle():
    """What is left after learning, for attitudes."""
    quat = np.vstack([np.tile(about([0, 0, 1], 0.1), (100, 1)), np.tile(about([0, 0, 1], 0.02), (100, 1))])
    settled = tcp_orientation_error_last_lap(quat, np.tile(STRAIGHT, (200, 1)), 1e-3, 0.1)
    assert settled == pytest.approx(0.02, abs=1e-12)


def test_less_than_a_lap_has_no_settled_angle():
    """NaN, not the mean of what there is."""
    assert math.isnan(tcp_orientation_error_last_lap(STRAIGHT, STRAIGHT, 1e-3, 0.1))
