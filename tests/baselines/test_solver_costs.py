"""Formulas for solvers: they must agree with graphs where a graph can be written, and with the solver's own sizes."""

import casadi as ca
import numpy as np
import pytest
from torquebench.baselines.mpc import Mpc
from torquebench.baselines.mpc_offset_free import MpcOffsetFree
from torquebench.baselines.mpc_tool import MpcTool
from torquebench.baselines.operation_costs import operation_costs
from torquebench.baselines.operation_graph import TickGraph, cholesky, count_graph, forward
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


@pytest.mark.parametrize(("variables", "rows"), [(3, 5), (7, 4), (14, 14)])
def test_the_formula_of_an_iteration_is_its_graph(variables, rows):
    """Two substitutions, Hessian, rows and transposed rows times a vector, written out and counted one by one.

    The formula takes a square for each substitution pair: its diagonal's divisions are counted beside it.
    """
    factor = ca.SX.sym("l", ca.Sparsity.lower(variables))
    hessian, matrix = ca.SX.sym("h", variables, variables), ca.SX.sym("a", rows, variables)
    right, dual = ca.SX.sym("g", variables), ca.SX.sym("z", rows)
    step = backward(ca.densify(factor), forward(ca.densify(factor), right))
    inputs = [factor, hessian, matrix, right, dual]
    found = count_graph(ca.Function("f", inputs, [step, hessian @ right, matrix @ right, matrix.T @ dual])).operations
    formula = program_iteration(variables, rows, is_projection=False)
    assert formula.macs - found.multiplications == variables
    assert found.divisions == 2 * formula.divisions == 2 * variables


@pytest.mark.parametrize("law", [WholeBodyQp, WholeBodyQpStrict, Mpc, MpcTool, MpcOffsetFree])
def test_fewer_joints_cost_less_at_every_event_and_keep_less(bench, law):
    """An arm of six joints must not be charged for seven anywhere: tick, solve, iteration, memory."""
    seven, six = (operation_costs(bench(arm).model, law()) for arm in ("seven", "six"))
    assert set(seven.by_event) == set(six.by_event)
    assert all(seven.by_event[name].arithmetic > six.by_event[name].arithmetic > 0 for name in six.by_event)
    assert seven.parameters > six.parameters and seven.state > six.state


@pytest.mark.parametrize(("law", "number"), [(WholeBodyQp, "posture_stiffness"), (Mpc, "bandwidth")])
def test_settings_that_are_numbers_change_no_count(bench, law, number):
    """A gain is read, whatever it is: tuning must not make a law look cheaper."""
    robot, plain = bench().model, law()
    tuned = law(**{number: 1.1 * getattr(plain, number)})
    assert operation_costs(robot, tuned) == operation_costs(robot, plain)


def test_an_iteration_grows_with_the_square_of_its_variables_and_linearly_with_its_rows():
    """Second differences of the formula: 4 for each pair of variables, 2 for each row and variable."""
    macs = np.array([[program_iteration(v, r, is_projection=False).macs for r in (10, 11, 12)] for v in (5, 6, 7)])
    assert np.diff(macs, n=2, axis=0) == pytest.approx(4.0)
    assert np.diff(macs, n=2, axis=1) == pytest.approx(0.0)
    assert np.diff(macs, axis=1)[:, 0] == pytest.approx([10.0, 12.0, 14.0])
