"""The network that learns online: golden numbers, gradients, and descent, alike in every implementation."""

import numpy as np
import pytest
from torquebench.cbmc import reference
from torquebench.cbmc.brainstem import BrainstemTable
from torquebench.cbmc.online_network import Descent, OnlineNetwork
from torquebench.cbmc.thalamus import ThalamusTable

GOLDEN_BRAINSTEM = """10.064756255504 9.530021180773 9.968085345323 10.406149509873 9.493471795347 9.931535959896
10.369600124446 10.132293349458 9.597558274727 10.035622439277 10.473686603826 9.561008889300 9.999073053850
10.437137218400"""


def test_the_thalamus_net_gives_the_golden_numbers(run, thalamus_case):
    """Potentials, spikes and gradients from SpikingJelly's autograd, resets not detached."""
    potentials, spikes, (w1, b1, w2, _) = run(thalamus_case)
    assert potentials == pytest.approx([10.62483807232, 9.91073741824], abs=1e-11)
    assert spikes.tolist() == [0, 0, 10, 0, 10]
    golden = [-0.197840575517, -0.201958904162, 0.174640694296, -0.183707703406, -0.041371425408]
    assert b1 == pytest.approx(golden, abs=1e-11)
    assert np.abs(w1).sum() == pytest.approx(0.999399128487, abs=1e-11)
    assert w2[0] == pytest.approx([0, 0, 0.8926258176, 0, 0.8926258176], abs=1e-11)


def test_the_brainstem_net_gives_the_golden_numbers(run, brainstem_case):
    """Potentials, spikes and sums of absolute gradients from SpikingJelly's autograd."""
    potentials, spikes, gradients = run(brainstem_case)
    assert potentials == pytest.approx([float(word) for word in GOLDEN_BRAINSTEM.split()], abs=1e-11)
    assert spikes.tolist() == [15, 15, 7, 0, 0, 0, 0, 0, 15, 15]
    sums = [np.abs(gradient).sum() for gradient in gradients]
    assert sums == pytest.approx([381.416729164784, 21.344269412286, 209.923844052615, 47.275965767648], abs=1e-9)


def test_gradients_equal_automatic_differentiation(case, run):
    """The hand-written backward pass is exact, on random networks of both modules."""
    potentials, spikes, gradients = run(case)
    plain = reference.TwoLayers(parameters=case.parameters, **case.settings)
    assert potentials == pytest.approx(plain.forward(case.x), abs=1e-12)
    assert spikes.tolist() == plain.hidden_spikes.tolist()
    for gradient, expected in zip(gradients, plain.backward(case.gradient), strict=True):
        assert gradient == pytest.approx(expected, abs=1e-10)


def test_twenty_updates_agree_with_the_plain_form(case, build):
    """Momentum and decay as in torch, biases included; 1e-12 after twenty successive steps."""
    descent, rng = Descent(learning_rate=0.01, momentum=0.5, weight_decay=0.001), np.random.default_rng(3)
    network = build(case, descent)
    plain = reference.TwoLayers(parameters=[p.copy() for p in case.parameters], **case.settings)
    momenta = [np.zeros_like(p) for p in plain.parameters]
    for _ in range(20):
        x, gradient = rng.normal(size=case.x.size), rng.normal(size=case.gradient.size)
        assert network.forward(x) == pytest.approx(plain.forward(x), abs=1e-12)
        network.update(gradient)
        reference.descend(plain.parameters, momenta, plain.backward(gradient), descent)
        flat = np.concatenate([p.ravel() for p in plain.parameters])
        assert network.parameters == pytest.approx(flat, abs=1e-12)


def test_updates_equal_torch_descent(case, build):
    """The same convention as the optimiser that the paper used."""
    torch = pytest.importorskip("torch")
    network, rng = build(case, Descent(weight_decay=0.001)), np.random.default_rng(4)
    parameters = torch.tensor(network.parameters.copy(), requires_grad=True)
    optimiser = torch.optim.SGD([parameters], lr=0.01, momentum=0.5, weight_decay=0.001)
    for _ in range(5):
        network.forward(rng.normal(size=case.x.size))
        gradient = rng.normal(size=case.gradient.size)
        parameters.grad = torch.tensor(network.backward(gradient).copy())
        optimiser.step()
        network.update(gradient)
        assert network.parameters == pytest.approx(parameters.detach().numpy(), abs=1e-14)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_update_that_would_not_stay_finite_is_left_out_and_counted(thalamus_case, build, bad):
    """One broken measurement must not end what was learnt."""
    network = build(thalamus_case)
    network.forward(thalamus_case.x)
    before = network.parameters.copy()
    network.update(np.array([bad, -bad]))
    assert network.parameters.tolist() == before.tolist()
    assert network.skipped == 1
    network.update(np.array([1.0, -1.0]))
    assert network.skipped == 1 and np.isfinite(network.parameters).all()


def make(table=None, *, layers=(6, 5, 2), biases=True, seed=0):
    table = table or ThalamusTable()
    network = OnlineNetwork(
        layers=layers,
        hidden=table.hidden,
        output=table.output,
        window=table.window,
        surrogate_slope=table.surrogate_slope,
        descent=table.descent,
        biases=biases,
    )
    network.initialise(np.random.default_rng(seed))
    return network


def test_initial_parameters_fill_torch_default_bounds():
    """Weights and biases within one over the root of the layer's inputs; a seed decides them."""
    network = make(BrainstemTable(), layers=(28, 10, 14))
    for block, inputs in ((network.hidden_weights, 28), (network.output_weights, 10), (network.output_biases, 10)):
        assert 0.7 / np.sqrt(inputs) < np.abs(block).max() <= 1.0 / np.sqrt(inputs)
    again = make(BrainstemTable(), layers=(28, 10, 14))
    assert network.parameters.tolist() == again.parameters.tolist()
    assert network.parameters.tolist() != make(BrainstemTable(), layers=(28, 10, 14), seed=1).parameters.tolist()


def test_without_biases_they_stay_zero_and_the_weights_are_the_same():
    """The ablation changes one thing."""
    network, full = make(biases=False), make()
    assert network.hidden_weights.tolist() == full.hidden_weights.tolist()
    for _ in range(3):
        network.forward(np.ones(6))
        network.update(np.array([1.0, -1.0]))
    assert not network.hidden_biases.any() and not network.output_biases.any()
    assert network.hidden_weights.tolist() != full.hidden_weights.tolist()
