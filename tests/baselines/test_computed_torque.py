"""Computed torque, feedback linearising: on the exact model every joint is a double integrator with two equal poles."""

import numpy as np
import pytest
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.gains import double_integrator_gains

H = 1e-3


@pytest.mark.parametrize("arm", ["planar", "seven"])
def test_errors_follow_the_placed_poles_exactly(bench, arm):
    """x_{k+1} = (A - B K) x_k in each joint, whatever the arm: the couplings are gone."""
    log = bench(arm).run(ComputedTorque(bandwidth=20.0), 0.2, offset=0.05)
    closed = np.array([[1.0, H], [0.0, 1.0]]) - np.array([[H * H], [H]]) @ [double_integrator_gains(20.0, H)]
    x, expected = np.array([0.05, 0.0]), []
    for _ in range(len(log.error)):
        expected.append(x[0])
        x = closed @ x
    assert log.error == pytest.approx(np.tile(np.array(expected)[:, None], log.error.shape[1]), abs=1e-10)


def test_errors_decay_critically_damped(bench):
    """In continuous time: e = e_0 (1 + w t) exp(-w t), no overshoot."""
    log = bench().run(ComputedTorque(bandwidth=20.0), 0.5, offset=0.05)
    t = H * np.arange(len(log.error))
    assert log.error[:, 0] == pytest.approx(0.05 * (1.0 + 20.0 * t) * np.exp(-20.0 * t), abs=0.05 * 0.01)
    assert log.error.min() > -1e-12


def test_a_moving_plan_is_followed(bench):
    """What is left is the integrator's half step."""
    log = bench(sway=0.2).run(ComputedTorque(), 0.5)
    assert np.abs(log.error).max() < 1e-3


def test_an_unknown_load_leaves_a_static_error(bench, load):
    """e = M^-1 (g - g_model) / k_p: halving the bandwidth quadruples it."""
    arm = bench()
    arm.plant.set_payload(load(2.0, z=0.1))
    log = arm.run(ComputedTorque(bandwidth=20.0), 2.0)
    unknown = arm.plant.gravity(log.q) - arm.model.gravity(log.q)
    expected = np.linalg.solve(arm.model.mass_matrix(log.q), unknown) / double_integrator_gains(20.0, H)[0]
    assert log.error[-1] == pytest.approx(expected, abs=1e-6)


def test_a_known_load_leaves_none(bench, load):
    """The law has no word about loads: the model it was handed knows."""
    arm = bench()
    for model in (arm.plant, arm.model):
        model.set_payload(load(2.0, z=0.1))
    assert np.abs(arm.run(ComputedTorque(), 0.3).error).max() < 1e-12


def test_a_known_disturbance_leaves_none(bench):
    """A torque of unknown origin, told as a torque: gravity of a load that no inertia explains."""
    arm = bench()
    for model in (arm.plant, arm.model):
        model.set_disturbance(np.linspace(-3.0, 3.0, 7))
    assert np.abs(arm.run(ComputedTorque(), 0.3).error).max() < 1e-12
