"""The classical laws as expression graphs, so that their operations can be counted and not guessed.

Each function writes the tick of one law, the model's equations included, in the words of the law's own file. What no
graph can hold (eigenvalues, which iterate) is returned beside it by formula.
"""

from collections.abc import Callable

import casadi as ca

from ..controllers.operations import OperationCounts
from .cartesian_impedance import CartesianImpedance
from .computed_torque import ComputedTorque
from .computed_torque_feedforward import ComputedTorqueFeedforward
from .computed_torque_pid import ComputedTorquePid
from .joint_impedance import JointImpedance
from .joint_pid import JointPid
from .operation_graph import TickGraph, cholesky, forward, rotation_error, symmetric_eigen
from .pd_gravity import PdGravity
from .slotine_li import SlotineLi
from .symbolic_dynamics import Expression, torque_expression

NOTHING = OperationCounts()

Write = Callable[[TickGraph, object], OperationCounts]
"""Writes a law's tick into a graph and returns what the graph cannot hold."""


def computed_torque(tick: TickGraph, law: object) -> OperationCounts:
    """Write feedback linearisation."""
    feedback = tick.gain("damping") * (tick.dq_ref - tick.dq) + tick.gain("stiffness") * (tick.q_ref - tick.q)
    tick.written.append(tick.inverse_dynamics(tick.q, tick.dq, tick.ddq_ref + feedback))
    return NOTHING


def computed_torque_feedforward(tick: TickGraph, law: object) -> OperationCounts:
    """Write inverse dynamics of the plan with springs and dampers."""
    plan = tick.inverse_dynamics(tick.q_ref, tick.dq_ref, tick.ddq_ref)
    tick.written.append(plan + spring_and_damper(tick))
    return NOTHING


def computed_torque_pid(tick: TickGraph, law: object) -> OperationCounts:
    """Write feedback linearisation with an integral."""
    error = tick.q_ref - tick.q
    integral = tick.reading("integral", tick.robot.n)
    acceleration = tick.gain("integral_gain") * integral + tick.ddq_ref
    acceleration += tick.gain("damping") * (tick.dq_ref - tick.dq) + tick.gain("stiffness") * error
    tick.written += [tick.inverse_dynamics(tick.q, tick.dq, acceleration), *integrated(tick, integral, error)]
    return NOTHING


def pd_gravity(tick: TickGraph, law: object) -> OperationCounts:
    """Write springs, dampers and gravity."""
    tick.written.append(spring_and_damper(tick) + tick.gravity())
    return NOTHING


def joint_pid(tick: TickGraph, law: object) -> OperationCounts:
    """Write a law without a model."""
    n = tick.robot.n
    spring, integral = tick.gain("stiffness", n) * (tick.q_ref - tick.q), tick.reading("integral", n)
    tick.written.append(tick.gain("damping", n) * (tick.dq_ref - tick.dq) + spring + integral)
    moved, previous = integrated(tick, integral, spring / tick.gain("reset_time"))
    clamp = tick.gain("clamp", n)
    tick.written += [ca.fmax(ca.fmin(moved, clamp), -clamp), previous]
    return NOTHING


def joint_impedance(tick: TickGraph, law: object) -> OperationCounts:
    """Write springs around the plan, damped by the square-root design."""
    n, mass = tick.robot.n, tick.mass_matrix()
    damping, _, beside = square_root_design(tick, n)
    torque = tick.bias() + tick.gain("stiffness", n) * (tick.q_ref - tick.q)
    tick.written.append(torque + mass @ tick.ddq_ref + damping @ (tick.dq_ref - tick.dq))
    tick.handed.append(mass)
    return beside


def cartesian_impedance(tick: TickGraph, law: object) -> OperationCounts:
    """Write a spring and a damper at the tool, with the posture behind them."""
    assert isinstance(law, CartesianImpedance)
    design = square_root_design if law.damping_design == "square_root" else double_diagonalised_design
    written, beside = impedance_torque(tick, design=design, limited=law.force_limit is not None)
    tick.written.append(written)
    return beside


def slotine_li(tick: TickGraph, law: object) -> OperationCounts:
    """Write the adaptive law with the regressor of its learnt parameters."""
    assert isinstance(law, SlotineLi)
    n, count, slope = tick.robot.n, law.parameters, tick.gain("slope")
    error, error_rate = tick.q_ref - tick.q, tick.dq_ref - tick.dq
    slide, velocity = error_rate + slope * error, tick.dq_ref + slope * error
    acceleration = tick.ddq_ref + slope * error_rate
    payload, load = ca.SX.sym("payload", 10), tick.reading("estimate", count)

    def mixed(reference: Expression, carried: Expression) -> Expression:
        def torque(dq: Expression, ddq: Expression) -> Expression:
            return torque_expression(tick.robot, tick.q, dq, ddq, carried)

        faster, slower = torque(tick.dq + velocity, tick.still), torque(tick.dq - velocity, tick.still)
        return torque(tick.still, reference) + 0.25 * (faster - slower)

    regressor = ca.jacobian(mixed(acceleration, payload), payload)[:, :count]
    drive = acceleration + slope * slide
    plain = mixed(drive, ca.SX.zeros(10)) + tick.gain("apparent", n) * drive
    known, rate = tick.reading("known", count), tick.gain("rate", count)
    lower, upper = tick.gain("lower", count), tick.gain("upper", count)
    total = known + load + rate * (regressor.T @ slide)
    tick.written += [plain + regressor @ load, ca.fmin(ca.fmax(total, lower), upper) - known]
    return NOTHING


def spring_and_damper(tick: TickGraph) -> Expression:
    """Return K e + D de, each joint its own gains."""
    n = tick.robot.n
    return tick.gain("stiffness", n) * (tick.q_ref - tick.q) + tick.gain("damping", n) * (tick.dq_ref - tick.dq)


def integrated(tick: TickGraph, integral: Expression, error: Expression) -> tuple[Expression, Expression]:
    """Return the integral after the tick, held at a limit and clamped, and the command that is remembered."""
    n = tick.robot.n
    effort, step, clamp = tick.gain("effort", n), tick.gain("step", n), tick.gain("integral_limit")
    previous = tick.reading("previous", n)
    at_limit = ca.logic_or(ca.fabs(tick.command) >= effort, ca.fabs(tick.command - previous) >= step)
    moved = ca.fmin(ca.fmax(integral + tick.gain("period") * error, -clamp), clamp)
    return ca.if_else(at_limit, integral, moved), tick.command


Design = Callable[[TickGraph, int], tuple[Expression, Expression, OperationCounts]]
"""Takes a size; returns damping and inertia of a spring of that size, and what the graph cannot hold."""


def square_root_design(tick: TickGraph, size: int) -> tuple[Expression, Expression, OperationCounts]:
    """Return damping and inertia by the square-root design."""
    vectors, masses, roots = eigenpairs(tick, size)
    root = tick.gain("root_stiffness", size)
    sums = ca.repmat(root, 1, size) + ca.repmat(root.T, size, 1)
    inertia = weighted(masses, vectors)
    damping = weighted(tick.gain("ratio") * roots, vectors) * sums
    return damping, inertia, symmetric_eigen(size) + OperationCounts(divisions=2 * size, comparisons=size)


def double_diagonalised_design(tick: TickGraph, size: int) -> tuple[Expression, Expression, OperationCounts]:
    """Return damping and inertia by double diagonalisation."""
    vectors, masses, roots = eigenpairs(tick, size)
    root = tick.gain("root_stiffness", size)
    scales = ca.tril2symm(ca.tril(root @ root.T))
    inertia = weighted(masses, vectors) * scales
    damping = weighted(2.0 * tick.gain("ratio") * ca.fmin(roots, 0.125), vectors) * scales
    scaled = OperationCounts(multiplications=2 * size * size)
    return damping, inertia, symmetric_eigen(size) + scaled + OperationCounts(divisions=2 * size, comparisons=size)


def eigenpairs(tick: TickGraph, size: int) -> tuple[Expression, Expression, Expression]:
    """Return eigenvectors, the eigenvalues' inverses and the roots of these, as a formula has computed them."""
    return tick.result("vectors", size, size), tick.result("masses", size), tick.result("roots", size)


def weighted(weights: Expression, vectors: Expression) -> Expression:
    """Return V diag(w) V^T; one triangle is computed."""
    scaled = vectors * ca.repmat(weights.T, vectors.shape[0], 1)
    return ca.tril2symm(ca.tril(scaled @ vectors.T))


def tool_mobility(mass: Expression, jacobian: Expression) -> Expression:
    """Return J M^-1 J^T by the factor of M."""
    half = forward(cholesky(mass), jacobian.T)
    return ca.tril2symm(ca.tril(half.T @ half))


def impedance_torque(
    tick: TickGraph, *, design: Design, limited: bool, gains_on_acceleration: bool = False
) -> tuple[Expression, OperationCounts]:
    """Return the torque of pose and posture, and the eigenvalues beside it; the mobility is handed over."""
    mass, (position, rotation, jacobian) = tick.mass_matrix(), tick.tool()
    goal, turn = tick.reading("goal", 3), tick.reading("goal_rotation", 3, 3)
    twist_ref, acceleration_ref = tick.reading("twist_ref", 6), tick.reading("acceleration_ref", 6)
    mobility = tool_mobility(mass, jacobian)
    tick.handed.append(mobility)
    damping, inertia, beside = design(tick, 6)
    error = ca.vertcat(goal - position, rotation_error(rotation, turn))
    spring = tick.gain("stiffness", 6) * error
    if gains_on_acceleration:
        spring, damping = tick.gain("k_p") * inertia @ error, tick.gain("k_d") * inertia
    if limited:
        limit = tick.gain("limit", 6)
        spring = ca.fmin(ca.fmax(spring, -limit), limit)
    posture = tick.ddq_ref + tick.gain("k_n") * (tick.q_ref - tick.q) + tick.gain("d_n") * (tick.dq_ref - tick.dq)
    jacobian_bias = ca.jtimes(jacobian @ tick.dq, tick.q, tick.dq)
    slip = tick.gain("beta") * twist_ref - jacobian @ tick.dq
    push = tick.gain("alpha") * (acceleration_ref - jacobian_bias) - jacobian @ posture
    torque = tick.bias() + mass @ posture + jacobian.T @ (spring + damping @ slip + inertia @ push)
    return torque, beside


LAWS: dict[type, Write] = {
    ComputedTorque: computed_torque,
    ComputedTorqueFeedforward: computed_torque_feedforward,
    ComputedTorquePid: computed_torque_pid,
    PdGravity: pd_gravity,
    JointPid: joint_pid,
    JointImpedance: joint_impedance,
    CartesianImpedance: cartesian_impedance,
    SlotineLi: slotine_li,
}
"""How each law without solver and neurons is written."""
