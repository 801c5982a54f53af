"""Joint PID: without a model, yet constant loads vanish and limits do not wind it up."""

import numpy as np
import pytest
from torquebench.baselines.joint_pid import JointPid
from torquebench.controllers import knowledge_levels

EFFORT = 150.0


@pytest.mark.parametrize("arm", ["planar", "six", "seven"])
def test_any_constant_load_is_held_without_error(bench, load, arm):
    """Gravity of arm and load alike end in the integral."""
    arm, law = bench(arm, effort=EFFORT), JointPid()
    arm.plant.set_payload(load(2.0, z=0.1))
    log = arm.run(law, 6.0)
    assert np.abs(log.error[-1]).max() < 1e-5
    shown, every = law.diagnostics()["integral"]
    assert shown == pytest.approx(arm.plant.gravity(log.q), abs=0.02)
    assert every == 10


def test_it_starts_with_the_torque_that_holds_the_arm(bench):
    """Bumpless: on the plan at rest, the first command is the one before."""
    arm, law = bench(), JointPid()
    law.reset(arm.task())
    q = arm.plan.centre
    assert law.compute(arm.observe(0.0, q, np.zeros(7)), arm.plan.target(0.0)) == pytest.approx(arm.plant.gravity(q))


def test_it_never_reads_the_model(bench):
    """Knowledge of the load cannot matter, so one level is enough."""
    arm, law = bench(sway=0.1, effort=EFFORT), JointPid()
    before = arm.run(law, 0.1).torque
    arm.model.set_disturbance(np.full(7, 50.0))
    assert np.array_equal(arm.run(law, 0.1).torque, before)
    assert knowledge_levels(law, ("none", "oracle")) == ("none",)


def test_a_saturated_joint_does_not_wind_up(bench):
    """A law that does not know of the drives' limits swings farther past its goal."""
    aware, unaware = bench("planar", effort=60.0), bench("planar", effort=60.0)
    unaware.told_effort = np.full(3, np.inf)
    gains = {"stiffness": (1500.0,) * 3, "damping": (80.0,) * 3}
    log = aware.run(JointPid(**gains), 4.0, offset=0.3)
    wound = unaware.run(JointPid(**gains), 4.0, offset=0.3)
    assert np.any(np.abs(log.torque) > 60.0)
    assert log.error.min() > 0.5 * wound.error.min()
    assert np.abs(log.error[-1]).max() < 1e-3


def test_the_integral_stays_within_its_share_of_the_limit(bench):
    """Below the limit there is room left for the other two terms."""
    arm, law = bench(effort=100.0), JointPid(integral_limit=0.2)
    law.reset(arm.task())
    q = arm.plan.centre - 0.5
    for _ in range(500):
        law.compute(arm.observe(0.0, q, np.zeros(7), np.zeros(7)), arm.plan.target(0.0))
    assert law.integral == pytest.approx(np.full(7, 20.0))


def test_the_rule_needs_limits_and_says_so(bench):
    """Six joints without torque limits: nothing to take a share of."""
    assert "give one" in JointPid().supports(bench("six").task())
    assert JointPid(stiffness=(500.0,) * 6).supports(bench("six").task()) is None
    assert JointPid().supports(bench("six", effort=EFFORT).task()) is None
