"""Laws of the joint and tool-point errors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from torquebench.evaluation.metrics import (
    error_by_lap,
    joint_error_mean,
    joint_error_norm_series,
    joint_error_rms,
    joint_error_rms_by_joint,
    joint_error_rms_per_joint,
    orientation_error_by_lap,
    tcp_position_error_last_lap,
    tcp_position_error_max,
    tcp_position_error_mean,
    tcp_position_error_p95,
    tcp_position_error_rms,
)

PAPER_Q = -1e-3 * np.array([[3, 4, 0, 0, 0, 0, 0], [10] * 7], dtype=float)
PAPER_Q_REF = np.zeros((2, 7))

metres = st.floats(-1.0, 1.0, allow_nan=False)
joint_motions = st.tuples(st.integers(1, 12), st.integers(1, 9)).flatmap(
    lambda shape: st.tuples(arrays(float, shape, elements=metres), arrays(float, shape, elements=metres))
)
tool_motions = st.integers(1, 12).flatmap(
    lambda n: st.tuples(arrays(float, (n, 3), elements=metres), arrays(float, (n, 3), elements=metres))
)


def test_the_error_series_is_the_norm_over_joints():
    """The paper's RMSE(t) is a norm at one tick, not an average over joints."""
    assert joint_error_norm_series(PAPER_Q, PAPER_Q_REF) == pytest.approx([0.005, 0.026457513])


def test_the_papers_rmse_is_a_mean_of_norms():
    """Confusing the two would shift every comparison with printed numbers."""
    assert joint_error_mean(PAPER_Q, PAPER_Q_REF) == pytest.approx(0.015728757, abs=1e-9)


def test_the_true_rms_is_the_root_of_the_mean_square():
    """It stands beside the paper's number, and bursts show in their ratio."""
    assert joint_error_rms(PAPER_Q, PAPER_Q_REF) == pytest.approx(0.019039433, abs=1e-9)


def test_the_rms_per_joint_is_the_rms_over_the_root_of_the_number_of_joints():
    """Arms of different size become comparable."""
    assert joint_error_rms_per_joint(PAPER_Q, PAPER_Q_REF) == pytest.approx(0.007196229, abs=1e-9)


def test_the_joints_squares_add_up_to_the_square_of_the_norm():
    """The vector and the scalar are two views of one error."""
    by_joint = joint_error_rms_by_joint(PAPER_Q, PAPER_Q_REF)
    assert by_joint.shape == (7,)
    assert np.sum(by_joint**2) == pytest.approx(joint_error_rms(PAPER_Q, PAPER_Q_REF) ** 2)


def test_an_offset_of_one_tick_is_visible(fast_circle):
    """At 0.44 m/s a tick is 0.44 mm: pairing a sample with the wrong reference is a bug that must show."""
    log = fast_circle.followed_with(delay=fast_circle.dt)
    one_tick = 2.0 * 0.14 * np.sin(np.pi * 0.0005)
    assert one_tick == pytest.approx(0.439823e-3, abs=1e-9)
    assert tcp_position_error_mean(log.p, log.p_ref) == pytest.approx(one_tick, abs=1e-12)
    assert tcp_position_error_max(log.p, log.p_ref) == pytest.approx(one_tick, abs=1e-12)


def test_a_constant_error_is_the_same_in_every_average(circle):
    """Mean, RMS, percentile and maximum differ by the spread alone."""
    log = circle.followed_with()
    shifted = log.p_ref + np.array([0.003, 0.0, 0.004])
    for metric in (tcp_position_error_mean, tcp_position_error_rms, tcp_position_error_p95, tcp_position_error_max):
        assert metric(shifted, log.p_ref) == pytest.approx(0.005, abs=1e-12)


def test_the_95th_percentile_ignores_a_short_burst():
    """One tick in a hundred must not set a percentile, and must set the maximum."""
    p_ref = np.zeros((101, 3))
    p = p_ref.copy()
    p[7, 2] = 1.0
    assert tcp_position_error_p95(p, p_ref) == 0.0
    assert tcp_position_error_max(p, p_ref) == 1.0


@given(joint_motions)
def test_the_mean_never_exceeds_the_rms(motion):
    """Jensen's inequality; a violation means that one of the two is something else."""
    q, q_ref = motion
    assert joint_error_mean(q, q_ref) <= joint_error_rms(q, q_ref) + 1e-12


@given(tool_motions)
def test_mean_rms_and_maximum_are_ordered(motion):
    """The order holds for every motion, so a table that breaks it is wrong."""
    p, p_ref = motion
    mean, rms, largest = (
        f(p, p_ref) for f in (tcp_position_error_mean, tcp_position_error_rms, tcp_position_error_max)
    )
    assert mean <= rms + 1e-12
    assert rms <= largest + 1e-12
    assert tcp_position_error_p95(p, p_ref) <= largest + 1e-12


@given(joint_motions, st.randoms())
def test_relabelling_the_joints_changes_no_norm(motion, random):
    """Which joint is called first is a convention of a description file."""
    q, q_ref = motion
    order = list(range(q.shape[1]))
    random.shuffle(order)
    for metric in (joint_error_mean, joint_error_rms, joint_error_rms_per_joint):
        assert metric(q[:, order], q_ref[:, order]) == pytest.approx(metric(q, q_ref), abs=1e-12)


@given(tool_motions)
def test_swapping_tool_and_reference_changes_no_distance(motion):
    """A distance has no direction."""
    p, p_ref = motion
    assert tcp_position_error_rms(p, p_ref) == pytest.approx(tcp_position_error_rms(p_ref, p), abs=1e-12)


def learning_tool(circle, errors):
    """A tool beside the circle by one constant distance in each lap."""
    lap = circle.followed_with().p_ref
    reference = np.vstack([lap] * len(errors))
    return reference + np.repeat(errors, len(lap))[:, None] * np.array([0.0, 0.0, 1.0]), reference


def test_the_error_of_each_lap_is_its_own(circle):
    """Who wins depends on how long one learns, so laps must not leak into each other."""
    p, p_ref = learning_tool(circle, [0.03, 0.02, 0.01])
    assert error_by_lap(p, p_ref, circle.period, circle.dt) == pytest.approx([0.03, 0.02, 0.01])


def test_a_lap_that_was_not_finished_has_no_error(circle):
    """Half a lap is another motion, and would look like learning."""
    p, p_ref = learning_tool(circle, [0.03, 0.02, 0.01])
    assert len(error_by_lap(p[:-10], p_ref[:-10], circle.period, circle.dt)) == 2


def test_laps_may_last_a_fraction_of_a_tick(circle):
    """A period such as 1/3 s drifts against the clock; the laps' number must not."""
    error = np.zeros((1000, 3))
    assert len(error_by_lap(error, error, 1.0 / 3.0, 1e-3)) == 3


def test_the_last_lap_is_the_settled_error(circle):
    """What remains after learning is a different question from the mean."""
    p, p_ref = learning_tool(circle, [0.03, 0.02, 0.01])
    assert tcp_position_error_last_lap(p, p_ref, circle.dt, circle.period) == pytest.approx(0.01)


def test_less_than_a_lap_has_no_last_lap(circle):
    """NaN says so; a mean over what there is would pass for a lap."""
    p, p_ref = learning_tool(circle, [0.03])
    assert np.isnan(tcp_position_error_last_lap(p[1:-1], p_ref[1:-1], circle.dt, circle.period))


def test_a_lap_with_a_sample_that_is_not_finite_is_nan_alone(circle):
    """The laps before a failure are still facts."""
    p, p_ref = learning_tool(circle, [0.03, 0.02, 0.01])
    p[4500] = np.nan
    laps = error_by_lap(p, p_ref, circle.period, circle.dt)
    assert np.isnan(laps).tolist() == [False, True, False]


def test_the_orientation_error_of_each_lap_is_its_own():
    """The same law for attitudes: 0.1 rad in the first lap, none in the second."""
    straight = np.array([0.0, 0.0, 0.0, 1.0])
    turned = np.array([0.0, 0.0, np.sin(0.05), np.cos(0.05)])
    quat = np.vstack([np.tile(turned, (100, 1)), np.tile(straight, (100, 1))])
    assert orientation_error_by_lap(quat, np.tile(straight, (200, 1)), 0.1, 1e-3) == pytest.approx([0.1, 0.0])
