"""Joint impedance: the arm's own inertia between springs and dampers of one ratio."""

import numpy as np
import pytest
from torquebench.baselines.joint_impedance import JointImpedance, joint_damping


@pytest.mark.parametrize("arm", ["planar", "six", "seven"])
def test_an_unknown_load_deflects_each_spring(bench, load, arm):
    """The droop is K^-1 (g - g_model)."""
    arm, law = bench(arm), JointImpedance()
    arm.plant.set_payload(load(1.0, z=0.1))
    log = arm.run(law, 2.5)
    assert log.error[-1] == pytest.approx((arm.plant.gravity(log.q) - arm.model.gravity(log.q)) / law.springs, abs=1e-6)


def test_one_joint_has_the_damping_of_the_textbook():
    """D = 2 zeta sqrt(K M)."""
    damping = np.zeros((1, 1))
    joint_damping(np.array([[0.5]]), np.array([800.0]), 0.7, damping)
    assert damping[0, 0] == pytest.approx(1.4 * np.sqrt(400.0))


def test_equal_springs_give_every_mode_the_same_ratio(bench):
    """With K = k 1 the roots commute: the poles of M s^2 + D s + k lie on two rays, cos = zeta."""
    arm = bench()
    mass, damping = arm.model.mass_matrix(arm.plan.centre), np.zeros((7, 7))
    joint_damping(mass, np.full(7, 500.0), 0.6, damping)
    companion = np.block(
        [[np.zeros((7, 7)), np.eye(7)], [-500.0 * np.linalg.inv(mass), -np.linalg.solve(mass, damping)]]
    )
    poles = np.linalg.eigvals(companion)
    assert -poles.real / np.abs(poles) == pytest.approx(np.full(14, 0.6), abs=1e-6)


def test_the_damping_takes_energy_in_every_direction(bench):
    """Symmetric, and positive definite also where the springs differ by a factor of twenty."""
    arm, law = bench(), JointImpedance()
    law.reset(arm.task())
    damping = np.zeros((7, 7))
    joint_damping(arm.model.mass_matrix(arm.plan.centre), law.springs, 0.7, damping)
    assert damping == pytest.approx(damping.T)
    assert np.linalg.eigvalsh(damping).min() > 0.0


def test_on_the_plan_it_is_the_inverse_dynamics_of_the_plan(bench):
    """No error, no spring."""
    arm, law = bench(sway=0.3), JointImpedance()
    law.reset(arm.task())
    q, dq, ddq = arm.plan.joints(0.7)
    torque = law.compute(arm.observe(0.7, q, dq), arm.plan.target(0.7))
    assert torque == pytest.approx(arm.model.inverse_dynamics(q, dq, ddq), abs=1e-10)


def test_a_perfect_model_follows_the_plan(bench):
    """Feed-forward leaves nothing for the springs but the sampling."""
    assert np.abs(bench(sway=0.2).run(JointImpedance(), 2.0).error[-500:]).max() < 2e-3
