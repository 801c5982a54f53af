"""Effort and work at the joints: closed forms, and what the sums owe each other."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from torquebench.evaluation.metrics import (
    effort_torque_sq,
    effort_torque_sq_weighted,
    energy_abs,
    energy_net,
    energy_per_path,
    energy_positive,
)

DT = 1e-3
T = np.arange(1001)[:, None] * DT
W = 2.0 * np.pi
TORQUE = 10.0 * np.sin(W * (T + 0.5 * DT))
POSITION = np.sin(W * T) / W
"""A torque held over each tick and the joint that turns at cos(W t), one period of 1 s."""

motions = arrays(float, (20, 3), elements=st.floats(-50.0, 50.0))


def test_a_torque_in_quadrature_with_the_velocity_does_no_net_work():
    """10 sin against cos over a period: net 0, magnitude 10 / pi, half of it put in."""
    assert energy_net(TORQUE, POSITION) == pytest.approx(0.0, abs=1e-9)
    assert energy_abs(TORQUE, POSITION) == pytest.approx(10.0 / math.pi, rel=1e-5)
    assert energy_positive(TORQUE, POSITION) == pytest.approx(5.0 / math.pi, rel=1e-5)


def test_squared_torque_of_a_sine_is_half_its_square_by_the_second():
    assert effort_torque_sq(TORQUE[:-1], DT) == pytest.approx(50.0)
    assert effort_torque_sq_weighted(TORQUE[:-1], np.array([20.0]), DT) == pytest.approx(50.0 / 400.0)


def test_one_joint_at_its_limit_for_a_second_weighs_one_second():
    """Each joint by its own limit: a wrist motor counts as much as a shoulder's."""
    tau = np.column_stack([np.full(1000, 30.0), np.zeros(1000)])
    assert effort_torque_sq_weighted(tau, np.array([30.0, 5.0]), DT) == pytest.approx(1.0)


def test_work_against_a_spring_is_the_energy_it_stores():
    """The torque of tick k acts until row k + 1: the mean of two springs' torques is exact."""
    angle = np.linspace(0.0, 0.3, 50)[:, None]
    tau = np.vstack([40.0 * (angle[1:] + angle[:-1]) / 2.0, [[0.0]]])
    assert energy_net(tau, angle) == pytest.approx(0.5 * 40.0 * 0.3**2)


@given(motions, motions)
def test_net_is_put_in_less_taken_out_and_magnitudes_add(tau, q):
    """Signs, joint by joint: one joint's braking never pays for another's drive in the positive work."""
    positive, net, both = energy_positive(tau, q), energy_net(tau, q), energy_abs(tau, q)
    negative = energy_positive(-tau, q)
    assert net == pytest.approx(positive - negative, abs=1e-6)
    assert both == pytest.approx(positive + negative, abs=1e-6)
    assert 0.0 <= positive <= both + 1e-9


@given(motions, motions, st.permutations(range(3)))
def test_relabelling_joints_changes_no_effort(tau, q, order):
    """Sums over joints know no order."""
    order = list(order)
    limits = np.array([3.0, 5.0, 7.0])
    assert energy_positive(tau[:, order], q[:, order]) == pytest.approx(energy_positive(tau, q), abs=1e-6)
    assert effort_torque_sq(tau[:, order], DT) == pytest.approx(effort_torque_sq(tau, DT))
    weighted = effort_torque_sq_weighted(tau[:, order], limits[order], DT)
    assert weighted == pytest.approx(effort_torque_sq_weighted(tau, limits, DT))


def test_work_by_path_and_mass_divides_by_both_and_by_nothing_else():
    """Half a metre with two kilograms divides by one; a tool that rests or carries nothing has no such figure."""
    p = np.linspace(0.0, 0.5, len(T))[:, None] * np.array([0.6, 0.0, 0.8])
    assert energy_per_path(TORQUE, POSITION, p, 2.0) == pytest.approx(energy_positive(TORQUE, POSITION))
    assert math.isnan(energy_per_path(TORQUE, POSITION, 0.0 * p, 2.0))
    assert math.isnan(energy_per_path(TORQUE, POSITION, p, 0.0))
    assert math.isnan(energy_per_path(TORQUE, POSITION, p, math.nan))
