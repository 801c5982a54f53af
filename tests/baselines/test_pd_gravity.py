"""PD with gravity compensation: springs that sag, and never swing up."""

import numpy as np
import pytest
from torquebench.baselines.gains import smallest_effective_inertia
from torquebench.baselines.joint_gains import EXAMPLE_DAMPING, EXAMPLE_STIFFNESS
from torquebench.baselines.pd_gravity import PdGravity
from torquebench.controllers import InvalidInput


@pytest.mark.parametrize("arm", ["planar", "six", "seven"])
def test_an_unknown_load_deflects_each_spring(bench, load, arm):
    """K e = g - g_model: a constant torque over a constant stiffness."""
    arm, law = bench(arm), PdGravity()
    arm.plant.set_payload(load(1.0, z=0.1))
    log = arm.run(law, 2.5)
    assert log.error[-1] == pytest.approx((arm.plant.gravity(log.q) - arm.model.gravity(log.q)) / law.springs, abs=1e-6)


def test_a_known_load_is_weightless(bench, load):
    """Whatever the knowledge level grants enters the gravity torque."""
    arm = bench()
    for model in (arm.plant, arm.model):
        model.set_payload(load(2.0, z=0.1))
    assert np.abs(arm.run(PdGravity(), 4.0, offset=0.05).error[-1]).max() < 1e-6


def test_seven_joints_have_the_published_gains_and_others_a_rule(bench):
    """Natural frequency 40 rad/s on the smallest effective inertia, damping ratio 0.7."""
    arm, law = bench("seven"), PdGravity()
    law.reset(arm.task())
    assert tuple(law.springs) == EXAMPLE_STIFFNESS and tuple(law.dampers) == EXAMPLE_DAMPING
    arm = bench("six")
    law.reset(arm.task())
    inertia = smallest_effective_inertia(arm.model, arm.plan)
    assert law.springs == pytest.approx(1600.0 * inertia)
    assert law.dampers == pytest.approx(1.4 * np.sqrt(law.springs * inertia))


@pytest.mark.parametrize(("fed", "lag"), [(False, 1.0), (True, 0.0)])
def test_absolute_damping_lags_by_d_over_k(bench, fed, lag):
    """A spring drags its damper along: K e = D dq at constant speed, nothing with feed-forward."""
    arm, law = bench(sway=0.2), PdGravity(velocity_feedforward=fed)
    law.reset(arm.task())
    q, dq, _ = arm.plan.joints(0.3)
    error = lag * law.dampers * dq / law.springs
    torque = law.compute(arm.observe(0.3, q - error, dq), arm.plan.target(0.3))
    assert torque == pytest.approx(arm.model.gravity(q - error), abs=1e-9)


def test_the_energy_never_rises(bench):
    """V = kinetic energy + springs falls by dq^T D dq: no model of the inertia is needed."""
    arm, law = bench(), PdGravity()
    law.reset(arm.task())
    q, dq, energy = arm.plan.centre - 0.1, np.zeros(7), []
    target = arm.plan.target(0.0)
    for _ in range(400):
        torque = law.compute(arm.observe(0.0, q, dq), target)
        state = arm.plant.at(q, dq)
        error = arm.plan.centre - q
        energy.append(0.5 * dq @ state.mass_matrix @ dq + 0.5 * error @ (law.springs * error))
        dq = dq + 1e-3 * np.linalg.solve(state.mass_matrix, torque - state.bias)
        q = q + 1e-3 * dq
    # Semi-implicit steps conserve energy to first order in the period only.
    assert np.diff(energy).max() < 1e-3 * energy[0]
    assert energy[-1] < 0.02 * energy[0]


@pytest.mark.parametrize("settings", [{"stiffness": 3.0}, {"damping": (1.0, -1.0)}, {"bandwidth": 0.0}])
def test_a_wrong_setting_is_refused(settings):
    """In one sentence, with its name."""
    with pytest.raises(InvalidInput, match=next(iter(settings))):
        PdGravity(**settings)


def test_gains_for_another_arm_are_refused_by_number(bench):
    """A reason to skip, not a crash; a list from a file counts as a tuple."""
    law = PdGravity(stiffness=[100.0] * 6)
    assert law.stiffness == (100.0,) * 6
    assert "6 values" in law.supports(bench("seven").task())
    assert law.supports(bench("six").task()) is None
