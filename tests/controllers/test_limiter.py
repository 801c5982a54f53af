"""The shared limiter: what every controller's torque goes through."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from torquebench.controllers.limiter import EFFORT, RATE, limit_torque

JOINTS = 3
torques = arrays(float, JOINTS, elements=st.floats(-1e4, 1e4))
limits = arrays(float, JOINTS, elements=st.floats(1e-3, 1e3))


def limited(command, previous, effort, step):
    """Return the limited torque and the counters of one tick."""
    result, clipped = np.empty(JOINTS), np.zeros((2, JOINTS), dtype=np.int64)
    limit_torque(command, previous, effort, step, result, clipped)
    return result, clipped


@given(torques, torques, limits, limits)
def test_no_torque_exceeds_the_effort_limit_once_the_drive_is_within_it(command, previous, effort, step):
    """The rate limit works between two torques that are allowed, so it cannot leave the range again."""
    start = np.clip(previous, -effort, effort)
    result, _ = limited(command, start, effort, step)
    assert np.all(np.abs(result) <= effort * (1 + 1e-15))


@given(torques, torques, limits, limits)
def test_no_torque_changes_faster_than_the_rate_limit(command, previous, effort, step):
    """Even from a start beyond the effort limit: a drive cannot jump, whatever else is demanded of it."""
    result, _ = limited(command, previous, effort, step)
    rounding = 4 * np.spacing(np.maximum(np.abs(previous), np.abs(result)))
    assert np.all(np.abs(result - previous) <= step + rounding)


@given(torques, limits)
def test_a_command_within_both_limits_passes_unchanged_to_the_bit(command, step):
    """A limiter that touches allowed torques would be a controller."""
    effort = np.full(JOINTS, 1e4)
    previous = command - 0.25 * step
    result, clipped = limited(command, previous, effort, step)
    assert np.array_equal(result, command)
    assert not clipped.any()


@given(torques, torques, limits)
def test_without_a_rate_limit_only_the_effort_counts(command, previous, effort):
    """Tiers without a rate limit write infinity."""
    result, clipped = limited(command, previous, effort, np.full(JOINTS, np.inf))
    assert np.array_equal(result, np.clip(command, -effort, effort))
    assert np.array_equal(clipped[EFFORT], np.abs(command) > effort)
    assert not clipped[RATE].any()


@given(torques, torques, limits, limits)
def test_what_is_clipped_is_counted_by_cause_and_joint(command, previous, effort, step):
    """Saturation is a published figure; a joint may saturate for both reasons in one tick."""
    _, clipped = limited(command, previous, effort, step)
    inside = np.clip(command, -effort, effort)
    assert np.array_equal(clipped[EFFORT], np.abs(command) > effort)
    assert np.array_equal(clipped[RATE], np.abs(inside - previous) > step)


@given(torques, torques, limits, limits)
def test_limiting_twice_is_limiting_once(command, previous, effort, step):
    """The result is a torque that the limiter would allow."""
    once, _ = limited(command, np.clip(previous, -effort, effort), effort, step)
    twice, clipped = limited(once, once, effort, step)
    assert np.array_equal(once, twice)
    assert not clipped[RATE].any()


def test_the_result_may_overwrite_the_previous_command():
    """The harness keeps one buffer for both."""
    buffer, clipped = np.array([0.0, 10.0, -10.0]), np.zeros((2, 3), dtype=np.int64)
    limit_torque(np.array([5.0, 5.0, 5.0]), buffer, np.full(3, 20.0), np.full(3, 2.0), buffer, clipped)
    assert buffer.tolist() == [2.0, 8.0, -8.0]
    assert clipped.tolist() == [[0, 0, 0], [1, 1, 1]]


def test_counters_grow_from_tick_to_tick():
    """They are totals of a run, not of a tick."""
    result, clipped = np.zeros(3), np.zeros((2, 3), dtype=np.int64)
    for _ in range(5):
        limit_torque(np.array([30.0, 0.0, -30.0]), result, np.full(3, 20.0), np.full(3, np.inf), result, clipped)
    assert clipped[EFFORT].tolist() == [5, 0, 5]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_step_is_followed_on_a_ramp_of_the_rate_limit(sign):
    """100 N m at 2 N m a tick take fifty ticks, up and down alike."""
    result, clipped, path = np.zeros(1), np.zeros((2, 1), dtype=np.int64), []
    for _ in range(60):
        limit_torque(np.array([sign * 100.0]), result, np.full(1, 123.0), np.full(1, 2.0), result, clipped)
        path.append(result[0])
    assert np.allclose(path, sign * np.minimum(2.0 * np.arange(1, 61), 100.0), rtol=0, atol=1e-12)
    assert clipped[RATE, 0] == 49
