"""Laws of symmetry: what the choice of a frame, a unit, a clock or a direction of time may and may not change."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from torquebench.evaluation.metrics import CONSTANTS, METRICS

LOG_METRICS = [m for m in METRICS.values() if m.kind == "log"]
TOOL = [m.id for m in LOG_METRICS if {"p", "twist", "quat"} & set(m.needs) and "euler" not in m.id]
LENGTHS = [m.id for m in LOG_METRICS if "p" in m.needs and m.unit == "m"]
TIMES = [m.id for m in LOG_METRICS if m.family == "lag" and m.unit == "s"]
LIMITS = ("effort", "torque_rate", "velocity", "lower", "upper")
JOINTS = ("q", "q_ref", "dq", "dq_ref", "tau", "tau_cmd", "tau_lim", *LIMITS)
SUMS = ("clip_impulse", "effort_torque_sq", "effort_torque_sq_weighted", "energy_positive", "energy_net", "energy_abs")
"""What is summed over time: twice as long is twice as much."""
COUNTING = ("ldlj", "iso_path_repeatability_orientation", "iso_velocity_repeatability")
"""What knows how long or how often: a dimensionless jerk, and sample deviations of a few laps."""

some = settings(max_examples=8, deadline=None)


def laps_of(log, found, laps=2):
    """Return what a metric needs of the first laps."""
    rows = slice(1000, 1000 + 1000 * laps)
    return {n: getattr(log, n) if n in CONSTANTS else getattr(log, n)[rows] for n in found.needs}


def turned(fields, rotation, shift):
    """Return the same motion seen from another base frame."""
    seen = dict(fields)
    for name in ("p", "p_ref"):
        if name in fields:
            seen[name] = rotation.apply(fields[name]) + shift
    for name in {"twist", "twist_ref"} & set(fields):
        seen[name] = np.hstack([rotation.apply(half) for half in np.split(fields[name], 2, axis=1)])
    for name in {"quat", "quat_ref"} & set(fields):
        seen[name] = (rotation * Rotation.from_quat(fields[name])).as_quat()
    return seen


@pytest.mark.parametrize("metric_id", TOOL)
@some
@given(seed=st.integers(0, 2**32 - 1))
def test_the_base_frame_is_a_choice(metric_id, seed, arm):
    """Bolting the arm elsewhere, at any angle, changes no error of its tool."""
    rng = np.random.default_rng(seed)
    found = METRICS[metric_id]
    fields = laps_of(arm(), found)
    seen = turned(fields, Rotation.random(rng=rng), rng.normal(size=3))
    assert found(**seen) == pytest.approx(found(**fields), rel=1e-6, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("metric_id", LENGTHS)
@some
@given(factor=st.floats(0.5, 20.0))
def test_lengths_scale_with_the_motion(metric_id, factor, arm):
    """A motion twice as large, flown as badly, is twice as wrong."""
    found = METRICS[metric_id]
    fields = laps_of(arm(), found)
    larger = {n: factor * f if n in ("p", "p_ref", "twist_ref") else f for n, f in fields.items()}
    assert found(**larger) == pytest.approx(factor * found(**fields), rel=1e-6, abs=1e-12, nan_ok=True)


@pytest.mark.parametrize("metric_id", TIMES)
def test_lags_scale_with_the_clock(metric_id, arm):
    """The same samples at half the period are late by half the time, within the longest shift."""
    found = METRICS[metric_id]
    fields = laps_of(arm(), found, laps=1)
    faster = {**fields, "dt": 0.5 * fields["dt"]}
    assert found(**faster) == pytest.approx(0.5 * found(**fields), rel=1e-9)


@pytest.mark.parametrize("metric_id", TIMES)
def test_time_backwards_turns_late_into_early(metric_id, arm):
    """What followed now leads, by as much."""
    found = METRICS[metric_id]
    fields = laps_of(arm(), found, laps=1)
    backwards = {n: f[::-1] if n not in CONSTANTS else f for n, f in fields.items()}
    assert found(**backwards) == pytest.approx(-found(**fields), abs=1e-6)


@pytest.mark.parametrize("metric_id", [m.id for m in LOG_METRICS if set(m.needs) & set(JOINTS)])
@some
@given(order=st.permutations(range(7)))
def test_the_order_of_the_joints_is_a_choice(metric_id, order, arm):
    """Every metric of joints is one of all joints together."""
    found = METRICS[metric_id]
    fields = laps_of(arm(), found)
    relabelled = {n: f[..., list(order)] if n in JOINTS else f for n, f in fields.items()}
    assert found(**relabelled) == pytest.approx(found(**fields), rel=1e-9)


@pytest.mark.parametrize("metric_id", [m.id for m in LOG_METRICS if m.id not in SUMS + COUNTING])
def test_a_second_like_the_first_changes_little(metric_id, arm):
    """No metric counts laps: the same lap flown twice has the value of one, but for the ends."""
    found = METRICS[metric_id]
    once = laps_of(arm(), found)
    twice = {n: f if n in CONSTANTS else np.concatenate([f, f]) for n, f in once.items()}
    assert found(**twice) == pytest.approx(found(**once), rel=0.05, abs=1e-3, nan_ok=True)


@pytest.mark.parametrize("metric_id", SUMS)
def test_a_sum_over_time_doubles(metric_id, arm):
    """The exception to the law above; the step between the laps is one more."""
    found = METRICS[metric_id]
    once = laps_of(arm(), found)
    twice = {n: f if n in CONSTANTS else np.concatenate([f, f]) for n, f in once.items()}
    assert found(**twice) == pytest.approx(2.0 * found(**once), rel=2e-3, abs=0.1)


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
