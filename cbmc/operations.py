"""How many operations the modules have done, by NeuroBench's definitions and as the kernels really do them.

NeuroBench (2.3) evaluates every layer at every step of a window: an effective operation is a product of a non-zero
weight and a non-zero input, an accumulate (AC) where the layer's input is spikes, a multiply-accumulate (MAC) where
it is analogue; dense counts every weight. A membrane update is a neuron-step that moves the potential, so a spike
after a spike is none. The kernels evaluate a constant input once a window and a linear readout once on its trace:
that is "executed". Learning, random draws, softmax, filter and gains are outside NeuroBench's definitions and stand
apart. The modules count calls and spikes while they run; here these become operations, at no cost to a tick.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

from . import online_kernels, spinal_cord
from .brainstem import Brainstem
from .cerebellum import GRANULE, GRANULE_LAST, GRANULE_PAIRS, PURKINJE, PURKINJE_PAIRS, Cerebellum
from .online_network import OnlineNetwork
from .spinal_cord import RateEncoder, SpinalCord
from .thalamus import Thalamus


@dataclass(frozen=True, kw_only=True)
class Operations:
    """Counts of one module since its construction.

    Attributes:
        calls: Windows, for the spinal cord ticks.
        dense: Synaptic operations if every weight and input counted.
        effective_macs: Multiply-accumulates as defined.
        effective_acs: Accumulates as defined.
        executed_macs: Multiply-accumulates as done.
        executed_acs: Accumulates as done.
        membrane_dense: Neuron-steps.
        membrane_updates: Neuron-steps that moved a potential; non-spiking neurons move at each.
        learning_macs: Backward passes as defined: twice the dense forward count.
        executed_learning_macs: Backward passes as done, the surrogate's recursion apart.
        surrogate_steps: Neuron-steps of that recursion.
        parameter_updates: Parameters moved by descent.
        other: Multiplications outside the definitions: input scaling, softmax, mixture, gains.
        random_draws: Uniform numbers drawn.
    """

    calls: int
    dense: int
    effective_macs: int = 0
    effective_acs: int
    executed_macs: int = 0
    executed_acs: int
    membrane_dense: int
    membrane_updates: int
    learning_macs: int = 0
    executed_learning_macs: int = 0
    surrogate_steps: int = 0
    parameter_updates: int = 0
    other: int
    random_draws: int = 0


def count_operations(*modules: object) -> dict[str, int]:
    """Return all counts as ``<module>_<count>``, cumulative since the modules were made.

    Args:
        *modules: A stack's modules in any order; whatever has no neurons (a stand-in) counts nothing.
    """
    return {
        f"{name}_{key}": value
        for module in modules
        for name, operations in _count(module)
        for key, value in asdict(operations).items()
    }


def _count(module: object) -> Iterator[tuple[str, Operations]]:
    if isinstance(module, Cerebellum):
        yield "cerebellum", cerebellum_operations(module)
    elif isinstance(module, Thalamus):
        yield "thalamus", thalamus_operations(module)
    elif isinstance(module, Brainstem):
        yield "brainstem", brainstem_operations(module)
    elif isinstance(module, SpinalCord):
        yield "spinal_cord", spinal_cord_operations(module)


def cerebellum_operations(module: Cerebellum) -> Operations:
    """Count all patterns: MF to GC on angles, GC (now and before) to PC and PC to DCN on spikes."""
    patterns, gc, joints = module.patterns.granule.shape
    pc, dcn, steps = module.patterns.purkinje_bias.shape[1], module.table.nuclei_per_joint * joints, module.table.window
    windows = int(module.tally[0]) * patterns
    spikes = module.counted.sum(axis=1)
    to_purkinje = pc * int(2 * spikes[GRANULE] - spikes[GRANULE_LAST])
    membrane = windows * steps * (gc + pc + dcn)
    return Operations(
        calls=int(module.tally[0]),
        dense=windows * steps * (joints * gc + 2 * gc * pc + pc * dcn),
        effective_macs=windows * steps * joints * gc,
        effective_acs=to_purkinje + dcn * int(spikes[PURKINJE]),
        executed_macs=windows * (joints * gc + steps * pc + pc * joints),
        executed_acs=to_purkinje,
        membrane_dense=membrane,
        membrane_updates=membrane - int(spikes[GRANULE_PAIRS] + spikes[PURKINJE_PAIRS]),
        other=0,
    )


def thalamus_operations(module: Thalamus) -> Operations:
    """Count the network and the filter layer; other: scaling, softmax and mixture."""
    filtered = int(module.mixtures[0]) * module.joints
    other = int(module.network.tally[online_kernels.CALLS]) * (6 + module.patterns) + filtered * module.patterns
    return _network_operations(module.network, extra_neuron_steps=filtered, other=other)


def brainstem_operations(module: Brainstem) -> Operations:
    """Count the network; other: scaling of the gains."""
    other = int(module.network.tally[online_kernels.CALLS]) * 2 * module.joints
    return _network_operations(module.network, extra_neuron_steps=0, other=other)


def _network_operations(network: OnlineNetwork, *, extra_neuron_steps: int, other: int) -> Operations:
    """Count a two-layer network: analogue input to hidden spikes to potentials, and its learning."""
    inputs, hidden, outputs = network.layers
    steps = network.window
    calls, updates, skipped, spikes, pairs = (int(value) for value in network.tally)
    dense = steps * (inputs * hidden + hidden * outputs)
    membrane = calls * steps * (hidden + outputs) + extra_neuron_steps
    parameters = inputs * hidden + hidden * outputs + (hidden + outputs) * network.biases
    return Operations(
        calls=calls,
        dense=calls * dense,
        effective_macs=calls * steps * inputs * hidden,
        effective_acs=outputs * spikes,
        executed_macs=calls * (inputs * hidden + hidden * outputs),
        executed_acs=spikes,
        membrane_dense=membrane,
        membrane_updates=membrane - pairs,
        learning_macs=(updates + skipped) * 2 * dense,
        executed_learning_macs=(updates + skipped) * (inputs * hidden + 2 * hidden * outputs),
        surrogate_steps=(updates + skipped) * steps * hidden,
        parameter_updates=updates * parameters,
        other=other,
    )


def spinal_cord_operations(module: SpinalCord) -> Operations:
    """Count single spikes, not their sums; other: the gains, two multiplications a joint."""
    ticks, spikes = int(module.tally[spinal_cord.CALLS]), int(module.tally[spinal_cord.SPIKES])
    fibres = 2 * module.table.fibres * module.joints if isinstance(module.encoder, RateEncoder) else 0
    return Operations(
        calls=ticks,
        dense=ticks * fibres,
        effective_acs=spikes,
        executed_acs=ticks * fibres // 2,
        membrane_dense=ticks * module.joints,
        membrane_updates=ticks * module.joints,
        other=ticks * 2 * module.joints,
        random_draws=ticks * fibres // 2,
    )
