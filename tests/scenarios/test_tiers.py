"""Tiers: what stands between a command and the arm, as constants."""

import numpy as np
import pytest
from torquebench.controllers import UnknownName
from torquebench.scenarios.tiers import build_tier, default_tiers

ARMATURE = np.array([3.17, 3.17, 1.38, 1.38, 0.13, 0.13, 0.13])


def test_the_ideal_tier_has_nothing_between(rizon):
    """Torque exact, sensors exact, a third of the rotor inertia apparent."""
    tier = build_tier("ideal", rizon.tiers, rizon.rotor_inertia)
    assert (tier.period, tier.delay_ticks, tier.torque_lag, tier.encoder_quantum) == (0.001, 0, 0.0, 0.0)
    assert tier.velocity_filter_hz is None
    assert tier.wrench_filter_hz is None
    assert not np.concatenate([tier.coulomb, tier.viscous, tier.wrench_noise, tier.wrench_bias]).any()
    assert np.all(np.isinf(tier.torque_rate))
    assert np.allclose(tier.rotor_inertia, ARMATURE / 3, rtol=1e-15, atol=0)


def test_the_actuated_tier_has_the_chosen_constants(rizon):
    """The default of every comparison, figure by figure."""
    tier = build_tier("actuated", rizon.tiers, rizon.rotor_inertia)
    assert (tier.delay_ticks, tier.torque_lag, tier.velocity_filter_hz) == (1, 0.0015, 150.0)
    assert tier.torque_rate.tolist() == [16000.0, 16000.0, 8000.0, 8000.0, 4000.0, 4000.0, 4000.0]
    assert tier.coulomb.tolist() == [0.6, 0.6, 0.5, 0.6, 0.4, 0.3, 0.3]
    assert tier.viscous.tolist() == [0.6, 0.6, 0.4, 0.4, 0.2, 0.2, 0.2]
    assert tier.coulomb_velocity == 0.02
    assert tier.encoder_quantum == pytest.approx(6.0e-6, rel=2e-3)
    assert tier.wrench_noise.tolist() == [0.1, 0.1, 0.1, 0.005, 0.005, 0.005]
    assert tier.wrench_bias.tolist() == [0.5, 0.5, 0.5, 0.02, 0.02, 0.02]
    assert tier.wrench_filter_hz == 100.0


def test_tight_rate_is_actuated_with_a_quarter_of_its_rates(rizon):
    """Nothing else may differ in a robustness variant."""
    wide, tight = (build_tier(name, rizon.tiers, rizon.rotor_inertia) for name in ("actuated", "tight_rate"))
    assert np.array_equal(4.0 * tight.torque_rate, wide.torque_rate)
    for field in wide.__dataclass_fields__:
        if field not in ("name", "torque_rate"):
            assert np.array_equal(getattr(wide, field), getattr(tight, field)), field


def test_paper_bullet_is_ideal_without_rotors(rizon):
    """What a plain simulator script computes."""
    assert not build_tier("paper_bullet", rizon.tiers, rizon.rotor_inertia).rotor_inertia.any()


def test_controllers_are_told_the_facts_on_copies(rizon):
    """Equal for all; a controller that scribbles on them changes its own only."""
    tier = build_tier("actuated", rizon.tiers, rizon.rotor_inertia)
    facts = tier.actuation(rizon.effort)
    assert (facts.tier, facts.delay_ticks, facts.torque_lag, facts.velocity_filter_hz) == ("actuated", 1, 0.0015, 150.0)
    assert np.array_equal(facts.rotor_inertia, tier.rotor_inertia)
    facts.effort[:] = 0.0
    facts.rotor_inertia[:] = 0.0
    facts.torque_rate[:] = 0.0
    assert rizon.effort.all()
    assert tier.rotor_inertia.all()
    assert tier.torque_rate.all()


def test_no_rate_limit_is_told_as_none(rizon):
    """Not as infinity: a controller should not divide by it."""
    assert build_tier("ideal", rizon.tiers, rizon.rotor_inertia).actuation(rizon.effort).torque_rate is None


def test_an_unknown_tier_names_the_nearest(rizon):
    """Of this robot's."""
    with pytest.raises(UnknownName, match="unknown tier 'actuatd'; did you mean 'actuated'"):
        build_tier("actuatd", rizon.tiers, rizon.rotor_inertia)


def test_a_foreign_arm_gets_every_tier_scaled_to_its_limits():
    """130 times the torque limit in a second, friction 0.6 percent of it."""
    effort = np.array([200.0, 10.0])
    tiers = default_tiers(effort, np.zeros(2))
    assert set(tiers) == {"ideal", "actuated", "tight_rate", "elastic", "paper_bullet"}
    tier = build_tier("actuated", tiers, np.zeros(2))
    assert tier.torque_rate.tolist() == [26000.0, 1300.0]
    assert np.allclose(tier.coulomb, [1.2, 0.06], rtol=1e-12, atol=0)
    assert np.array_equal(4 * build_tier("tight_rate", tiers, np.zeros(2)).torque_rate, tier.torque_rate)


@pytest.mark.parametrize("key", ["encoder_bits", "velocity_filter_hz", "ft_filter_hz"])
def test_a_zero_switches_a_sensors_flaw_off(key):
    """An encoder of no bits would else read whole turns, a filter of 0 Hz nothing ever."""
    tier = build_tier("plain", {"plain": {key: 0}}, np.zeros(2))
    assert (tier.encoder_quantum, tier.velocity_filter_hz, tier.wrench_filter_hz) == (0.0, None, None)
