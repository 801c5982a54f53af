"""Golden weights by integer formula, and every implementation of the networks behind one signature."""

from dataclasses import dataclass

import numpy as np
import pytest
from torquebench.cbmc import reference
from torquebench.cbmc.brainstem import BrainstemTable
from torquebench.cbmc.cerebellum import CerebellumTable
from torquebench.cbmc.online_network import Descent, OnlineNetwork
from torquebench.cbmc.pathways import Ascending, Descending
from torquebench.cbmc.patterns import Patterns
from torquebench.cbmc.thalamus import ThalamusTable


def formula(shape, a, b, modulus, scale, shift):
    """Return scale (((a r + b c) mod modulus) - shift) for row r and column c: weights without a generator."""
    row, column = np.indices(shape)
    return scale * ((a * row + b * column) % modulus - shift)


@dataclass
class Case:
    """A two-layer network with an input and a gradient at its output."""

    parameters: list
    table: object
    x: np.ndarray
    gradient: np.ndarray

    @property
    def settings(self):
        table = self.table
        return {
            "hidden": table.hidden,
            "output": table.output,
            "window": table.window,
            "surrogate_slope": table.surrogate_slope,
        }


def random_case(table, layers, rng):
    inputs, hidden, outputs = layers
    shapes = [(hidden, inputs), hidden, (outputs, hidden), outputs]
    fans = [inputs, inputs, hidden, hidden]
    parameters = [rng.uniform(-1, 1, shape) / np.sqrt(fan) for shape, fan in zip(shapes, fans, strict=True)]
    return Case(parameters, table, rng.normal(size=inputs), rng.normal(size=outputs))


@pytest.fixture
def thalamus_case():
    first, second = formula((5, 6), 3, 5, 7, 0.1, 3), formula((2, 5), 1, 2, 5, 0.2, 2)
    parameters = [first, 0.05 * (np.arange(5) - 2), second, np.array([0.1, -0.1])]
    x = np.array([0.3, -0.2, -0.6, 0.1, 0.05, 0.0])
    return Case(parameters, ThalamusTable(), x, np.array([1.0, -1.0]))


@pytest.fixture
def brainstem_case():
    first, second = formula((10, 28), 3, 5, 11, 0.05, 5), formula((14, 10), 1, 3, 7, 0.1, 3)
    parameters = [first, 0.02 * (np.arange(10) - 4.5), second, 0.01 * (np.arange(14) - 6.5)]
    return Case(parameters, BrainstemTable(), np.sin(np.arange(28) + 1.0), np.arange(14) - 6.5)


@pytest.fixture(params=range(20))
def case(request):
    """Return a random network of either module's sizes."""
    rng = np.random.default_rng(request.param)
    if request.param % 2:
        return random_case(BrainstemTable(), (28, 10, 14), rng)
    return random_case(ThalamusTable(), (6, 5, 2), rng)


def run_compiled(case):
    network = build_network(case)
    potentials = network.forward(case.x).copy()
    gradient = network.backward(case.gradient)
    sizes = np.cumsum([p.size for p in case.parameters])[:-1]
    blocks = [g.reshape(p.shape) for g, p in zip(np.split(gradient, sizes), case.parameters, strict=True)]
    return potentials, network.hidden_spikes, blocks


def build_network(case, descent=None):
    layers = (case.x.size, case.parameters[1].size, case.gradient.size)
    network = OnlineNetwork(layers=layers, descent=descent or Descent(), **case.settings)
    network.parameters[:] = np.concatenate([p.ravel() for p in case.parameters])
    return network


def run_numpy(case):
    network = reference.TwoLayers(parameters=case.parameters, **case.settings)
    return network.forward(case.x), network.hidden_spikes, network.backward(case.gradient)


def run_torch(case):
    torch = pytest.importorskip("torch")
    slope = case.table.surrogate_slope
    first, second = (torch_layer(torch, lif, slope) for lif in (case.table.hidden, case.table.output))
    return run_layers(torch, case, first, second)


def run_spikingjelly(case):
    torch, build = spikingjelly_layer()
    slope = case.table.surrogate_slope
    return run_layers(torch, case, build(case.table.hidden, slope), build(case.table.output, slope))


def run_layers(torch, case, first, second):
    """Return potentials, spikes and gradients of a network whose layers turn (T, N) currents into both."""
    parameters = [torch.tensor(p, requires_grad=True) for p in case.parameters]
    w1, b1, w2, b2 = parameters
    current = w1 @ torch.tensor(case.x) + b1
    spikes, _ = first(current.expand(case.table.window, -1))
    _, potential = second(spikes @ w2.T + b2)
    potential.backward(torch.tensor(case.gradient))
    counts = spikes.detach().sum(0).numpy()
    return potential.detach().numpy(), counts, [p.grad.numpy() for p in parameters]


def torch_layer(torch, lif, slope):
    """Return a LIF layer with autograd through the surrogate and the reset."""

    class Fire(torch.autograd.Function):
        @staticmethod
        def forward(context, margin):
            context.save_for_backward(margin)
            return (margin >= 0).to(margin)

        @staticmethod
        def backward(context, upstream):
            sigmoid = torch.sigmoid(slope * context.saved_tensors[0])
            return upstream * slope * sigmoid * (1 - sigmoid)

    def layer(currents):
        potential, spikes = torch.full_like(currents[0], lif.u_reset), []
        for current in currents:
            charged = potential + (current - (potential - lif.u_reset)) / lif.tau_mb
            spikes.append(Fire.apply(charged - lif.u_fire))
            potential = (1 - spikes[-1]) * charged + spikes[-1] * lif.u_reset
        return torch.stack(spikes), potential

    return layer


def spikingjelly_layer():
    """Return torch and a builder of the same layer from SpikingJelly's neuron."""
    torch = pytest.importorskip("torch")
    neuron = pytest.importorskip("spikingjelly.activation_based.neuron")
    surrogate = pytest.importorskip("spikingjelly.activation_based.surrogate")

    def build(lif, slope):
        node = neuron.LIFNode(
            tau=lif.tau_mb,
            decay_input=True,
            v_threshold=lif.u_fire,
            v_reset=lif.u_reset,
            surrogate_function=surrogate.Sigmoid(alpha=slope),
            detach_reset=False,
        )
        return lambda currents: (torch.stack([node(current) for current in currents]), node.v)

    return torch, build


RUNS = {"compiled": run_compiled, "numpy": run_numpy, "torch": run_torch, "spikingjelly": run_spikingjelly}


@pytest.fixture(params=RUNS)
def run(request):
    """Return one implementation: case to (potentials, hidden spike counts, gradients)."""
    return RUNS[request.param]


@dataclass
class FullCerebellum:
    """One pattern with all its DCN neurons, as it is trained."""

    granule: np.ndarray
    granule_bias: np.ndarray
    purkinje: np.ndarray
    purkinje_bias: np.ndarray
    nuclei: np.ndarray
    nuclei_bias: np.ndarray

    def folded(self, copies=1):
        """Return the inference form, this pattern so many times."""
        table, joints = CerebellumTable(), self.granule.shape[1]
        gc = self.granule.shape[0]
        rows = np.concatenate([self.purkinje[:, :gc].T, self.purkinje[:, gc:].T], axis=1)
        leak = table.nuclei.leak(table.window).sum()
        grouped = (joints, table.nuclei_per_joint, -1)
        readout = self.nuclei.reshape(grouped).mean(axis=1)
        offset = self.nuclei_bias.reshape(grouped).mean(axis=1)[:, 0] * leak
        arrays = (self.granule, self.granule_bias, rows, self.purkinje_bias, readout, offset)
        names = ("granule", "granule_bias", "purkinje", "purkinje_bias", "readout", "readout_bias")
        stacked = {name: np.stack([a] * copies).astype(np.float32) for name, a in zip(names, arrays, strict=True)}
        return Patterns(**stacked, loads=tuple(range(copies)))

    def run(self, torch, build, q):
        """Return mean-decoded torques, GC and PC spikes, and the gradients of W1 and W_PC of the torques' sum."""
        table = CerebellumTable()
        gc_layer, pc_layer, dcn_layer = (build(lif, 5.0) for lif in (table.granule, table.purkinje, table.nuclei))
        w1 = torch.tensor(self.granule, requires_grad=True)
        w2 = torch.tensor(self.purkinje, requires_grad=True)
        b1, b2, w3, b3 = map(torch.tensor, (self.granule_bias, self.purkinje_bias, self.nuclei, self.nuclei_bias))
        gc, _ = gc_layer((w1 @ torch.tensor(q) + b1).expand(table.window, -1))
        before = torch.cat([torch.zeros_like(gc[:1]), gc[:-1]])
        pc, _ = pc_layer(torch.cat([gc, before], dim=1) @ w2.T + b2)
        _, potential = dcn_layer(pc @ w3.T + b3)
        torque = potential.reshape(len(q), -1).mean(dim=1)
        torque.sum().backward()
        return torque.detach().numpy(), int(gc.sum()), int(pc.sum()), w1.grad.numpy(), w2.grad.numpy()


@pytest.fixture
def golden_cerebellum():
    return FullCerebellum(
        granule=formula((300, 7), 7, 11, 13, 0.06, 6),
        granule_bias=0.01 * (np.arange(300) % 9 - 4),
        purkinje=formula((200, 600), 17, 29, 31, 0.01, 15),
        purkinje_bias=0.02 * (np.arange(200) % 7 - 3),
        nuclei=formula((140, 200), 5, 13, 17, 0.05, 8),
        nuclei_bias=0.1 * (np.arange(140) % 5 - 2),
    )


@pytest.fixture
def pathways():
    """Return pathways of a seven-joint arm with two patterns, away from rest."""
    rng = np.random.default_rng(7)
    up, down = Ascending.of(7), Descending.of(7, 2)
    for array in (up.q, up.dq, up.q_desired, up.dq_desired):
        array[:] = rng.normal(size=7)
    up.wrench[:] = (1.0, -2.0, -25.0, 0.5, 0.3, 0.0)
    down.compensation[:] = rng.normal(size=(2, 7)) * 20.0
    return up, down


@pytest.fixture
def build():
    """Return what makes a compiled network of a case."""
    return build_network


@pytest.fixture
def peer_layer():
    """Return torch and the builder of a layer from SpikingJelly's neuron."""
    return spikingjelly_layer()


@pytest.fixture(params=["torch", "spikingjelly"])
def peers(request):
    """Return torch and a builder of layers, with plain autograd and from SpikingJelly."""
    torch = pytest.importorskip("torch")
    return spikingjelly_layer() if request.param == "spikingjelly" else (torch, lambda a, b: torch_layer(torch, a, b))
