"""Where studies and metrics meet: what counts as failed, and what loop records become."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.judging import JUDGES, LARGEST_ERROR, judge_loops, objection
from torquebench.scenarios.studies import LoopRecords

TICKS, DT = 2000, 1e-3


def log_of(*, joint=0.0, distance=0.0, start=-0.5):
    """Return a log whose joints and tool are off their plan by so much throughout."""
    zeros = np.zeros((TICKS, 7))
    limits = {"lower": np.full(7, -3.0), "upper": np.full(7, 3.0)}
    plan, tool = np.zeros((TICKS, 3)), np.zeros((TICKS, 3))
    tool[:, 0] = distance
    q = zeros.copy()
    q[:, 2] = joint
    return SimpleNamespace(t=np.arange(TICKS) * DT + start, dt=DT, q=q, q_ref=zeros, p=tool, p_ref=plan, **limits)


def test_a_run_that_stays_near_its_plan_is_come_through():
    """No objection, whatever the size of the error below the rule's."""
    assert objection(log_of(joint=0.9, distance=0.99 * LARGEST_ERROR)) == ""


def test_a_mean_position_error_above_a_tenth_of_a_metre_is_a_failure():
    """The figure stands in the objection."""
    assert objection(log_of(distance=0.15)) == "the mean position error is 150 mm"


def test_the_lead_in_is_no_part_of_the_mean_error():
    """An arm that has found its plan when the clock starts has come through its offset."""
    log = log_of()
    log.p[log.t < 0.0, 0] = 1.0
    assert objection(log) == ""


def test_an_arm_that_loses_its_plan_is_a_failure_at_any_time():
    """1 rad in the joints or a passed limit, within the lead-in too."""
    log = log_of()
    log.q[10, 0] = 1.01
    assert "1 rad" in objection(log)
    assert "limit" in objection(log_of(joint=3.1))


def records_of(loops, lines, rng, periods=3, samples=64):
    """Return records of a diagonal loop, the first period spoilt by a transient."""
    n = loops.shape[1]
    injection = rng.normal(size=(n, samples))
    outputs = np.zeros((n, samples // 2 + 1, n), complex)
    for j in range(n):
        closed = loops[:, j] / (1.0 + loops[:, j])
        outputs[j, lines, j] = -closed * np.fft.rfft(injection[j])[lines]
    commands = np.repeat(np.fft.irfft(outputs, n=samples, axis=1)[:, None], periods, axis=1)
    commands[:, 0] += rng.normal(size=commands[:, 0].shape)
    return LoopRecords(commands=commands, injection=injection, lines=lines, period=1e-3)


def test_every_joint_has_its_margins_and_all_of_them_a_bound(rng):
    """Integrators of 500 and 200 rad/s: 90 deg, pi / 2 over the crossover, and no gain margin in the band."""
    lines = np.arange(1, 31)
    omega = 2.0 * np.pi * lines / 0.064
    found = judge_loops(records_of(np.stack((500.0 / (1j * omega), 200.0 / (1j * omega)), axis=1), lines, rng)).metrics
    assert set(found) == {"loop 1", "loop 2", "loops"}
    assert found["loop 1"]["phase_margin"]["value"] == pytest.approx(90.0, rel=1e-3)
    assert found["loop 2"]["loop_delay_margin"]["value"] == pytest.approx(np.pi / 2 / 200.0, rel=5e-3)
    assert found["loop 1"]["gain_margin"]["status"] == "undefined"
    assert found["loop 1"]["scatter"]["value"] < 1e-12
    worst = min(found[name]["disk_margin"]["value"] for name in ("loop 1", "loop 2"))
    assert found["loops"]["multiloop_disk_margin"]["value"] == pytest.approx(worst)


def test_the_judges_go_to_worker_processes():
    """By name, like any function of a module."""
    assert pickle.loads(pickle.dumps(JUDGES)) == JUDGES
