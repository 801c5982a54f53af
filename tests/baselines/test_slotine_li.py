"""Slotine-Li: the identities that its proof rests on, the proof's decrease, and what is learnt."""

import numpy as np
import pytest
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.payload_regressor import PayloadRegressor, inertial_parameters, pseudo_inertia
from torquebench.baselines.slotine_li import MixedDynamics, SlotineLi
from torquebench.controllers import InvalidInput, knowledge_levels

RNG = np.random.default_rng(3)
DQ, DQ_R, DDQ_R = RNG.uniform(-1.5, 1.5, (3, 7))
STEP = 1e-5
LOAD = np.array([2.0, 0.1, -0.2, 0.3, 0.11, 0.02, 0.09, -0.01, 0.03, 0.07])


def christoffel(model, q, dq):
    """Return C(q, dq) from central differences of the mass matrix, shape (n, n)."""
    n = model.n
    slope = np.empty((n, n, n))
    for k, unit in enumerate(STEP * np.eye(n)):
        slope[:, :, k] = (model.mass_matrix(q + unit) - model.mass_matrix(q - unit)) / (2.0 * STEP)
    symbols = 0.5 * (slope + slope.transpose(0, 2, 1) - slope.transpose(2, 0, 1))
    return np.einsum("ijk,k->ij", symbols, dq)


def velocity_matrix(model, q, dq):
    """Return C(q, dq) column by column from the polarised dynamics."""
    mixed, still = MixedDynamics(model), np.zeros(model.n)
    columns = [mixed.torque(q, dq, unit, still) - model.gravity(q) for unit in np.eye(model.n)]
    return np.array(columns).T


@pytest.fixture
def arm(bench):
    """A seven-joint arm with rotors."""
    return bench("seven")


def test_polarisation_gives_the_christoffel_symbols(arm):
    """C(q, dq) of the mass matrix's own slopes."""
    q = arm.plan.centre
    assert velocity_matrix(arm.model, q, DQ) == pytest.approx(christoffel(arm.model, q, DQ), abs=1e-8)


def test_the_mass_matrix_changes_as_passivity_demands(arm):
    """dM/dt - 2 C is skew: the arm cannot make energy of its own."""
    q = arm.plan.centre
    slope = (arm.model.mass_matrix(q + STEP * DQ) - arm.model.mass_matrix(q - STEP * DQ)) / (2.0 * STEP)
    skew = slope - 2.0 * velocity_matrix(arm.model, q, DQ)
    assert skew == pytest.approx(-skew.T, abs=1e-8)


def test_with_equal_velocities_it_is_the_inverse_dynamics(arm, load):
    """Payload and disturbance enter once."""
    arm.model.set_payload(load(2.0, z=0.2))
    q = arm.plan.centre
    mixed = MixedDynamics(arm.model).torque(q, DQ, DQ, DDQ_R)
    assert mixed == pytest.approx(arm.model.inverse_dynamics(q, DQ, DDQ_R), abs=1e-10)
    arm.model.set_disturbance(np.arange(7.0))
    mixed = MixedDynamics(arm.model).torque(q, DQ, DQ, DDQ_R)
    assert mixed == pytest.approx(arm.model.inverse_dynamics(q, DQ, DDQ_R), abs=1e-10)


@pytest.mark.parametrize("name", ["planar", "six", "seven"])
def test_the_regressor_is_what_a_load_adds_to_the_mixed_dynamics(bench, name):
    """Linear in all ten parameters, about the flange; the first four columns are the short regressor."""
    arm = bench(name)
    n, q = arm.model.n, arm.plan.centre
    motion = q, DQ[:n], DQ_R[:n], DDQ_R[:n]
    without, loaded = MixedDynamics(arm.model).torque(*motion).copy(), arm.model.copy()
    loaded.set_payload(LOAD)
    full = PayloadRegressor(arm.model).fill(*motion)
    assert full @ LOAD == pytest.approx(MixedDynamics(loaded).torque(*motion) - without, abs=1e-10)
    assert np.array_equal(PayloadRegressor(arm.model, 4).fill(*motion), full[:, :4])


def test_the_rizons_flange_is_turned_and_shifted_right(rizon):
    """On the real arm the flange is not its joint's frame."""
    model = rizon.model()
    loaded = model.copy()
    loaded.set_payload(LOAD)
    motion = rizon.home, DQ, DQ_R, DDQ_R
    expected = MixedDynamics(loaded).torque(*motion) - MixedDynamics(model).torque(*motion)
    assert PayloadRegressor(model).fill(*motion) @ LOAD == pytest.approx(expected, abs=1e-10)


def test_pseudo_inertia_and_parameters_are_one_thing():
    """There and back."""
    parameters = RNG.standard_normal(10)
    assert inertial_parameters(pseudo_inertia(parameters)) == pytest.approx(parameters)


class Watched(SlotineLi):
    """Records V of the proof at every tick."""

    def watch(self, plant, load):
        """Tell what the proof knows and the law does not."""
        self.plant, self.load, self.energy = plant, load, []
        return self

    def compute(self, observation, target):
        """Act, with V before the estimate moves."""
        error = load_error = None
        if hasattr(self, "plant"):
            load_error = self.load - self.estimate
            error = target.dq - observation.dq + self.bandwidth * (target.q - observation.q)
        torque = super().compute(observation, target)
        if error is not None:
            mass = self.plant.mass_matrix(observation.q)
            self.energy.append(0.5 * error @ mass @ error + 0.5 * np.sum(load_error**2 / self.gain))
        return torque


@pytest.mark.parametrize("bandwidth", [10.0, 20.0])
def test_the_proofs_energy_falls(bench, load, bandwidth):
    """V = s^T M s / 2 + the load's error over Gamma; up to the sampling, which the proof does not know."""
    arm, truth = bench(sway=0.3), load(2.0, z=0.1)
    law = Watched(bandwidth=bandwidth).watch(arm.plant, truth)
    arm.plant.set_payload(truth)
    arm.run(law, 2.0, offset=0.05)
    energy = np.array(law.energy[1:])
    assert np.diff(energy).max() < 1e-4 * energy[0]
    assert energy[-1] < 0.2 * energy[0]


@pytest.mark.parametrize("parameters", [4, 10])
def test_an_exciting_motion_teaches_the_load(bench, load, parameters):
    """All joints sway and the tool turns: mass and first moment are found."""
    arm, truth = bench(sway=0.5), load(2.0, z=0.1)
    arm.plant.set_payload(truth)
    law = SlotineLi(bandwidth=20.0, parameters=parameters)
    log = arm.run(law, 8.0)
    shown, every = law.diagnostics()["estimate"]
    assert shown[:4] == pytest.approx(truth[:4], abs=0.02)
    assert shown.shape == (parameters,) and every == 10
    assert np.abs(log.error[-500:]).max() < 1e-3


def test_the_load_leaves_no_error_behind(bench, load):
    """Matched by the ten parameters: after learning, the error is that of an arm without load."""
    errors = []
    for mass in (0.0, 2.0):
        arm = bench(sway=0.3)
        arm.plant.set_payload(load(mass, z=0.1))
        errors.append(np.abs(arm.run(SlotineLi(bandwidth=20.0), 6.0).error).max(axis=1))
    assert errors[1][:500].max() > 20.0 * errors[0][-2000:].max()
    assert errors[1][-2000:].max() < 1.5 * errors[0][-2000:].max()


def test_without_adaptation_a_known_load_is_computed_torque(bench, load):
    """On the plan the two laws are one: the mixed term differs by C times the slide only."""
    arm, law, other = bench(sway=0.3), SlotineLi(mass_gain=0.0), ComputedTorque(bandwidth=20.0)
    arm.model.set_payload(load(1.0, z=0.1))
    law.reset(arm.task())
    other.reset(arm.task())
    q, dq, _ = arm.plan.joints(0.4)
    seen = arm.observe(0.4, q, dq), arm.plan.target(0.4)
    assert law.compute(*seen) == pytest.approx(other.compute(*seen), abs=1e-9)


@pytest.mark.parametrize("known", [0.0, 2.0])
def test_the_estimate_stays_what_a_load_can_be(bench, known):
    """Within 5 kg at 0.3 m, mass and moments of inertia not negative, whatever part of it the model knows."""
    arm, law = bench(), SlotineLi(mass_gain=1e6)
    arm.model.set_payload(np.array([known, *np.zeros(9)]))
    law.reset(arm.task())
    q, upper = arm.plan.centre, np.array([5.0, *(1.5,) * 3, *(0.45,) * 6])
    lower = np.where(np.isin(np.arange(10), [0, 4, 6, 9]), 0.0, -upper)
    for k in range(20):
        velocity = (-1.0) ** k * DQ
        law.compute(arm.observe(0.0, q + 0.3 * velocity, velocity), arm.plan.target(0.0))
        total = law.estimate + arm.model.payload
        assert np.all(total <= upper + 1e-12) and np.all(total >= lower - 1e-12)
    assert np.any(np.isclose(total, upper) | np.isclose(total, lower))


def test_it_estimates_the_load_itself_and_says_so():
    """Other estimators of the load have no place beside it."""
    assert knowledge_levels(SlotineLi(), ("none", "ft_estimate", "momentum_observer", "oracle")) == ("none", "oracle")


@pytest.mark.parametrize("settings", [{"bandwidth": 0.0}, {"mass_gain": -1.0}, {"parameters": 5}])
def test_a_wrong_setting_is_refused(settings):
    """In one sentence, with its name."""
    with pytest.raises(InvalidInput, match=next(iter(settings))):
        SlotineLi(**settings)


def test_2_kg_are_found_within_5_percent_in_12_seconds(on_t3):
    """With exact sensors and drives; measured 1.999 kg, and within 5 % before the first lap begins."""
    found = on_t3("slotine_li")
    assert len(found.error) == 12 and found.mass == pytest.approx(2.0)
    assert found.controller.estimate[0] == pytest.approx(found.mass, rel=0.05)
    assert found.error[-1] < 0.1e-3
