"""Computed torque feed-forward: the plan's inverse dynamics, with springs that never see the model."""

import numpy as np
import pytest
from torquebench.baselines.computed_torque_feedforward import ComputedTorqueFeedforward
from torquebench.baselines.gains import double_integrator_gains, smallest_effective_inertia


def test_on_the_plan_it_is_the_inverse_dynamics_of_the_plan(bench):
    """No error, no feedback."""
    arm, law = bench(sway=0.3), ComputedTorqueFeedforward()
    law.reset(arm.task())
    q, dq, ddq = arm.plan.joints(0.7)
    torque = law.compute(arm.observe(0.7, q, dq), arm.plan.target(0.7))
    assert torque == pytest.approx(arm.model.inverse_dynamics(q, dq, ddq), abs=1e-12)


def test_off_the_plan_each_joint_adds_its_own_spring_and_damper(bench):
    """I_j (k_p e_j + k_d de_j): diagonal, whatever the arm's couplings."""
    arm, law = bench(sway=0.3), ComputedTorqueFeedforward(bandwidth=30.0)
    law.reset(arm.task())
    q, dq, ddq = arm.plan.joints(0.7)
    error, error_rate = np.linspace(-0.1, 0.1, 7), np.linspace(0.5, -0.5, 7)
    torque = law.compute(arm.observe(0.7, q - error, dq - error_rate), arm.plan.target(0.7))
    k_p, k_d = double_integrator_gains(30.0, 1e-3)
    inertia = smallest_effective_inertia(arm.model, arm.plan)
    expected = arm.model.inverse_dynamics(q, dq, ddq) + inertia * (k_p * error + k_d * error_rate)
    assert torque == pytest.approx(expected, abs=1e-10)


def test_an_unknown_load_deflects_each_spring(bench, load):
    """e_j = (g - g_plan)_j / (I_j k_p): a constant torque over a constant stiffness."""
    arm, law = bench(), ComputedTorqueFeedforward(bandwidth=40.0)
    arm.plant.set_payload(load(1.0, z=0.1))
    log = arm.run(law, 1.5)
    missing = arm.plant.gravity(log.q) - arm.model.gravity(arm.plan.centre)
    assert log.error[-1] == pytest.approx(missing / law.stiffness, abs=1e-7)


@pytest.mark.parametrize("bandwidth", [20.0, 40.0, 60.0])
def test_the_inertia_rule_is_quiet_on_an_arm_without_rotors(rizon, bandwidth):
    """The mean of diag(M) is in a limit cycle there at 20 rad/s already: 2 k_d rho h + k_p rho h^2 < 4 holds here."""
    model = rizon.model()
    law = ComputedTorqueFeedforward(bandwidth=bandwidth)
    reference = type("Hold", (), {"q": rizon.home[None, :]})
    inertia = smallest_effective_inertia(model, reference)
    ratio = np.linalg.eigvals(np.linalg.solve(model.mass_matrix(rizon.home), np.diag(inertia))).real.max()
    k_p, k_d = double_integrator_gains(law.bandwidth, 1e-3)
    assert 2.0 * k_d * ratio * 1e-3 + k_p * ratio * 1e-6 < 4.0
    assert k_d * ratio * 1e-3 < 1.0
