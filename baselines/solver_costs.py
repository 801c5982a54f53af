"""Operations of the laws that solve a program: matrices by formula, the model by its graph, iterations as measured.

A solver's iterations depend on the run, so the costs are by event: a tick, a solve, an iteration. What depends on which
rows are active (refactorisations, the refinement on them) is left out: the counts are lower bounds.
"""

import casadi as ca
import numpy as np

from ..controllers import RobotModel
from ..controllers.operations import OperationCosts, OperationCounts
from .law_graphs import (
    computed_torque,
    double_diagonalised_design,
    impedance_torque,
    square_root_design,
)
from .mpc import Mpc
from .mpc_horizon import Horizon
from .mpc_offset_free import MpcOffsetFree
from .mpc_tool import MpcTool
from .operation_graph import GraphCounts, TickGraph, cholesky, count_graph, forward, symmetric_eigen
from .symbolic_dynamics import Expression, tool_function, torque_function
from .whole_body_qp import WholeBodyQp
from .whole_body_qp_strict import WholeBodyQpStrict

HOW = "graph of tick and model; formulas for matrices and solver; solves and iterations as measured: a lower bound"


def factorisation(size: int) -> OperationCounts:
    """Return what the factor of a symmetric matrix costs: (n^3 - n) / 6 products, a division or root for each entry."""
    return OperationCounts(
        macs=(size**3 - size) / 6, divisions=size * (size + 1) / 2, touched=size * size + size * (size + 1) / 2
    )


def program_iteration(variables: int, rows: int, *, is_projection: bool) -> OperationCounts:
    """Return what an inner iteration of the augmented Lagrangian costs.

    Two triangular solves, and products of Hessian, rows and transposed rows with a vector. Source: Bambade,
    El-Kazdadi, Taylor, Carpentier, ProxQP, Robotics: Science and Systems (2022), section IV.

    Args:
        variables: Number of variables.
        rows: Number of rows.
        is_projection: Whether the Hessian is the identity.
    """
    square = variables if is_projection else 2 * variables**2
    products = square + 2 * variables * rows
    return OperationCounts(macs=products, comparisons=2 * rows, divisions=variables, touched=products)


def whole_body_costs(robot: RobotModel, law: WholeBodyQp) -> OperationCosts:
    """Return the costs of a whole-body program.

    The two programs of the strict version share their counters; each is priced as the larger first one.

    Args:
        robot: The arm.
        law: Which version.
    """
    n, graph = robot.n, TickGraph(robot=robot)
    dd = law.gain_form == "force" and law.damping_design != "square_root"
    design = double_diagonalised_design if dd else square_root_design
    free, beside = impedance_torque(graph, design=design, limited=False, gains_on_acceleration=law.gain_form != "force")
    inertia = graph.result("inertia", 6, 6)
    mass, jacobian = graph.mass_matrix(), graph.tool()[2]
    for _ in range(2 if isinstance(law, WholeBodyQpStrict) else 1):
        graph.written += task_matrices(graph, mass, jacobian, inertia, free)
    graph.written += limit_rows(graph, mass, free)
    found = graph.count()
    tick = found.operations + beside
    if isinstance(law, WholeBodyQpStrict):
        tick += symmetric_eigen(n) + OperationCounts(macs=6 * n * n + 4 * n * n, divisions=n * n)
    size = 2 * n
    solve = factorisation(size) + OperationCounts(macs=2 * size * size + size * size, comparisons=2 * size)
    events = {
        "ticks": tick,
        "qp_solves": solve,
        "qp_iterations": program_iteration(size, size, is_projection=False),
    }
    # Hessian, its factor, rows; gradient, bounds, solution and multipliers.
    kept = 3 * size * size + 5 * size
    return OperationCosts(by_event=events, parameters=found.parameters, state=found.state + kept, how=HOW)


def task_matrices(
    graph: TickGraph, mass: Expression, jacobian: Expression, inertia: Expression, free: Expression
) -> list[Expression]:
    """Return Hessian and gradient of the tasks in scaled unknowns; one triangle of the Hessian is computed."""
    weights = graph.gain("weights", 4)
    root = ca.sqrt(ca.diag(mass))
    matrix = weights[0] * mass + weights[1] * jacobian.T @ (inertia @ jacobian) + weights[2] * mass @ mass
    return [ca.tril(matrix / (root @ root.T)), weights[2] * (mass @ free) / root]


def limit_rows(graph: TickGraph, mass: Expression, free: Expression) -> list[Expression]:
    """Return rows and bounds of torque and acceleration, and the torque of a solution."""
    n, root = graph.robot.n, ca.sqrt(ca.diag(mass))
    factor = cholesky(mass)
    half = forward(factor, free - graph.bias())
    acceleration = backward(factor, half)
    effort, step = graph.gain("effort", n), graph.gain("step", n)
    low, high = graph.command - step, graph.command + step
    least, most = ca.fmin(ca.fmax(-effort, low), high), ca.fmax(ca.fmin(effort, high), low)
    lowest, highest = viable(graph)
    beyond = graph.reading("solution", n)
    torque = ca.fmin(ca.fmax(free + mass @ (beyond / root), least), most)
    bounds = [(least - free) / root, (most - free) / root, (lowest - acceleration) * root]
    return [ca.tril(mass / (root @ root.T)), *bounds, (highest - acceleration) * root, torque]


def backward(factor: Expression, right: Expression) -> Expression:
    """Return the solution of L^T x = b, written out."""
    n = right.shape[0]
    result = ca.SX.zeros(n)
    for i in range(n - 1, -1, -1):
        rest = right[i] - ca.dot(factor[i + 1 :, i], result[i + 1 :]) if i + 1 < n else right[i]
        result[i] = rest / factor[i, i]
    return result


def viable(graph: TickGraph) -> tuple[Expression, Expression]:
    """Return the accelerations from which every joint can still stop."""
    n, h = graph.robot.n, graph.gain("period")
    lower, upper, velocity = graph.gain("lower", n), graph.gain("upper", n), graph.gain("velocity", n)
    reach, brake = graph.gain("reach", n), graph.gain("brake", n)

    def largest(room: Expression, speed: Expression) -> Expression:
        step = h * speed
        bound = ca.fmin(reach, ca.fmin((velocity - speed) / h, (room - step) / (h * h)))
        b = 2.0 * step + brake * (h * h)
        discriminant = b * b - 4.0 * (h * h) * (speed * speed - 2.0 * brake * (room - step))
        stop = -speed / h
        braked = ca.fmax((-b + ca.sqrt(discriminant)) / (2.0 * h * h), stop)
        return ca.fmax(ca.fmin(bound, ca.if_else(discriminant < 0.0, stop, braked)), -reach)

    return -largest(graph.q - lower, -graph.dq), largest(upper - graph.q, graph.dq)


def mpc_costs(robot: RobotModel, law: Mpc) -> OperationCosts:
    """Return the costs of a predictive law: its inner law at every tick, model and condensing for each plan.

    Args:
        robot: The arm.
        law: Which version.
    """
    horizon = Horizon.of(tuple(law.blocks), law.interval)
    tick = _inner_law(robot, law)
    model = count_graph(torque_function(robot))
    n, knots, blocks = robot.n, *horizon.selection.shape
    variables, rows = blocks * n, knots * n
    plan = model.operations.times(knots) + _condensing(n, knots, blocks)
    if isinstance(law, MpcTool):
        plan += _tool_cost(robot, horizon)
    events = {
        "ticks": tick.operations,
        "mpc_solves": plan,
        "qp_solves": OperationCounts(macs=rows * variables, comparisons=2 * rows, touched=rows * variables),
        "qp_iterations": program_iteration(variables, rows, is_projection=True),
    }
    # Torque rows, bounds, gradient, solution; the roll-out and the running plan; a Hessian where it changes.
    kept = rows * variables + 4 * rows + 3 * variables + 6 * (knots + 1) * n
    kept += 2 * variables**2 if isinstance(law, MpcTool) else 0
    matrices = (2 * knots + 2 + knots) * blocks + blocks**2 + 4 * knots
    parameters = tick.parameters + model.parameters + matrices
    return OperationCosts(by_event=events, parameters=parameters, state=tick.state + kept, how=HOW)


def _inner_law(robot: RobotModel, law: Mpc) -> GraphCounts:
    """Count the law that follows a plan at every tick, and the disturbance's observer if there is one."""
    graph, n = TickGraph(robot=robot), robot.n
    graph.q_ref, graph.dq_ref, graph.ddq_ref = planned_state(graph)
    computed_torque(graph, law)
    if isinstance(law, MpcOffsetFree):
        mass, previous, passed = graph.mass_matrix(), graph.reading("momentum", n), graph.reading("passive", n)
        filtered, residual, torque = (graph.reading(name, n) for name in ("filtered", "residual", "torque"))
        momentum = mass @ graph.dq
        # The transposed Coriolis matrix times dq is the gradient of the kinetic energy.
        passive = ca.gradient(0.5 * ca.dot(graph.dq, momentum), graph.q) - graph.gravity()
        drive = filtered + graph.gain("filter_share") * (torque + 0.5 * (passive + passed) - filtered)
        change = (momentum - previous) / graph.gain("observer_period") - drive - residual
        moved = residual + graph.gain("share") * change
        graph.written[-1] -= moved
        graph.written += [momentum, passive, drive, moved]
    return graph.count()


def planned_state(graph: TickGraph) -> tuple[Expression, Expression, Expression]:
    """Return what the running plan is at a time between two of its knots."""
    n, since = graph.robot.n, graph.reading("since", 1)
    q, dq, ddq = (graph.reading(name, n) for name in ("plan_q", "plan_dq", "plan_ddq"))
    return q + since * (dq + 0.5 * since * ddq), dq + since * ddq, ddq


def _condensing(n: int, knots: int, blocks: int) -> OperationCounts:
    """Return what the kernels of a plan do: two roll-outs, gradient, torque rows, room, check, change of unknowns."""
    roll_outs = 2 * n * blocks * (2 * (knots + 1) + knots)
    gradient, torque_rows = 7 * knots * blocks * n, 3 * knots * n * blocks * n
    check, change = knots * n * blocks * n, blocks * blocks * n
    macs = roll_outs + gradient + torque_rows + check + change
    return OperationCounts(
        macs=macs,
        additions=knots * n * 7,
        multiplications=knots * n,
        comparisons=2 * knots * n,
        touched=knots * 4 * n * n + 2 * knots * n * blocks * n + 8 * knots * n,
    )


def _tool_cost(robot: RobotModel, horizon: Horizon) -> OperationCounts:
    """Return what the tool's cost adds to a plan: kinematics, curvature, and the factor of a Hessian that changes."""
    n, knots, blocks = robot.n, *horizon.selection.shape
    variables, rows = blocks * n, knots * n
    # Every block that has begun by a knot is multiplied with itself and all later ones.
    begun = np.count_nonzero(horizon.position[1:], axis=1)
    slopes = knots * (12 * n + 12 * n * (n + 1) // 2)
    hessian = int(np.sum(begun * n + (begun * blocks - begun * (begun - 1) // 2) * n * n))
    whitening = (rows + 2) * variables * (variables - 1) // 2
    products = OperationCounts(macs=slopes + hessian + whitening, divisions=(rows + 2) * variables)
    return count_graph(tool_function(robot)).operations.times(knots) + products + factorisation(variables)
