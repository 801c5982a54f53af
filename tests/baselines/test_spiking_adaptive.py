"""Computed torque with a spiking ensemble: the load goes from the error into the decoders."""

from dataclasses import replace

import numpy as np
import pytest
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.spiking_adaptive import SpikingAdaptive, centre_and_scale, place_in_ball
from torquebench.controllers import InvalidInput, knowledge_levels


@pytest.mark.parametrize("arm", ["planar", "six", "seven"])
def test_a_constant_load_is_learnt(bench, load, arm):
    """Computed torque alone droops by M^-1 dg / w^2; with the ensemble a hundredth of it is left."""
    errors = []
    for law in (ComputedTorque(bandwidth=20.0), SpikingAdaptive(bandwidth=20.0)):
        arm_under_load = bench(arm)
        arm_under_load.plant.set_payload(load(2.0, z=0.1))
        errors.append(np.abs(arm_under_load.run(law, 3.0).error[-500:]).mean(axis=0).max())
    assert errors[1] < 0.01 * errors[0]


def test_the_ensemble_ends_with_the_torque_that_the_model_lacks(bench, load):
    """u = g - g_model at rest."""
    arm, law = bench(), SpikingAdaptive()
    arm.plant.set_payload(load(1.0, z=0.1))
    q = arm.run(law, 3.0).q
    shown, every = law.diagnostics()["adaptive_torque"]
    assert shown == pytest.approx(arm.plant.gravity(q) - arm.model.gravity(q), abs=0.3)
    assert every == 10


def test_without_learning_it_is_computed_torque(bench):
    """Decoders start at nothing."""
    first, second = (
        bench(sway=0.2).run(law, 0.2, offset=0.02).torque
        for law in (SpikingAdaptive(learning_rate=0.0), ComputedTorque(bandwidth=20.0))
    )
    assert first == pytest.approx(second, abs=1e-9)


def test_it_learns_from_its_own_feedback_torque(bench):
    """epsilon = M (k_p e + k_d de)."""
    arm, law = bench(sway=0.2), SpikingAdaptive()
    law.reset(arm.task())
    q, dq, _ = arm.plan.joints(0.4)
    error, error_rate = np.linspace(-0.1, 0.1, 7), np.linspace(0.3, -0.3, 7)
    law.compute(arm.observe(0.4, q - error, dq - error_rate), arm.plan.target(0.4))
    expected = arm.model.mass_matrix(q - error) @ (law.stiffness * error + law.damping * error_rate)
    assert law.ensemble.error == pytest.approx(expected, abs=1e-9)


def test_an_episode_depends_on_its_seed_alone(bench, load):
    """Reset forgets what was learnt and draws the same neurons again; another seed draws others."""
    arm, law = bench(sway=0.2), SpikingAdaptive(neurons=200)
    arm.plant.set_payload(load(1.0, z=0.1))
    first, second = (arm.run(law, 0.3).torque for _ in range(2))
    assert np.array_equal(first, second)
    task = arm.task()
    arm.task = lambda: replace(task, seed=7)
    assert not np.array_equal(arm.run(law, 0.3).torque, first)


def test_the_counters_are_those_of_the_ensemble(bench):
    """Spikes of plausible rates, a membrane update per neuron and tick, updates for neurons that speak."""
    arm, law = bench(sway=0.2), SpikingAdaptive(neurons=300)
    arm.run(law, 1.0)
    counts = law.operations()
    assert counts["ensemble_membrane_dense"] == 300 * 1000
    assert 1.0 < counts["ensemble_spikes"] / 300 < 150.0
    assert 0 < counts["ensemble_parameter_updates"] <= 300 * 7 * 1000
    assert counts["ensemble_effective_acs"] == 7 * counts["ensemble_spikes"]


def test_the_corner_of_all_ranges_is_in_the_ball():
    """The middle at the centre, every joint alone at its limit inside, all together on the rim."""
    centre, scale = centre_and_scale(np.array([-1.0, -np.inf]), np.array([3.0, np.inf]), np.array([2.0, 0.0]))
    point = np.empty(4)
    place_in_ball(np.array([1.0, 0.0]), np.zeros(2), centre, scale, point)
    assert point == pytest.approx(np.zeros(4))
    place_in_ball(np.array([3.0, 0.0]), np.zeros(2), centre, scale, point)
    assert point == pytest.approx([np.sqrt(0.5), 0.0, 0.0, 0.0])
    place_in_ball(np.array([3.0, np.pi]), np.array([2.0, 1.0]), centre, scale, point)
    assert point == pytest.approx(np.full(4, 0.5))


def test_it_estimates_the_load_itself_and_says_so():
    """Other estimators of the load have no place beside it."""
    levels = ("none", "ft_estimate", "momentum_observer", "oracle")
    assert knowledge_levels(SpikingAdaptive(), levels) == ("none", "oracle")


@pytest.mark.parametrize("settings", [{"bandwidth": 0.0}, {"neurons": 0}, {"neurons": 2.5}, {"learning_rate": -1.0}])
def test_a_wrong_setting_is_refused(settings):
    """In one sentence, with its name."""
    with pytest.raises(InvalidInput, match=next(iter(settings))):
        SpikingAdaptive(**settings)


@pytest.mark.parametrize(("rate", "distance"), [(0.01, 0.13e-3), (0.03, 0.05e-3)])
def test_2_kg_are_learnt_in_5_seconds(on_t3, rate, distance):
    """With exact sensors and drives. A tenth of a millimetre, hoped for, is missed at the tuned rate by 17 %."""
    assert on_t3("pes_adaptive", learning_rate=rate).error[4] < distance
