"""Computed torque with integral action: constant loads vanish, limits do not wind it up."""

import numpy as np
import pytest
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.computed_torque_pid import ComputedTorquePid
from torquebench.baselines.integral import integrate_unless_limited


class Integral:
    """Two joints with limits 10 N m and 2 N m per tick, errors of 1 rad."""

    def __init__(self, *, clamp: float = 0.2) -> None:
        self.value, self.clamp = np.zeros(2), clamp
        self.previous, self.effort, self.step = np.full(2, np.nan), np.full(2, 10.0), np.full(2, 2.0)

    def tick(self, *command: float) -> np.ndarray:
        """Advance by 1 ms after these commands."""
        error = np.ones(2)
        limits = self.previous, self.effort, self.step
        integrate_unless_limited(self.value, error, 1e-3, self.clamp, np.array(command), *limits)
        return self.value


def test_a_constant_load_is_held_without_error(bench, load):
    """The integral takes over what the model lacks."""
    arm = bench()
    arm.plant.set_payload(load(2.0, z=0.1))
    assert np.abs(arm.run(ComputedTorquePid(bandwidth=20.0), 2.5).error[-1]).max() < 1e-7


def test_the_integral_becomes_the_missing_acceleration(bench, load):
    """At rest k_i z = M^-1 (g - g_model)."""
    arm, law = bench(), ComputedTorquePid(bandwidth=20.0)
    arm.plant.set_payload(load(1.0, z=0.1))
    q = arm.run(law, 1.5).q
    missing = np.linalg.solve(arm.model.mass_matrix(q), arm.plant.gravity(q) - arm.model.gravity(q))
    shown, every = law.diagnostics()["integral"]
    assert law.integral_gain * shown == pytest.approx(missing, abs=1e-4)
    assert every == 10


def test_without_error_it_is_the_pd_law_of_equal_gains(bench):
    """An empty integral changes nothing: one tick is inverse dynamics with k_p and k_d."""
    arm, law = bench(sway=0.3), ComputedTorquePid(bandwidth=20.0)
    law.reset(arm.task())
    q, dq, ddq = arm.plan.joints(0.4)
    torque = law.compute(arm.observe(0.4, q - 0.02, dq + 0.1), arm.plan.target(0.4)).copy()
    expected = arm.model.inverse_dynamics(q - 0.02, dq + 0.1, ddq + law.stiffness * 0.02 - law.damping * 0.1)
    assert torque == pytest.approx(expected, abs=1e-10)


def test_a_saturated_joint_does_not_wind_up(bench):
    """A law that does not know of the drives' limits swings five times as far past its goal."""
    aware, unaware = bench("planar", effort=40.0), bench("planar", effort=40.0)
    unaware.told_effort = np.full(3, np.inf)
    log = aware.run(ComputedTorquePid(bandwidth=20.0), 1.5, offset=0.3)
    wound = unaware.run(ComputedTorquePid(bandwidth=20.0, integral_limit=100.0), 1.5, offset=0.3)
    assert np.any(np.abs(log.torque) > 40.0)
    assert log.error.min() > 0.25 * wound.error.min()
    assert np.abs(log.error[-1]).max() < 1e-6


def test_the_integral_stands_while_the_command_is_at_its_effort():
    """Joint by joint, in both directions."""
    integral = Integral()
    integral.tick(9.0, 9.0)
    assert integral.tick(10.0, 9.5) == pytest.approx([1e-3, 2e-3])
    assert integral.tick(10.0, 9.5) == pytest.approx([1e-3, 3e-3])


def test_the_integral_stands_while_the_command_moves_at_its_rate():
    """A rate-limited joint lags behind what was asked for."""
    integral = Integral()
    integral.tick(0.0, 0.0)
    assert integral.tick(2.0, -1.0) == pytest.approx([1e-3, 2e-3])
    assert integral.tick(2.0, -3.0) == pytest.approx([2e-3, 2e-3])


def test_the_first_command_has_no_rate():
    """Nothing came before it, however large it is."""
    assert Integral().tick(9.0, -9.0) == pytest.approx([1e-3, 1e-3])


def test_the_integral_is_clamped():
    """At 0.2 rad s unless told otherwise."""
    integral = Integral(clamp=2.5e-3)
    for _ in range(5):
        integral.tick(0.0, 0.0)
    assert integral.value == pytest.approx([2.5e-3, 2.5e-3])


def test_it_is_stiffer_than_the_pd_law_of_equal_bandwidth(bench):
    """k_p is 3 w^2 in place of w^2: why the two are never compared by bandwidth alone."""
    task = bench().task()
    pid, pd = ComputedTorquePid(bandwidth=20.0), ComputedTorque(bandwidth=20.0)
    pid.reset(task)
    pd.reset(task)
    assert pid.stiffness == pytest.approx(3.0 * pd.stiffness, rel=0.05)
