"""Laws of symmetry: what the choice of a frame, a unit, a clock or a direction of time may and may not change."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from torquebench.evaluation.metrics import CONSTANTS, METRICS

LOG_METRICS = [m for m in METRICS.values() if m.kind == "log"]
TOOL = [m.id for m in LOG_METRICS if "p" in m.needs]
LENGTHS = [name for name in TOOL if METRICS[name].unit == "m"]
TIMES = [m.id for m in LOG_METRICS if m.unit == "s"]
JOINTS = ("q", "q_ref", "dq", "tau", "tau_cmd", "tau_lim", "effort", "torque_rate", "velocity", "lower", "upper")

some = settings(max_examples=8, deadline=None)


def first_lap(log, found):
    """Return what a metric needs of the first lap."""
    return {n: getattr(log, n) if n in CONSTANTS else getattr(log, n)[1000:2000] for n in found.needs}


def turned(fields, rotation, shift):
    """Return the same motion seen from another base frame."""
    seen = dict(fields)
    for name in ("p", "p_ref"):
        seen[name] = rotation.apply(fields[name]) + shift
    if "twist_ref" in fields:
        halves = np.split(fields["twist_ref"], 2, axis=1)
        seen["twist_ref"] = np.hstack([rotation.apply(half) for half in halves])
    return seen


@pytest.mark.parametrize("metric_id", TOOL)
@some
@given(seed=st.integers(0, 2**32 - 1))
def test_the_base_frame_is_a_choice(metric_id, seed, arm):
    """Bolting the arm elsewhere, at any angle, changes no error of its tool."""
    rng = np.random.default_rng(seed)
    found = METRICS[metric_id]
    fields = first_lap(arm(), found)
    seen = turned(fields, Rotation.random(rng=rng), rng.normal(size=3))
    assert found(**seen) == pytest.approx(found(**fields), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("metric_id", LENGTHS)
@some
@given(factor=st.floats(0.5, 20.0))
def test_lengths_scale_with_the_motion(metric_id, factor, arm):
    """A motion twice as large, flown as badly, is twice as wrong."""
    found = METRICS[metric_id]
    fields = first_lap(arm(), found)
    larger = {n: factor * f if n in ("p", "p_ref", "twist_ref") else f for n, f in fields.items()}
    assert found(**larger) == pytest.approx(factor * found(**fields), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("metric_id", TIMES)
def test_lags_scale_with_the_clock(metric_id, arm):
    """The same samples at half the period are late by half the time, within the longest shift."""
    found = METRICS[metric_id]
    fields = first_lap(arm(), found)
    faster = {**fields, "dt": 0.5 * fields["dt"]}
    assert found(**faster) == pytest.approx(0.5 * found(**fields), rel=1e-9)


@pytest.mark.parametrize("metric_id", TIMES)
def test_time_backwards_turns_late_into_early(metric_id, arm):
    """What followed now leads, by as much."""
    found = METRICS[metric_id]
    fields = first_lap(arm(), found)
    backwards = {n: f[::-1] if n not in CONSTANTS else f for n, f in fields.items()}
    assert found(**backwards) == pytest.approx(-found(**fields), abs=1e-6)


@pytest.mark.parametrize("metric_id", [m.id for m in LOG_METRICS if set(m.needs) & set(JOINTS)])
@some
@given(order=st.permutations(range(7)))
def test_the_order_of_the_joints_is_a_choice(metric_id, order, arm):
    """Every metric of joints is one of all joints together."""
    found = METRICS[metric_id]
    fields = first_lap(arm(), found)
    relabelled = {n: f[..., list(order)] if n in JOINTS else f for n, f in fields.items()}
    assert found(**relabelled) == pytest.approx(found(**fields), rel=1e-9)


@pytest.mark.parametrize("metric_id", [m.id for m in LOG_METRICS])
def test_a_second_like_the_first_changes_little(metric_id, arm):
    """No metric counts laps: the same lap flown twice has the value of one, but for the ends."""
    if METRICS[metric_id].unit == "N m s":
        pytest.skip("an impulse is a sum over time and doubles")
    found = METRICS[metric_id]
    once = first_lap(arm(), found)
    twice = {n: f if n in CONSTANTS else np.concatenate([f, f]) for n, f in once.items()}
    assert found(**twice) == pytest.approx(found(**once), rel=0.05, abs=1e-3)


def test_an_impulse_is_a_sum_over_time(arm):
    """The exception to the law above, exactly."""
    found = METRICS["clip_impulse"]
    once = first_lap(arm(), found)
    twice = {**once, "tau_cmd": np.concatenate([once["tau_cmd"]] * 2)}
    assert found(**twice) == pytest.approx(2.0 * found(**once))


@pytest.mark.parametrize("radius", [0.02, 0.14, 0.3])
@pytest.mark.parametrize("period", [2.0, 4.0, 8.0])
def test_a_late_circle_has_its_closed_forms_at_every_size_and_speed(circle, radius, period):
    """Chord, sine, versed sine and nothing: position, along, across and contour."""
    log = type(circle)("circle", radius, period).followed_with(delay=0.025)
    angle = 2.0 * math.pi * 0.025 / period
    fields = vars(log)
    expected = {
        "tcp_position_error_mean": 2.0 * radius * math.sin(angle / 2.0),
        "along_track_error_mean": -radius * math.sin(angle),
        "cross_track_error_mean": radius * (1.0 - math.cos(angle)),
        "contour_error_mean": 0.0,
        "time_lag": 0.025,
    }
    for name, value in expected.items():
        found = METRICS[name]
        assert found(**{n: fields[n] for n in found.needs}) == pytest.approx(value, abs=1e-8)
