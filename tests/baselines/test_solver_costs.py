"""Formulas for solvers: they must agree with graphs where a graph can be written, and with the solver's own sizes."""

import casadi as ca
import numpy as np
import pytest
from torquebench.baselines.mpc import Mpc
from torquebench.baselines.mpc_offset_free import MpcOffsetFree
from torquebench.baselines.mpc_tool import MpcTool
from torquebench.baselines.operation_costs import operation_costs
from torquebench.baselines.operation_graph import TickGraph, cholesky, count_graph
from torquebench.baselines.solver_costs import backward, factorisation, limit_rows, program_iteration
from torquebench.baselines.spiking_adaptive import SpikingAdaptive
from torquebench.baselines.viability import viable_accelerations
from torquebench.baselines.whole_body_qp import WholeBodyQp
from torquebench.baselines.whole_body_qp_strict import WholeBodyQpStrict


@pytest.mark.parametrize("n", [2, 5, 14])
def test_the_formula_of_a_factor_is_its_graph(n):
    """(n^3 - n) / 6 products; a root or a division for each entry of the triangle."""
    matrix = ca.SX.sym("m", n, n)
    found = count_graph(ca.Function("f", [matrix], [ca.cse(cholesky(matrix))])).operations
    formula = factorisation(n)
    squares_and_products = found.multiplications
    assert squares_and_products == formula.macs == found.additions
    assert found.divisions == formula.divisions


def test_an_identity_as_hessian_saves_its_products():
    dense, projection = (program_iteration(56, 140, is_projection=flag) for flag in (False, True))
    assert dense.macs - projection.macs == 2 * 56**2 - 56
    assert projection.macs == 2 * 56 * 140 + 56


@pytest.mark.parametrize(
    ("lighter", "heavier"), [(Mpc, MpcTool), (Mpc, MpcOffsetFree), (WholeBodyQp, WholeBodyQpStrict)]
)
def test_what_a_version_adds_costs(bench, lighter, heavier):
    """A tool's cost, an observer, a second program: none is free, and a longer horizon is not either."""
    robot = bench().model
    few, many = (operation_costs(robot, law()).by_event for law in (lighter, heavier))
    assert set(few) == set(many)
    assert all(many[event].arithmetic >= few[event].arithmetic for event in few)
    assert any(many[event].arithmetic > few[event].arithmetic for event in few)


def test_a_plan_of_half_the_knots_costs_less_than_half_its_iterations(bench):
    """An iteration is products with the torque rows: knots times blocks."""
    robot = bench().model
    whole, half = (operation_costs(robot, Mpc(blocks=blocks)).by_event for blocks in ([1] * 8, [1] * 4))
    assert whole["qp_iterations"].macs > 3.5 * half["qp_iterations"].macs
    assert whole["mpc_solves"].arithmetic > 2.0 * half["mpc_solves"].arithmetic
    assert whole["ticks"] == half["ticks"]


@pytest.mark.parametrize("law", [WholeBodyQp, WholeBodyQpStrict, Mpc, MpcOffsetFree, SpikingAdaptive])
def test_every_priced_event_is_a_counter_of_its_law(bench, law):
    """A counter that is spelled otherwise would count nothing, and the law would look cheap."""
    arm, built = bench(sway=0.1), law()
    built.reset(arm.task())
    events = set(operation_costs(arm.model, built).by_event) - {"ticks"}
    assert events and events <= set(built.operations())


def test_a_law_from_elsewhere_is_not_taken_for_its_base(bench):
    """Whoever inherits may compute anything."""

    class Mine(WholeBodyQp):
        pass

    assert operation_costs(bench().model, Mine()) is None
    assert operation_costs(bench().model, object()) is None


def test_back_substitution_written_out_solves():
    factor, right = np.array([[2.0, 0.0], [1.0, 3.0]]), np.array([1.0, 2.0])
    solved = np.array(ca.DM(backward(ca.SX(factor), ca.SX(right)))).ravel()
    assert factor.T @ solved == pytest.approx(right)


def test_the_bounds_in_the_graph_are_the_kernels(bench):
    """The largest acceleration of a joint that approaches its limit, from the same numbers."""
    model = bench("planar").model
    graph = TickGraph(robot=model)
    free = graph.reading("free", 3)
    rows = limit_rows(graph, ca.SX.eye(3), free)
    names = {str(s[0]).removesuffix("_0"): s for s in (*graph.read, *graph.gains)}
    q, dq, reach, brake = np.array([2.8, 0.0, -2.9]), np.array([0.5, 1.0, -0.4]), np.full(3, 80.0), np.full(3, 30.0)
    known = {"q": q, "dq": dq, "lower": model.lower, "upper": model.upper, "velocity": model.velocity, "reach": reach,
             "brake": brake, "period": 1e-3}  # fmt: skip
    least, most = np.zeros(3), np.zeros(3)
    viable_accelerations(q, dq, model.lower, model.upper, model.velocity, reach, brake, 1e-3, least, most)
    inputs = list(names.values())
    values = [ca.DM(known.get(name, np.zeros(symbol.shape))) for name, symbol in names.items()]
    lowest, highest = ca.Function("f", inputs, [rows[3], rows[4]])(*values)
    offset = operation_free(graph, inputs, values)
    assert np.array(lowest).ravel() + offset == pytest.approx(least)
    assert np.array(highest).ravel() + offset == pytest.approx(most)


def operation_free(graph, inputs, values):
    """Return the free acceleration with unit inertia and no free torque: minus the bias."""
    return np.array(ca.Function("b", inputs, [-graph.bias()])(*values)).ravel()
