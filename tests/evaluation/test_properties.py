"""Laws between metrics, on motions that nobody chose: what holds for every log holds for the registry as a whole."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from torquebench.evaluation import compare, evaluate
from torquebench.evaluation.metrics import METRICS
from torquebench.evaluation.metrics.geometry import rotation_vectors

some = settings(max_examples=12, deadline=None)
seeds = st.integers(0, 2**32 - 1)
sizes = st.integers(1, 8)

DT, LAP, LAPS = 4e-3, 1.0, 3
TICKS = round(LAPS * LAP / DT)


def wander(rng, width, size):
    """Return a smooth motion of random harmonics that closes after each lap."""
    angle = 2.0 * np.pi * np.arange(TICKS)[:, None, None] * DT / LAP * np.arange(1, 4)
    amplitude, phase = rng.normal(size=(width, 3)) / np.arange(1, 4) ** 2, rng.uniform(0.0, 6.0, (width, 3))
    return size * (amplitude * np.sin(angle + phase)).sum(axis=2)


def random_log(seed, joints=3):
    """Return a log of an arm that does something near its plan, with noise on all of it."""
    rng = np.random.default_rng(seed)
    q_ref, p_ref, turn = wander(rng, joints, 0.4), wander(rng, 3, 0.2), wander(rng, 3, 0.5)
    q, p = (plan + wander(rng, plan.shape[1], 0.02) + 1e-4 * rng.normal(size=plan.shape) for plan in (q_ref, p_ref))
    tau = wander(rng, joints, 20.0) + 0.1 * rng.normal(size=(TICKS, joints))
    twist_ref = np.gradient(np.hstack([p_ref, turn]), DT, axis=0)
    attitude = Rotation.from_rotvec(turn)
    return SimpleNamespace(
        t=np.arange(TICKS) * DT,
        dt=DT,
        lap=LAP,
        mass=2.5,
        q=q,
        q_ref=q_ref,
        dq=np.gradient(q, DT, axis=0),
        dq_ref=np.gradient(q_ref, DT, axis=0),
        tau=tau,
        tau_cmd=tau,
        tau_lim=tau,
        p=p,
        p_ref=p_ref,
        quat=(attitude * Rotation.from_rotvec(wander(rng, 3, 0.02))).as_quat(),
        quat_ref=attitude.as_quat(),
        twist=twist_ref + 0.01 * rng.normal(size=twist_ref.shape),
        twist_ref=twist_ref,
        effort=np.full(joints, 15.0),
        torque_rate=np.full(joints, 8000.0),
        velocity=np.full(joints, 2.0),
        lower=np.full(joints, -2.0),
        upper=np.full(joints, 2.0),
    )


def values_of(log):
    """Return the values of a log's run window by metric."""
    return {name: value.value for name, value in evaluate(log, windows=("run",))["run"].items()}


@some
@given(seed=seeds, joints=sizes)
def test_a_mean_is_at_most_the_rms_and_that_at_most_the_largest(seed, joints):
    """Of every quantity that has them."""
    found = values_of(random_log(seed, joints))
    families = (
        "joint_error",
        "tcp_position_error",
        "tcp_orientation_error",
        "joint_velocity_error",
        "cross_track_error",
    )
    for name in families:
        assert found[f"{name}_mean"] <= found[f"{name}_rms"] * (1.0 + 1e-12)
    for name in ("tcp_position_error", "tcp_orientation_error"):
        assert found[f"{name}_rms"] <= found[f"{name}_max"]
    for name in ("tcp_position_error", "tcp_orientation_error", "contour_error"):
        assert found[f"{name}_p95"] <= found[f"{name}_max"]


@some
@given(seed=seeds)
def test_parts_of_the_position_error_make_up_the_whole(seed):
    """Along and across as squares; the contour is never further than the reference; lag never more than all."""
    found = values_of(random_log(seed))
    parts = found["along_track_error_rms"] ** 2 + found["cross_track_error_rms"] ** 2
    assert parts == pytest.approx(found["tcp_position_error_rms"] ** 2)
    assert found["contour_error_mean"] <= found["tcp_position_error_mean"]
    assert found["contour_error_max"] <= found["tcp_position_error_max"]
    assert 0.0 <= found["lag_share"] <= 1.0


@some
@given(seed=seeds)
def test_energies_and_saturation_add_up(seed):
    """Net + both ways = twice what went in; shares are shares; a joint's limit holds for its share of effort."""
    found = values_of(random_log(seed))
    assert found["energy_net"] + found["energy_abs"] == pytest.approx(2.0 * found["energy_positive"])
    assert found["effort_torque_sq_weighted"] == pytest.approx(found["effort_torque_sq"] / 15.0**2)
    for name in ("clip_fraction", "torque_rate_clip_fraction", "velocity_limit_fraction", "success"):
        assert 0.0 <= found[name] <= 1.0


@some
@given(seed=seeds)
def test_a_quaternions_sign_is_no_attitude(seed):
    """q and -q are the same in every metric, tick by tick."""
    log = random_log(seed)
    before = values_of(log)
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(2, TICKS, 1))
    log.quat, log.quat_ref = signs[0] * log.quat, signs[1] * log.quat_ref
    for name, value in values_of(log).items():
        assert value == pytest.approx(before[name], rel=1e-9, nan_ok=True)


@some
@given(seed=seeds)
def test_a_mirror_changes_no_error(seed):
    """A left-handed twin of arm and tool is as precise, as fast and as smooth."""
    log = random_log(seed)
    before = values_of(log)
    for name in ("q", "q_ref", "dq", "dq_ref", "tau", "tau_cmd", "tau_lim"):
        setattr(log, name, -getattr(log, name))
    for name in ("p", "p_ref"):
        setattr(log, name, getattr(log, name) * [1.0, 1.0, -1.0])
    for name in ("twist", "twist_ref"):
        setattr(log, name, getattr(log, name) * [1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
    for name in ("quat", "quat_ref"):
        setattr(log, name, getattr(log, name) * [-1.0, -1.0, 1.0, 1.0])
    for name, value in values_of(log).items():
        if "euler" not in name:
            assert value == pytest.approx(before[name], rel=1e-6, abs=1e-12, nan_ok=True), name


@some
@given(seed=seeds)
def test_a_common_left_rotation_changes_no_angle(seed):
    """Attitudes are compared with each other, in no frame; none is more than pi from another."""
    rng = np.random.default_rng(seed)
    found, base = Rotation.random(64, rng=rng), Rotation.random(rng=rng)
    plan = Rotation.random(64, rng=rng)
    for name in ("tcp_orientation_error_mean", "tcp_orientation_error_max"):
        value = METRICS[name](found.as_quat(), plan.as_quat())
        assert 0.0 <= value <= math.pi
        assert METRICS[name]((base * found).as_quat(), (base * plan).as_quat()) == pytest.approx(value)


@some
@given(seed=seeds)
def test_rotation_vectors_are_those_of_scipy(seed):
    """Independent: SciPy's rotations, in the reference's axes."""
    rng = np.random.default_rng(seed)
    found, plan = Rotation.random(64, rng=rng), Rotation.random(64, rng=rng)
    expected = (plan.inv() * found).as_rotvec()
    assert rotation_vectors(found.as_quat(), plan.as_quat()) == pytest.approx(expected, abs=1e-9)
    assert np.abs(rotation_vectors(plan.as_quat(), -plan.as_quat())).max() < 1e-12


@some
@given(seed=seeds)
def test_every_metric_has_a_second_way_to_its_number(seed):
    """Independent formulas in plain NumPy for those that have one."""
    log = random_log(seed)
    found = values_of(log)
    error, speed = log.q_ref - log.q, [np.linalg.norm(t[:, :3], axis=1) for t in (log.twist, log.twist_ref)]
    power_steps = [(log.tau[k] * (log.q[k + 1] - log.q[k])) for k in range(TICKS - 1)]
    path = sum(math.dist(a, b) for a, b in zip(log.p[:-1], log.p[1:], strict=True))
    expected = {
        "joint_error_mean": np.mean([math.hypot(*row) for row in error]),
        "joint_error_last_lap": np.mean([math.hypot(*row) for row in error[-250:]]),
        "joint_error_final": np.mean([math.hypot(*row) for row in error[-50:]]),
        "tcp_position_error_final": np.mean(
            [math.dist(a, b) for a, b in zip(log.p[-50:], log.p_ref[-50:], strict=True)]
        ),
        "joint_velocity_error_rms": np.linalg.norm(log.dq_ref - log.dq) / math.sqrt(TICKS),
        "velocity_error_ratio": np.linalg.norm(log.dq_ref - log.dq) / np.linalg.norm(log.dq_ref),
        "tcp_speed_error_mean": np.abs(speed[1] - speed[0]).mean(),
        "energy_positive": sum(step[step > 0.0].sum() for step in power_steps),
        "energy_per_path": sum(step[step > 0.0].sum() for step in power_steps) / (path * 2.5),
        "effort_torque_sq": np.square(log.tau).sum() * DT,
    }
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-9), name


@some
@given(seed=seeds)
def test_who_is_compared_with_whom_inverts_the_ratio(seed, grid):
    """gmr(A, B) gmr(B, A) = 1."""
    rng = np.random.default_rng(seed)
    both = grid.of("a", lambda *_: rng.uniform(0.01, 0.05)).of("b", lambda *_: rng.uniform(0.01, 0.05))
    one, other = (compare(both.rows, *pair, both.metric) for pair in (("a", "b"), ("b", "a")))
    assert one.gmr * other.gmr == pytest.approx(1.0)
