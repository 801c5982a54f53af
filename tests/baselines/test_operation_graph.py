"""Counts are worth what their graphs are worth: the graphs must compute what the laws and the model compute."""

import re

import casadi as ca
import numpy as np
import pytest
from torquebench.baselines.cartesian_impedance import CartesianImpedance
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.computed_torque_feedforward import ComputedTorqueFeedforward
from torquebench.baselines.computed_torque_pid import ComputedTorquePid
from torquebench.baselines.joint_impedance import JointImpedance
from torquebench.baselines.law_graphs import LAWS
from torquebench.baselines.operation_graph import (
    TickGraph,
    cholesky,
    count_graph,
    forward,
    rotation_error,
    torque_expression,
)
from torquebench.baselines.pd_gravity import PdGravity
from torquebench.baselines.rotation import rotation_error as executed_error
from torquebench.baselines.slotine_li import SlotineLi
from torquebench.controllers.operations import OperationCounts


def counted(*outputs, inputs):
    return count_graph(ca.Function("f", inputs, ca.cse(list(outputs)))).operations


def test_every_operation_is_counted_once_by_its_kind():
    """a b + a b shares its product; what is shared is computed once."""
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    found = counted(a * b + ca.sin(a * b), ca.sqrt(a) / b - ca.fmin(a, b), inputs=[a, b])
    expected = OperationCounts(multiplications=1, additions=2, divisions=2, transcendentals=1, comparisons=1, touched=4)
    assert found == expected


def test_an_operation_without_a_name_is_no_silent_zero():
    a = ca.SX.sym("a")
    with pytest.raises(KeyError):
        counted(ca.erf(a), inputs=[a])


MODEL = {
    "inverse dynamics": (lambda g: [torque_expression(g.robot, g.q, g.dq, g.ddq_ref, ca.SX.zeros(10))], 1134, 932),
    "gravity": (lambda g: [torque_expression(g.robot, g.q, g.still, g.still, ca.SX.zeros(10))], 264, 252),
    "position": (lambda g: [g.tool()[0]], 180, None),
    "kinematics": (lambda g: list(g.tool()[:2]), 211, 191),
    "kinematics and jacobian": (lambda g: list(g.tool()), 291, 271),
    "mass matrix": (lambda g: [ca.tril(g.mass_matrix())], 1524, 1927),
}
"""What is written, its operations here, and in a prototype that was written for one arm with its links' own axes.

Here inverse dynamics balance moments about the joints with ten parameters a link, so that a payload enters linearly:
a fifth more. Kinematics here count signs. The mass matrix here is one triangle; by unit accelerations it is all of it.
"""


@pytest.mark.parametrize("name", MODEL)
def test_the_model_of_the_arm_costs_what_it_did(rizon, name):
    """Every law's count rests on these; within a quarter they are those of independent code."""
    write, here, elsewhere = MODEL[name]
    graphs = [TickGraph(robot=rizon.model(rotor_inertia=rizon.rotor_inertia)) for _ in range(2)]
    for graph in graphs:
        graph.written += write(graph)
    first, second = (graph.count().operations for graph in graphs)
    assert first == second
    assert first.arithmetic == here
    assert elsewhere is None or 0.75 < here / elsewhere < 1.25


@pytest.mark.parametrize("law", [law() for law in LAWS], ids=[law.__name__ for law in LAWS])
def test_fewer_joints_cost_less_and_the_load_nothing(bench, load, law):
    """A payload is part of the last link: knowing it changes numbers and no operation."""
    costs = []
    for arm in ("seven", "six", "planar"):
        model = bench(arm).model
        for mass in (0.0, 2.0):
            model.set_payload(load(mass, z=0.1))
            graph = TickGraph(robot=model)
            LAWS[type(law)](graph, law)
            costs.append(graph.count().operations)
    seven, loaded, six, _, planar, _ = costs
    assert seven == loaded
    assert seven.arithmetic > six.arithmetic > planar.arithmetic > 0


def evaluated(graph, expressions, known):
    """Return expressions at known numbers, each for the symbol of its name; what a law does not have is zero."""
    symbols = [*graph.read, *graph.gains, *graph.given]
    values = [known.get(re.sub(r"_\d+$", "", str(symbol[0, 0])), 0.0) for symbol in symbols]
    columns = [np.reshape(value, (-1, 1)) if np.ndim(value) < 2 else value for value in values]
    shaped = [np.broadcast_to(column, symbol.shape) for column, symbol in zip(columns, symbols, strict=True)]
    return ca.Function("law", symbols, expressions)(*(ca.DM(np.array(value, dtype=float)) for value in shaped))


LAWS_TRIED = {
    "computed_torque": ComputedTorque(),
    "feedforward": ComputedTorqueFeedforward(),
    "pid": ComputedTorquePid(),
    "pd": PdGravity(velocity_feedforward=True),
    "joint impedance": JointImpedance(),
    "impedance": CartesianImpedance(velocity_feedforward=True, acceleration_feedforward=True),
    "double diagonalisation": CartesianImpedance(damping_design="double_diagonalisation"),
    "adaptive": SlotineLi(),
}


@pytest.mark.parametrize("name", LAWS_TRIED)
def test_a_graph_computes_the_torque_of_its_law(bench, name):
    """A forgotten term is a forgotten cost: the expressions must be the law."""
    law, arm = LAWS_TRIED[name], bench(sway=0.3)
    law.reset(arm.task())
    target = arm.plan.target(0.1)
    rng = np.random.default_rng(3)
    q, dq = target.q + 0.02 * rng.normal(size=7), target.dq + 0.1 * rng.normal(size=7)
    torque = law.compute(arm.observe(0.1, q, dq), target).copy()
    graph = TickGraph(robot=arm.model)
    LAWS[type(law)](graph, law)
    known = {
        "q": q, "dq": dq, "q_ref": target.q, "dq_ref": target.dq, "ddq_ref": target.ddq,
        "rotor": arm.model.rotor_inertia, "apparent": arm.model.rotor_inertia,
        "goal": target.pose[:3, 3], "goal_rotation": target.pose[:3, :3],
        "twist_ref": target.twist, "acceleration_ref": target.acceleration, **settings_of(law),
    }  # fmt: skip
    if graph.handed:
        known |= eigenpairs_of(law, np.array(evaluated(graph, graph.handed, known)))
    found = np.array(evaluated(graph, graph.written[:1], known)).ravel()
    assert found == pytest.approx(torque, abs=1e-6 * np.abs(torque).max())


def settings_of(law):
    """Return what a law calls its gains by the names of its graph."""
    if isinstance(law, CartesianImpedance):
        beta, alpha = law._feedforward
        return {
            "stiffness": law._stiffness, "root_stiffness": np.sqrt(law._stiffness), "ratio": law.damping_ratio,
            "k_n": law.posture_stiffness, "d_n": law.posture_damping, "beta": beta, "alpha": alpha,
        }  # fmt: skip
    if isinstance(law, JointImpedance):
        return {"stiffness": law.springs, "root_stiffness": np.sqrt(law.springs), "ratio": law.damping_ratio}
    if isinstance(law, SlotineLi):
        return {"slope": law.bandwidth, "upper": law._upper, "lower": law._lower, "rate": law._rate}
    if isinstance(law, PdGravity):
        return {"stiffness": law.springs, "damping": law.dampers}
    return {"stiffness": law.stiffness, "damping": law.damping}


def eigenpairs_of(law, matrix):
    """Return what the formula beside the graph computes."""
    if isinstance(law, JointImpedance):
        values, vectors = np.linalg.eigh(matrix)
        return {"vectors": vectors, "masses": values, "roots": np.sqrt(values)}
    if law.damping_design == "double_diagonalisation":
        root = np.sqrt(law._stiffness)
        values, vectors = np.linalg.eigh(root[:, None] * matrix * root)
    else:
        values, vectors = np.linalg.eigh(matrix)
    return {"vectors": vectors, "masses": 1.0 / values, "roots": 1.0 / np.sqrt(values)}


def test_factor_and_substitution_written_out_are_those_of_linear_algebra():
    rng = np.random.default_rng(0)
    root = rng.normal(size=(5, 5))
    matrix, right = root @ root.T + np.eye(5), rng.normal(size=(5, 2))
    symbol = ca.SX.sym("m", 5, 5)
    factor = ca.Function("f", [symbol], [cholesky(symbol)])(matrix).full()
    assert factor == pytest.approx(np.linalg.cholesky(matrix))
    solved = np.array(ca.DM(forward(ca.SX(ca.DM(factor)), ca.SX(ca.DM(right)))))
    assert solved == pytest.approx(np.linalg.solve(factor, right))


def test_the_branch_of_small_rotations_is_the_kernels():
    angle = 0.1
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    error = np.empty(3)
    executed_error(np.eye(3), turn, error)
    written = ca.DM(rotation_error(ca.SX(np.eye(3)), ca.SX(turn))).full().ravel()
    assert written == pytest.approx(error)
