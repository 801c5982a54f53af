"""The neuron: its trace, its limit without a threshold, its gradient."""

import numpy as np
import pytest
from torquebench.cbmc.neuron import Lif, Window, run_window, surrogate_derivative, window_gradient

GRANULE = Lif(u_reset=0.0, u_fire=0.1, tau_mb=10.0)


def test_a_constant_current_fires_with_the_golden_period():
    """0.3 into tau 10 and threshold 0.1: three charges, then a spike, for ever."""
    window = run_window(np.full((12, 1), 0.3), GRANULE)
    assert window.charged[:4, 0] == pytest.approx([0.03, 0.057, 0.0813, 0.10317], abs=1e-15)
    assert window.spikes[:, 0].tolist() == [0, 0, 0, 1] * 3


def test_reaching_the_threshold_fires():
    """The paper's step function is 1 at 0."""
    assert run_window(np.ones((1, 1)), Lif(u_fire=0.5, tau_mb=2.0)).spikes[0, 0] == 1.0


@pytest.mark.parametrize("steps", range(1, 11))
def test_a_neuron_fires_every_k_steps_above_the_current_of_the_staircase(steps):
    """Interval k needs I >= u_fire / (1 - 0.9^k): each GC is a staircase of ten steps."""
    current = 0.1 / (1.0 - 0.9**steps)
    above, below = (run_window(np.full((10, 1), current * f), GRANULE).spikes[:, 0] for f in (1 + 1e-9, 1 - 1e-9))
    assert np.flatnonzero(above)[0] == steps - 1
    assert not below[:steps].any()


def test_without_a_threshold_a_neuron_never_fires_and_stays_finite():
    """Infinity times the reset must not become NaN, forwards or backwards."""
    lif = Lif(u_reset=10.0, tau_mb=5.0)
    window = run_window(np.full((50, 3), 1e6), lif)
    gradient = window_gradient(window, lif, 5.0, np.ones((50, 3)), 1.0)
    assert not window.spikes.any()
    assert np.isfinite(window.potential).all()
    assert np.isfinite(gradient).all()


def test_the_last_potential_of_a_non_spiking_neuron_is_the_leak_weighted_sum():
    """The readout of a whole window is one product: what the folded DCN rests on."""
    lif, currents = Lif(u_reset=10.0, tau_mb=5.0), np.random.default_rng(0).normal(size=(15, 4))
    assert run_window(currents, lif).potential == pytest.approx(10.0 + lif.leak(15) @ currents, abs=1e-13)
    assert lif.leak(10).sum() == pytest.approx(1.0 - 0.8**10)


@pytest.mark.parametrize("lif", [GRANULE, Lif(u_reset=-0.3, u_fire=0.2, tau_mb=5.0), Lif(u_reset=10.0, tau_mb=5.0)])
def test_the_neuron_equals_spikingjelly_to_the_bit(peer_layer, lif):
    """Charge, fire, hard reset in the peer's order, spike for spike."""
    torch, build = peer_layer
    currents = np.random.default_rng(5).normal(size=(40, 100))
    window = run_window(currents, lif)
    spikes, potential = build(lif, 5.0)(torch.tensor(currents))
    assert np.array_equal(window.spikes, spikes.numpy())
    assert np.array_equal(window.potential, potential.numpy())


def smooth_potential(currents, lif, slope):
    """Return the last potential with the surrogate itself in place of the step."""
    potential = lif.u_reset
    for current in currents:
        charged = potential + (current - (potential - lif.u_reset)) / lif.tau_mb
        spike = 1.0 / (1.0 + np.exp(-slope * (charged - lif.u_fire)))
        potential = (1.0 - spike) * charged + spike * lif.u_reset
    return potential


def test_the_recursion_is_the_derivative_of_the_smoothed_neuron():
    """With the surrogate as the firing function the gradient through the resets is exact: finite differences."""
    lif, slope, step = Lif(u_reset=-0.2, u_fire=0.1, tau_mb=5.0), 5.0, 1e-6
    currents = np.random.default_rng(1).normal(size=12)
    charged, spikes, potential = [], [], lif.u_reset
    for current in currents:
        charged.append(potential + (current - (potential - lif.u_reset)) / lif.tau_mb)
        spikes.append(1.0 / (1.0 + np.exp(-slope * (charged[-1] - lif.u_fire))))
        potential = (1.0 - spikes[-1]) * charged[-1] + spikes[-1] * lif.u_reset
    window = Window(np.array(charged), np.array(spikes), np.array(potential))
    numeric = [
        (smooth_potential(currents + d, lif, slope) - smooth_potential(currents - d, lif, slope)) / (2 * step)
        for d in step * np.eye(12)
    ]
    assert window_gradient(window, lif, slope, np.zeros(12), 1.0) == pytest.approx(numeric, abs=1e-9)


def test_the_surrogate_is_even_and_vanishes_far_away():
    """Its largest value is nu / 4, at the threshold."""
    x = np.array([0.0, 0.3, -0.3, 1e9, -np.inf])
    assert surrogate_derivative(x, 5.0)[0] == 1.25
    assert surrogate_derivative(x, 5.0)[1] == pytest.approx(surrogate_derivative(x, 5.0)[2])
    assert surrogate_derivative(x, 5.0)[3:].tolist() == [0.0, 0.0]
