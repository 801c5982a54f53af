"""The graphs of laws with a solver or neurons must compute what these laws compute, or their counts are of others."""

import re

import casadi as ca
import numpy as np
import pytest
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.mpc import Mpc
from torquebench.baselines.operation_costs import operation_costs, spiking_adaptive_costs
from torquebench.baselines.operation_graph import TickGraph
from torquebench.baselines.qp_tasks import limited_torque
from torquebench.baselines.solver_costs import _inner_law, limit_rows, task_matrices
from torquebench.baselines.spiking_adaptive import SpikingAdaptive
from torquebench.baselines.whole_body_qp import WholeBodyQp


def evaluated(graph, expressions, **known):
    """Return expressions at known numbers by the names of their symbols; what is not named is zero."""
    symbols = [*graph.read, *graph.gains, *graph.given]
    names = [re.sub(r"_\d+$", "", str(symbol[0, 0])) for symbol in symbols]
    assert set(known) <= set(names)
    values = [np.asarray(known.get(name, 0.0), dtype=float) for name in names]
    columns = [value.reshape(-1, 1) if value.ndim < 2 else value for value in values]
    shaped = [np.broadcast_to(column, symbol.shape) for column, symbol in zip(columns, symbols, strict=True)]
    found = ca.Function("law", symbols, expressions).call([ca.DM(np.array(value)) for value in shaped])
    return [np.array(value).squeeze() for value in found]


def swaying(bench, law):
    """Return an arm, a law that was reset on it, an observation off the plan, and the plan's target."""
    arm = bench(sway=0.3, effort=300.0)
    law.reset(arm.task())
    target, rng = arm.plan.target(0.1), np.random.default_rng(3)
    q, dq = target.q + 0.02 * rng.normal(size=arm.model.n), target.dq + 0.1 * rng.normal(size=arm.model.n)
    return arm, arm.observe(0.1, q, dq), target


@pytest.fixture
def written(monkeypatch):
    """Keeps the graph that a function counts."""
    graphs = []
    count = TickGraph.count
    monkeypatch.setattr(TickGraph, "count", lambda graph: graphs.append(graph) or count(graph))
    return graphs


@pytest.fixture
def program(bench):
    """A whole-body program that was solved once, its graph, and what the graph's symbols were."""
    law = WholeBodyQp()
    arm, observation, target = swaying(bench, law)
    torque = law.compute(observation, target).copy()
    graph = TickGraph(robot=arm.model)
    known = {"q": observation.q, "dq": observation.dq, "command": observation.command}
    known |= {"rotor": arm.model.rotor_inertia, "free": law._free.copy()}
    return law, graph, known, torque


def test_hessian_and_gradient_of_the_graph_are_those_of_the_program(program):
    """Posture, pose and effort in scaled unknowns; the kernel divides by the root of the slack's weight besides."""
    law, graph, known, _ = program
    n, even = graph.robot.n, np.sqrt(law.slack_weight)
    free, inertia = graph.reading("free", n), graph.result("inertia", 6, 6)
    expressions = task_matrices(graph, graph.mass_matrix(), graph.tool()[2], inertia, free)
    found = evaluated(graph, expressions, **known, inertia=law._inertia, weights=law._weights)
    assert found[0] == pytest.approx(even * np.tril(law._hessian[:n, :n]), rel=1e-9, abs=1e-9)
    assert found[1] == pytest.approx(even * law._gradient[:n], rel=1e-9)


def test_rows_and_bounds_of_the_graph_are_those_of_the_program(program):
    """Torque hard and acceleration soft, each by its joint's inertia; and the torque of any solution, clipped."""
    law, graph, known, _ = program
    n, robot = graph.robot.n, graph.robot
    expressions = limit_rows(graph, graph.mass_matrix(), graph.reading("free", n))
    solution = np.random.default_rng(1).normal(size=n)
    limits = {"effort": law._effort, "step": np.full(n, 1e9), "period": law.period, "velocity": law._velocity}
    limits |= {"lower": law._lower, "upper": law._upper, "reach": law._reach, "brake": law._brake}
    rows, least, most, lowest, highest, torque = evaluated(graph, expressions, **known, **limits, solution=solution)
    assert rows == pytest.approx(np.tril(law._rows[:n, :n]), rel=1e-12)
    assert np.stack([least, most]) == pytest.approx(law._bounds[:, :n], rel=1e-9)
    assert np.stack([lowest, highest]) == pytest.approx(law._bounds[:, n:], rel=1e-6)
    expected = np.empty(n)
    mass = robot.mass_matrix(known["q"])
    limited_torque(mass, known["free"], solution, law._torque_bounds, expected)
    assert torque == pytest.approx(expected, rel=1e-9)


def test_the_graph_of_the_spiking_law_is_the_law_beside_its_ensemble(bench, written):
    """Two inverse dynamics: torque, training signal, and the place in the ball that the neurons see."""
    law = SpikingAdaptive(neurons=50)
    arm, observation, target = swaying(bench, law)
    torque = law.compute(observation, target).copy()
    spiking_adaptive_costs(arm.model, law)
    (graph,) = written
    plan = {"q_ref": target.q, "dq_ref": target.dq, "ddq_ref": target.ddq, "rotor": arm.model.rotor_inertia}
    known = {"q": observation.q, "dq": observation.dq, "stiffness": law.stiffness, "damping": law.damping, **plan}
    known |= {"adaptive": law.ensemble.output, "centre": law._centre, "scale": law._scale}
    total, error, *point = evaluated(graph, graph.written, **known)
    assert total == pytest.approx(torque, rel=1e-9)
    assert error == pytest.approx(law.ensemble.error, rel=1e-6)
    place = np.concatenate(point)
    # The kernel also draws in what lies beyond the ball; here nothing does.
    assert np.linalg.norm(place) < 1.0 and place == pytest.approx(law.ensemble.stimulus[: len(place)], rel=1e-9)


def test_the_graph_between_two_plans_is_computed_torque_about_the_plan(bench, written):
    """A knot's state, moved on by the time since; then the inner law, with its own gains."""
    inner = ComputedTorque(bandwidth=40.0)
    arm, observation, target = swaying(bench, inner)
    since, n = 0.007, arm.model.n
    plan_dq = target.dq - since * target.ddq
    plan_q = target.q - since * (plan_dq + 0.5 * since * target.ddq)
    _inner_law(arm.model, Mpc(bandwidth=40.0))
    (graph,) = written
    plan = {"plan_q": plan_q, "plan_dq": plan_dq, "plan_ddq": target.ddq, "since": since}
    gains = {"stiffness": inner.stiffness, "damping": inner.damping, "rotor": arm.model.rotor_inertia}
    (torque,) = evaluated(graph, graph.written, q=observation.q, dq=observation.dq, **plan, **gains)
    assert torque.shape == (n,) and torque == pytest.approx(inner.compute(observation, target), rel=1e-9)


@pytest.mark.parametrize("neurons", [100, 400])
def test_an_ensemble_keeps_what_its_arrays_hold(bench, neurons):
    """Encoders, biases and decoders; potential, rest and filtered rate of every neuron."""
    law = SpikingAdaptive(neurons=neurons)
    arm, *_ = swaying(bench, law)
    costs, none = operation_costs(arm.model, law), spiking_adaptive_costs(arm.model, SpikingAdaptive(neurons=1))
    ensemble = law.ensemble
    weights = ensemble.encoders.size + ensemble.encoders.shape[1] + ensemble.decoders.size
    single = 2 * arm.model.n + 1 + arm.model.n
    assert costs.parameters - none.parameters == weights - single == (neurons - 1) * single
    assert costs.state - none.state == 3 * (neurons - 1)
