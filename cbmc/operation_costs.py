"""What the modules' own counters are worth in the common vocabulary, and how much memory the modules keep."""

from ..controllers.operations import OperationCosts, OperationCounts
from .cerebellum import Cerebellum
from .online_network import OnlineNetwork
from .stack import Stack

WORTH: dict[str, OperationCounts] = {
    "dense": OperationCounts(dense=1),
    "effective_macs": OperationCounts(effective_macs=1),
    "effective_acs": OperationCounts(effective_acs=1),
    # A product or an accumulate reads one weight; a membrane is read and written.
    "executed_macs": OperationCounts(macs=1, touched=1),
    "executed_acs": OperationCounts(acs=1, touched=1),
    "membrane_updates": OperationCounts(membrane_updates=1, touched=2),
    "executed_learning_macs": OperationCounts(learning_macs=1, touched=1),
    "surrogate_steps": OperationCounts(learning_macs=1),
    # Parameter and momentum, each read and written.
    "parameter_updates": OperationCounts(parameter_updates=1, touched=4),
    "other": OperationCounts(multiplications=1),
}
"""One count of a module with weights."""

FIBRES: dict[str, OperationCounts] = {
    **WORTH,
    # Fibres have no weights: a spike is a draw that lies below its threshold, and adds one.
    "executed_acs": OperationCounts(acs=1),
    "random_draws": OperationCounts(random_draws=1, comparisons=1),
}
"""One count of the spinal cord."""

HOW = "counters of the modules, as their kernels compute; stand-ins for a module count nothing"


def stack_costs(stack: Stack) -> OperationCosts:
    """Return what the counters of a stack are worth, and the numbers that it keeps.

    Args:
        stack: After a reset.
    """
    events = {
        f"{module}_{name}": worth
        for module in ("cerebellum", "thalamus", "brainstem", "spinal_cord")
        for name, worth in (FIBRES if module == "spinal_cord" else WORTH).items()
    }
    parameters = state = 0
    if isinstance(stack.cerebellum, Cerebellum):
        kept = stack.cerebellum.patterns
        arrays = (kept.granule, kept.granule_bias, kept.purkinje, kept.purkinje_bias, kept.readout, kept.readout_bias)
        parameters += sum(array.size for array in arrays)
        # Potential of every granule and Purkinje cell, and whether it fired last.
        state += 2 * (kept.granule_bias.size + kept.purkinje_bias.size)
    for module in (stack.thalamus, stack.brainstem):
        network = getattr(module, "network", None)
        if isinstance(network, OnlineNetwork):
            parameters += network.parameters.size
            state += network.memory.size - network.parameters.size
    # Angles, rates, their plan, gains, torques: the pathways and the membranes of the spinal cord.
    state += 9 * stack.ascending.q.size + stack.descending.compensation.size
    return OperationCosts(by_event=events, parameters=int(parameters), state=int(state), how=HOW)
