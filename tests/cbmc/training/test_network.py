"""The hand-written passes against autograd, and the golden vector of the paper's cerebellum."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from torquebench.cbmc.training.network import (  # noqa: E402 - torch first, or skip
    GRANULE,
    GROUP,
    PURKINJE,
    THRESHOLD,
    WINDOW,
    Network,
    Weights,
    fold_dcn,
)


class Spike(torch.autograd.Function):
    """A step forwards, a sigmoid's slope backwards."""

    @staticmethod
    def forward(context, x, nu):
        context.save_for_backward(x)
        context.nu = nu
        return (x >= 0).to(x)

    @staticmethod
    def backward(context, slope):
        (x,) = context.saved_tensors
        sigmoid = torch.sigmoid(context.nu * x)
        return slope * context.nu * sigmoid * (1 - sigmoid), None


def fire(u, current, nu):
    h = u + (current - u) / 10.0
    s = Spike.apply(h - THRESHOLD, nu)
    return (1 - s) * h, s


def plain_window(x, granule, granule_bias, now, before, purkinje_bias, dcn, dcn_bias, nu):
    """The paper's network step by step, 20 DCN neurons a joint."""
    u_granule = x.new_zeros(len(x), GRANULE)
    u_purkinje = x.new_zeros(len(x), PURKINJE)
    u_dcn = x.new_zeros(len(x), len(dcn))
    previous = u_granule
    for _ in range(WINDOW):
        u_granule, s = fire(u_granule, x @ granule.T + granule_bias, nu)
        u_purkinje, p = fire(u_purkinje, s @ now + previous @ before + purkinje_bias, nu)
        u_dcn = u_dcn + (p @ dcn.T + dcn_bias - u_dcn) / 5.0
        previous = s
    return u_dcn.view(len(x), -1, GROUP).mean(dim=2)


def golden(rows, columns, a, b, m, scale, shift):
    """Weights by an integer formula, so that no random generator matters."""
    r, c = np.mgrid[:rows, :columns]
    return torch.from_numpy(scale * ((a * r + b * c) % m - shift))


@pytest.fixture
def golden_weights():
    """Weights of the golden vector: parts of the plain network."""
    purkinje = golden(PURKINJE, 2 * GRANULE, 17, 29, 31, 0.01, 15)
    return {
        "granule": golden(GRANULE, 7, 7, 11, 13, 0.06, 6),
        "granule_bias": 0.01 * (torch.arange(GRANULE) % 9 - 4.0).double(),
        "now": purkinje[:, :GRANULE].T,
        "before": purkinje[:, GRANULE:].T,
        "purkinje_bias": 0.02 * (torch.arange(PURKINJE) % 7 - 3.0).double(),
        "dcn": golden(7 * GROUP, PURKINJE, 5, 13, 17, 0.05, 8),
        "dcn_bias": 0.1 * (torch.arange(7 * GROUP) % 5 - 2.0).double(),
    }


def folded(parts):
    weights = Weights.zeros(parts["granule"].shape[1], dtype=torch.float64)
    weights.granule.copy_(parts["granule"])
    weights.granule_bias.copy_(parts["granule_bias"])
    weights.purkinje.copy_(torch.hstack((parts["now"], parts["before"])))
    weights.purkinje_bias.copy_(parts["purkinje_bias"])
    readout, offset = fold_dcn(parts["dcn"], parts["dcn_bias"])
    weights.readout.copy_(readout)
    weights.readout_bias.copy_(offset)
    return weights


def test_the_golden_vector(golden_weights):
    """Outputs and gradients that another implementation gave."""
    x = torch.tensor([[0.1, -0.7, 0.05, 1.6, -0.02, 0.7, 0.1]], dtype=torch.float64)
    network = Network(folded(golden_weights), batch=1, slope=5.0)
    expected = [-0.005089248, -0.006833152, 0.007536768, -0.005494592, 0.004471104, 0.001487968, -0.004545376]
    np.testing.assert_allclose(network.forward(x)[0], expected, atol=1e-12)
    gradient = network.backward(torch.ones((1, 7), dtype=torch.float64))
    assert float(gradient.granule.abs().sum()) == pytest.approx(5.039632080295, abs=1e-9)
    assert float(gradient.purkinje.abs().sum()) == pytest.approx(88.529827557534, abs=1e-8)


@pytest.mark.parametrize("nu", [5.0, 50.0])
def test_the_written_gradient_is_autograds(nu):
    """Every parameter, with the reset not detached, in float64."""
    rng = torch.Generator().manual_seed(3)
    weights = Weights.drawn(7, 5, dtype=torch.float64)
    weights.purkinje.mul_(4.0)
    x = torch.randn((6, 7), generator=rng, dtype=torch.float64)
    target = torch.randn((6, 7), generator=rng, dtype=torch.float64)
    network = Network(weights, batch=6, slope=nu)
    written = network.backward(2.0 * (network.forward(x) - target))

    copied = {name: getattr(weights, name).clone().requires_grad_() for name in NAMES}
    now, before = copied["purkinje"].split(PURKINJE, dim=1)
    # Each joint's row for all 20 neurons of its group, and its offset as the bias that charges to it.
    dcn = copied["readout"].repeat_interleave(GROUP, dim=0)
    bias = (copied["readout_bias"] / (1.0 - 0.8**WINDOW)).repeat_interleave(GROUP)
    output = plain_window(
        x, copied["granule"], copied["granule_bias"], now, before, copied["purkinje_bias"], dcn, bias, nu
    )
    ((output - target) ** 2).sum().backward()
    for name in NAMES:
        assert float((copied[name].grad - getattr(written, name)).abs().max()) < 1e-10, name
        assert float(getattr(written, name).abs().max()) > 1e-3, name


NAMES = ("granule", "granule_bias", "purkinje", "purkinje_bias", "readout", "readout_bias")


def test_folded_rows_are_the_mean_of_the_140_neurons(golden_weights):
    """The fold is exact, offsets charged over the window included."""
    x = torch.linspace(-1.0, 1.0, 35, dtype=torch.float64).view(5, 7)
    plain = plain_window(x, **golden_weights, nu=5.0)
    folded_answer = Network(folded(golden_weights), batch=5, slope=5.0).forward(x)
    np.testing.assert_allclose(folded_answer, plain, atol=1e-13)


def test_weights_are_views_of_one_vector():
    """An optimiser moves the vector; the passes must see it."""
    weights = Weights.drawn(7, 1)
    weights.vector.zero_()
    assert not any(getattr(weights, name).any() for name in NAMES)
