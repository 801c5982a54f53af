"""CBMC-V3's networks, compiled, beside the same networks from SpikingJelly's modules in eager torch at batch 1.

Both run one simulated second of the paper's schedule: the spinal cord 1000 times, brainstem and thalamus with an
online update 100 times, two patterns of the cerebellum 20 times. Weights are random: time does not depend on skill.

    python benchmarks/cbmc_peer.py
"""

import sys
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from torquebench.cbmc.brainstem import Brainstem, BrainstemTable
from torquebench.cbmc.cerebellum import Cerebellum, CerebellumTable
from torquebench.cbmc.neuron import Lif
from torquebench.cbmc.pathways import Ascending, Descending
from torquebench.cbmc.patterns import Patterns
from torquebench.cbmc.spinal_cord import RateEncoder, SpinalCord, SpinalCordTable
from torquebench.cbmc.thalamus import Thalamus, ThalamusTable

JOINTS, REPEATS = 7, 7
RATES = {"spinal cord": 1000, "brainstem": 100, "thalamus": 100, "cerebellum": 20}
"""Calls in a simulated second."""

INSTALL = "SpikingJelly is missing: pip install torch spikingjelly==0.0.0.0.14"

Calls = dict[str, Callable[[], object]]


def random_patterns(rng: np.random.Generator) -> Patterns:
    """Return two patterns with torch's default weights, those to PC four times as large, so that PC fire."""

    def draw(bound: float, *shape: int) -> np.ndarray:
        return rng.uniform(-bound, bound, (2, *shape)).astype(np.float32)

    return Patterns(
        granule=draw(0.38, 300, JOINTS),
        granule_bias=draw(0.38, 300),
        purkinje=draw(0.16, 300, 400),
        purkinje_bias=draw(0.04, 200),
        readout=draw(1.0, JOINTS, 200),
        readout_bias=draw(1.0, JOINTS),
        loads=(0.0, 3.0),
    )


def own_calls() -> Calls:
    """Return one call of each module of this library, learning included."""
    rng = np.random.default_rng(0)
    up, down = Ascending.of(JOINTS), Descending.of(JOINTS, 2)
    up.q[:], up.q_desired[:], up.wrench[:] = rng.normal(size=JOINTS), rng.normal(size=JOINTS), rng.normal(size=6)
    table = SpinalCordTable()
    spinal_cord = SpinalCord(JOINTS, table, RateEncoder(JOINTS, table, rng))
    cerebellum, thalamus = Cerebellum(random_patterns(rng)), Thalamus(JOINTS, 2, ThalamusTable(), rng)
    brainstem = Brainstem(JOINTS, BrainstemTable(), rng)
    for module in (spinal_cord, cerebellum, thalamus, brainstem):
        module.connect(up, down)
    weight_gradient, gain_gradient = np.array([1e-6, -1e-6]), np.full(2 * JOINTS, 1e-9)

    def second_order_thalamus() -> None:
        thalamus.weigh()
        thalamus.combine()
        thalamus.learn(weight_gradient)

    def second_order_brainstem() -> None:
        brainstem.gains()
        brainstem.learn(gain_gradient)

    return {
        "spinal cord": spinal_cord.act,
        "brainstem": second_order_brainstem,
        "thalamus": second_order_thalamus,
        "cerebellum": cerebellum.compensate,
    }


def peer_calls() -> Calls:
    """Return the same calls of networks built from SpikingJelly's modules."""
    torch = import_module("torch")
    functional, neuron, surrogate = (
        import_module(f"spikingjelly.activation_based.{name}") for name in ("functional", "neuron", "surrogate")
    )
    torch.set_num_threads(1)
    torch.manual_seed(0)

    def layer(lif: Lif) -> Any:
        smooth = surrogate.Sigmoid(alpha=5.0)
        return neuron.LIFNode(tau=lif.tau_mb, v_threshold=lif.u_fire, v_reset=lif.u_reset, surrogate_function=smooth)

    def two_layers(table: Any, inputs: int, outputs: int, answer: Callable[[Any], Any]) -> Callable[[], None]:
        hidden = table.hidden_neurons
        net = torch.nn.Sequential(
            torch.nn.Linear(inputs, hidden), layer(table.hidden), torch.nn.Linear(hidden, outputs), layer(table.output)
        )
        rule, x = table.descent, torch.randn(1, inputs)
        optimiser = torch.optim.SGD(
            net.parameters(), lr=rule.learning_rate, momentum=rule.momentum, weight_decay=rule.weight_decay
        )

        def call() -> None:
            functional.reset_net(net)
            for _ in range(table.window):
                net(x)
            optimiser.zero_grad()
            (1e-6 * answer(net[3].v)).sum().backward()
            optimiser.step()

        return call

    return {
        "spinal cord": _peer_spinal_cord(torch, layer(SpinalCordTable().membrane)),
        "brainstem": two_layers(BrainstemTable(), 4 * JOINTS, 2 * JOINTS, lambda v: v),
        "thalamus": two_layers(ThalamusTable(), 6, 2, lambda v: torch.softmax(v, dim=1)[:, 0]),
        "cerebellum": _peer_cerebellum(torch, functional, layer),
    }


def _peer_spinal_cord(torch: Any, membrane: Any) -> Callable[[], None]:
    """Return one tick of encoder and membrane."""
    error, gains = 0.1 * torch.randn(2, JOINTS, 1), torch.full((2, JOINTS), 20.0)

    def call() -> None:
        with torch.no_grad():
            fired = torch.rand(2, JOINTS, 50) <= error.abs() / 0.5
            membrane((gains * 0.01 * error.sign()[..., 0] * fired.sum(dim=2)).sum(dim=0))

    return call


def _peer_cerebellum(torch: Any, functional: Any, layer: Callable[[Lif], Any]) -> Callable[[], None]:
    """Return one window of two patterns."""
    table = CerebellumTable()
    linear = torch.nn.Linear
    sizes = ((JOINTS, 300), (600, 200), (200, table.nuclei_per_joint * JOINTS))
    neurons = (table.granule, table.purkinje, table.nuclei)
    patterns = [
        torch.nn.ModuleList(m for size, lif in zip(sizes, neurons, strict=True) for m in (linear(*size), layer(lif)))
        for _ in range(2)
    ]
    q = torch.randn(1, JOINTS)

    def call() -> None:
        with torch.no_grad():
            for net in patterns:
                functional.reset_net(net)
                before = torch.zeros(1, 300)
                for _ in range(table.window):
                    now = net[1](net[0](q))
                    net[5](net[4](net[3](net[2](torch.cat([now, before], dim=1)))))
                    before = now
                net[5].v.reshape(JOINTS, -1).mean(dim=1)

    return call


def seconds_per_call(call: Callable[[], object], *, budget: float = 0.05) -> float:
    """Return the least mean time of one call over several rounds of about ``budget`` seconds [s]."""
    call()
    start = time.perf_counter()
    call()
    count = max(1, int(budget / max(time.perf_counter() - start, 1e-7)))
    rounds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        for _ in range(count):
            call()
        rounds.append((time.perf_counter() - start) / count)
    return min(rounds)


def main() -> int:
    """Print a row for each module and the ratio; 0, or 2 where the peer is not installed."""
    try:
        peers = peer_calls()
    except ImportError:
        print(INSTALL)
        return 2
    own, total = own_calls(), np.zeros(2)
    print(f"{'module':12s} {'calls/s':>7s} {'torquebench us':>15s} {'SpikingJelly us':>16s}")
    for name, rate in RATES.items():
        times = np.array([seconds_per_call(calls[name]) for calls in (own, peers)])
        total += rate * times
        print(f"{name:12s} {rate:7d} {1e6 * times[0]:15.2f} {1e6 * times[1]:16.1f}")
    ours, theirs = 1e3 * total
    print(f"one simulated second: {ours:.2f} ms against {theirs:.0f} ms, {theirs / ours:.0f} times")
    return 0


if __name__ == "__main__":
    sys.exit(main())
