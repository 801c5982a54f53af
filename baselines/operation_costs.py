"""What each controller of this room computes: its graph, its solver's formulas, its neurons' own counters."""

from ..controllers import RobotModel
from ..controllers.operations import OperationCosts, OperationCounts
from .law_graphs import LAWS, pd_gravity
from .mpc import Mpc
from .mpc_offset_free import MpcOffsetFree
from .mpc_tool import MpcTool
from .operation_graph import TickGraph
from .solver_costs import mpc_costs, whole_body_costs
from .spiking_adaptive import SpikingAdaptive
from .whole_body_qp import WholeBodyQp
from .whole_body_qp_strict import WholeBodyQpStrict

GRAPH = "expression graph of the tick, model included"

ENSEMBLE: dict[str, OperationCounts] = {
    "ensemble_dense": OperationCounts(dense=1),
    "ensemble_effective_macs": OperationCounts(effective_macs=1),
    "ensemble_effective_acs": OperationCounts(effective_acs=1),
    "ensemble_executed_macs": OperationCounts(macs=1, touched=1),
    # Potential and filtered rate, each read and written.
    "ensemble_membrane_dense": OperationCounts(membrane_updates=1, macs=1, touched=4),
    # The decoder was read to decode; learning multiplies, adds and writes it.
    "ensemble_parameter_updates": OperationCounts(learning_macs=1, parameter_updates=1, touched=1),
}
"""One count of the ensemble's counters; the exponentials of neurons that end their rest or fire are left out."""


def operation_costs(robot: RobotModel, law: object) -> OperationCosts | None:
    """Return what a law computes on an arm, None if it is no law of this room.

    Args:
        robot: The arm.
        law: Built, not necessarily reset: only its settings are read. A subclass from elsewhere is another law.
    """
    kind = type(law)
    if isinstance(law, WholeBodyQp) and kind in (WholeBodyQp, WholeBodyQpStrict):
        return whole_body_costs(robot, law)
    if isinstance(law, Mpc) and kind in (Mpc, MpcTool, MpcOffsetFree):
        return mpc_costs(robot, law)
    if isinstance(law, SpikingAdaptive):
        return spiking_adaptive_costs(robot, law)
    write = LAWS.get(kind)
    if write is None:
        return None
    graph = TickGraph(robot=robot)
    beside = write(graph, law)
    found = graph.count()
    events = {"ticks": found.operations + beside}
    how = f"{GRAPH}; eigenvalues by formula" if beside != OperationCounts() else GRAPH
    return OperationCosts(by_event=events, parameters=found.parameters, state=found.state, how=how)


def gravity_feedback_costs(robot: RobotModel) -> OperationCosts:
    """Return what springs, dampers and gravity compensation cost, whoever runs them."""
    graph = TickGraph(robot=robot)
    pd_gravity(graph, None)
    found = graph.count()
    return OperationCosts(
        by_event={"ticks": found.operations}, parameters=found.parameters, state=found.state, how=GRAPH
    )


def spiking_adaptive_costs(robot: RobotModel, law: SpikingAdaptive) -> OperationCosts:
    """Return what is left of the law beside its ensemble, whose own counters count the rest.

    Args:
        robot: The arm.
        law: With its number of neurons.
    """
    graph, n = TickGraph(robot=robot), robot.n
    feedback = graph.gain("stiffness") * (graph.q_ref - graph.q) + graph.gain("damping") * (graph.dq_ref - graph.dq)
    torque = graph.inverse_dynamics(graph.q, graph.dq, graph.ddq_ref + feedback)
    error = torque - graph.inverse_dynamics(graph.q, graph.dq, graph.ddq_ref)
    adaptive, centre, scale = graph.reading("adaptive", n), graph.gain("centre", 2 * n), graph.gain("scale", 2 * n)
    point = [(graph.q - centre[:n]) * scale[:n], (graph.dq - centre[n:]) * scale[n:]]
    graph.written += [torque + adaptive, error, *point]
    found = graph.count()
    # Encoders, biases and decoders; potential, refractory time, filtered rate.
    parameters, state = found.parameters + law.neurons * (2 * n + 1 + n), found.state + 3 * law.neurons
    how = f"{GRAPH}; the ensemble by its own counters"
    events = {"ticks": found.operations, **ENSEMBLE}
    return OperationCosts(by_event=events, parameters=parameters, state=state, how=how)
