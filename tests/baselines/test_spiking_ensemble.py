"""The spiking ensemble: neurons that fire as their tuning curves say, decoders that learn as the rule says."""

import numpy as np
import pytest
from torquebench.baselines import spiking_ensemble as spiking
from torquebench.baselines.spiking_ensemble import SpikingEnsemble, tuning

PERIOD = 1e-3


def ensemble(*, neurons=200, rate=0.01, seed=1, inputs=3):
    """Return an ensemble with two outputs."""
    return SpikingEnsemble(neurons, inputs, 2, rate=rate, period=PERIOD, rng=np.random.default_rng(seed))


def closed_form_rates(population, point):
    """Return the firing rates of a constant current, shape (n,) [Hz]."""
    current = point @ population.encoders + population.bias
    rates = np.zeros(len(current))
    fires = current > 1.0
    rates[fires] = 1.0 / (spiking.REFRACTORY - spiking.MEMBRANE * np.log1p(-1.0 / current[fires]))
    return rates


def test_gain_and_bias_meet_both_ends_of_the_tuning_curve():
    """Current 1 at the intercept, the fastest rate at the rim."""
    fastest, intercept = np.array([50.0, 100.0, 150.0]), np.array([-0.5, 0.0, 0.8])
    gain, bias = tuning(fastest, intercept)
    assert gain * intercept + bias == pytest.approx(np.ones(3))
    rates = 1.0 / (spiking.REFRACTORY - spiking.MEMBRANE * np.log1p(-1.0 / (gain + bias)))
    assert rates == pytest.approx(fastest)


def test_every_neuron_fires_at_the_rate_of_its_current():
    """Spikes are counted over 4 s; the instants are exact, so that the step costs less than one in two hundred."""
    population, ticks = ensemble(), 4000
    point = np.array([0.5, -0.3, 0.6])
    population.stimulus[:] = point
    counts, before = np.zeros(200), population.activity.copy()
    synapse = -np.expm1(-PERIOD / spiking.SYNAPSE)
    for _ in range(ticks):
        population.tick()
        counts += (population.activity - before * (1.0 - synapse)) * PERIOD / synapse
        before = population.activity.copy()
    expected = closed_form_rates(population, point)
    assert counts / (ticks * PERIOD) == pytest.approx(expected, rel=0.005, abs=0.3)
    assert population.tally[spiking.SPIKES] == round(counts.sum())


def test_one_update_is_the_outer_product_of_error_and_activity():
    """D += kappa h / n epsilon a^T, for neurons that speak."""
    population = ensemble()
    for _ in range(200):
        population.tick()
    population.error[:] = 2.0, -3.0
    before, updates = population.decoders.copy(), population.tally[spiking.UPDATES]
    population.tick()
    heard = population.activity > spiking.SILENT
    step = 0.01 * PERIOD / 200 * np.outer(np.where(heard, population.activity, 0.0), [2.0, -3.0])
    assert population.decoders - before == pytest.approx(step, abs=1e-15)
    assert population.tally[spiking.UPDATES] - updates == 2 * heard.sum()


def test_the_output_is_the_decoded_activity():
    """u = D a, with the decoders before the update."""
    population = ensemble()
    population.error[:] = 5.0, -1.0
    for _ in range(300):
        population.tick()
    before = population.decoders.copy()
    population.tick()
    assert population.output == pytest.approx(before.T @ population.activity, rel=1e-4)


def settled(neurons, *stimulus):
    """Return an ensemble that has seen a stimulus for long enough for its synapses to be full."""
    population = ensemble(neurons=neurons)
    population.stimulus[:] = stimulus
    for _ in range(300):
        population.tick()
    return population


def test_an_error_fed_back_vanishes():
    """Learning a constant: exponential, at the rate kappa times the mean square activity."""
    population, goal = settled(2000, 0.2, 0.1, -0.4), np.array([4.0, -2.0])
    speed = 0.01 * np.mean(population.activity**2)
    errors = []
    for _ in range(1500):
        population.error[:] = goal - population.output
        population.tick()
        errors.append(population.error[0])
    for tick in (50, 100):
        # Single spikes ripple: a mean over half a synapse.
        assert np.mean(errors[tick - 5 : tick + 6]) == pytest.approx(4.0 * np.exp(-speed * tick * PERIOD), rel=0.15)
    assert abs(np.mean(errors[-500:])) < 0.02


def test_what_is_learnt_in_one_place_is_another_thing_elsewhere():
    """Opposite inputs excite other neurons: two values are learnt side by side, and recalled without an error."""
    population, recalled = ensemble(neurons=1000), []
    for k in range(20000):
        sign, since = (1.0 if (k // 500) % 2 else -1.0), k % 500
        population.stimulus[:] = 0.8 * sign, 0.0, 0.0
        # While the synapse still tells of the other place, and while it is asked, nothing is learnt.
        population.error[:] = 0.0 if since < 150 else sign * 3.0 - population.output
        population.tick()
        if k > 19000 and 100 <= since < 150:
            recalled.append(sign * population.output)
    assert np.mean(recalled, axis=0) == pytest.approx([3.0, 3.0], abs=0.1)


def test_the_seed_decides_everything():
    """Equal seeds, equal spikes; another seed, other neurons."""
    one, two, other = ensemble(seed=4), ensemble(seed=4), ensemble(seed=5)
    for population in (one, two, other):
        population.error[:] = 1.0
        for _ in range(100):
            population.tick()
    assert np.array_equal(one.decoders, two.decoders)
    assert not np.array_equal(one.decoders, other.decoders)
