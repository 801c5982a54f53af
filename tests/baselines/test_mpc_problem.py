"""One plan: optimal, within the limits of the true equations, the same in every run, and what HPIPM finds too."""

import casadi as ca
import numpy as np
import pytest
from torquebench.baselines.mpc_horizon import Horizon, tracking_cost
from torquebench.baselines.mpc_problem import JointProblem
from torquebench.baselines.mpc_tool_problem import POSE_WEIGHT, ToolProblem

INTERVAL, BANDWIDTH = 0.02, 20.0
BLOCKS, KNOTS = (1, 1, 1, 1, 2, 2, 4, 8), (1,) * 20


@pytest.fixture
def case(bench):
    """Builds a problem on a swaying arm: its reference, and a start beside it."""

    def build(kind=JointProblem, *, blocks=BLOCKS, arm="seven", share=1.0, offset=0.05):
        plan = bench(arm, sway=0.4).plan
        model, horizon = plan.model, Horizon.of(blocks, INTERVAL)
        reference = plan.preview(INTERVAL * np.arange(horizon.knots + 1))
        motions = zip(reference.q, reference.dq, reference.ddq, strict=True)
        peak = np.abs([model.inverse_dynamics(*motion).copy() for motion in motions]).max(axis=0)
        problem = kind(model, horizon, bandwidth=BANDWIDTH, limit=share * peak)
        start = np.stack([reference.q[0] + offset, reference.dq[0]])
        return problem, start, reference

    return build


def iterated(problem, start, reference, *, steps, disturbance=0.0):
    """Return the plans of several steps from the reference's own accelerations."""
    selection = problem.horizon.selection
    plans = [(selection / selection.sum(axis=0)).T @ np.diff(reference.dq, axis=0) / INTERVAL]
    for _ in range(steps):
        plans.append(problem.solve(start, plans[-1], reference, disturbance * problem.limit))
    return plans


def cost(problem, accelerations, start, reference):
    """Return the joint problem's cost, summed as it is written."""
    horizon = problem.horizon
    drift = start[0] + INTERVAL * np.arange(horizon.knots + 1)[:, None] * start[1]
    q = drift + horizon.position @ accelerations - reference.q
    dq = start[1] + horizon.velocity @ accelerations - reference.dq
    effort = horizon.selection @ accelerations - np.diff(reference.dq, axis=0) / INTERVAL
    states = np.stack([q, dq], axis=1)[1:]
    weights = tracking_cost(horizon, BANDWIDTH).weights
    return 0.5 * np.einsum("ksi,kst,kti->", states, weights, states) + 0.5 * np.sum(effort**2)


def torques(problem):
    """Return the torques at the knots of the last plan, by Pinocchio."""
    knots = zip(problem.q[:-1], problem.dq[:-1], problem.ddq, strict=True)
    return np.array([problem.robot.inverse_dynamics(*knot).copy() for knot in knots])


def test_without_a_limit_the_plan_is_where_the_cost_is_flat(case):
    """The cost is quadratic in the accelerations: one step must land on its minimum."""
    problem, start, reference = case(share=100.0)
    plan = iterated(problem, start, reference, steps=1)[-1]
    best = cost(problem, plan, start, reference)
    for _ in range(20):
        step = 1e-3 * np.random.default_rng(0).standard_normal(plan.shape)
        up, down = cost(problem, plan + step, start, reference), cost(problem, plan - step, start, reference)
        assert up - down == pytest.approx(0.0, abs=1e-9 * best)
        assert min(up, down) > best
    assert problem.program.solves == 0


@pytest.mark.parametrize("kind", [JointProblem, ToolProblem])
@pytest.mark.parametrize("blocks", [BLOCKS, KNOTS])
def test_repeated_steps_meet_the_limits_of_the_true_equations(case, kind, blocks):
    """Rows are linear, torques are not: only where the steps converge do they agree, and there they must."""
    problem, start, reference = case(kind, blocks=blocks, share=0.8, offset=0.01)
    plans = iterated(problem, start, reference, steps=25)
    assert np.abs(plans[-1] - plans[-2]).max() < 1e-3
    excess = np.abs(torques(problem)) - problem.limit
    assert excess.max() < 1e-3
    assert (excess > -1e-3).any()


def test_hpipm_finds_the_same_plan(case):
    """Another solver, the states kept as unknowns, and CasADi in between: the condensing must be right."""
    problem, start, reference = case(blocks=KNOTS, share=0.8, offset=0.01)
    before, after = iterated(problem, start, reference, steps=4)[-2:]
    change = hpipm_plan(problem, start, reference, before) - after
    assert np.abs(change).max() < 1e-6 * np.abs(after).max()


def hpipm_plan(problem, start, reference, before):
    """Return the accelerations of the sparse program: unknowns x_0, u_0, x_1, ..., x_N, linearised about a plan."""
    n, knots = problem.robot.n, problem.horizon.knots
    states, inputs = 2 * n, n
    problem.solve(start, before, reference, np.zeros(n))
    expected = problem.torque.outputs
    q, dq, ddq = (problem.torque.inputs[name] for name in ("q", "dq", "ddq"))
    eye, weights = np.eye(n), tracking_cost(problem.horizon, BANDWIDTH).weights
    chain = np.block([[eye, INTERVAL * eye], [np.zeros((n, n)), eye]])
    drive = np.vstack([0.5 * INTERVAL**2 * eye, INTERVAL * eye])
    size = states + inputs
    total = knots * size + states
    hessian, gradient = np.zeros((total, total)), np.zeros(total)
    rows, least, most = [], [], []
    mean = np.diff(reference.dq, axis=0) / INTERVAL
    for k in range(knots):
        x, u = slice(k * size, k * size + states), slice(k * size + states, (k + 1) * size)
        following = slice((k + 1) * size, (k + 1) * size + states)
        hessian[u, u], gradient[u] = eye, -mean[k]
        block = np.kron(weights[k], eye)
        hessian[following, following] = block
        gradient[following] = -block @ np.concatenate([reference.q[k + 1], reference.dq[k + 1]])
        dynamics = np.zeros((states, total))
        dynamics[:, x], dynamics[:, u], dynamics[:, following] = chain, drive, -np.eye(states)
        slope = expected["derivatives"][k].T
        torque = np.zeros((n, total))
        torque[:, x], torque[:, u] = slope[:, :states], slope[:, states:]
        here = expected["torque"][k] - slope @ np.concatenate([q[k], dq[k], ddq[k]])
        rows += [dynamics, torque]
        least += [np.zeros(states), -problem.limit - here]
        most += [np.zeros(states), problem.limit - here]
    sparse_hessian, sparse_rows = ca.sparsify(ca.DM(hessian)), ca.sparsify(ca.DM(np.vstack(rows)))
    program = {"h": sparse_hessian.sparsity(), "a": sparse_rows.sparsity()}
    options = {"N": knots, "nx": [states] * (knots + 1), "nu": [inputs] * knots + [0], "ng": [n] * knots + [0]}
    solver = ca.conic("sparse", "hpipm", program, {**options, "hpipm": {"iter_max": 100}})
    # With infinite bounds HPIPM finds the same plan and does not notice that it has.
    lower, upper = np.full(total, -1e4), np.full(total, 1e4)
    lower[:states] = upper[:states] = start.ravel()
    found = solver(
        h=sparse_hessian, g=gradient, a=sparse_rows, lba=np.hstack(least), uba=np.hstack(most),
        lbx=lower, ubx=upper,
    )["x"].full().ravel()  # fmt: skip
    return found[: knots * size].reshape(knots, size)[:, states:]


def test_a_disturbance_takes_its_share_of_the_torque(case):
    """Held up by something else, the joint needs less of its drive; pulled down, more."""
    problem, start, reference = case(share=0.9, offset=0.01)
    iterated(problem, start, reference, steps=12, disturbance=-0.1)
    share = np.abs(torques(problem) / problem.limit + 0.1).max(axis=0)
    assert share.max() == pytest.approx(1.0, abs=1e-4)


def test_the_tools_curvature_is_that_of_its_error(case):
    """A plan from the tool's cost alone must bring the tool to its path, whatever the joints do."""
    problem, start, reference = case(ToolProblem, share=100.0, offset=0.02)
    joint, _, _ = case(share=100.0, offset=0.02)
    iterated(problem, start, reference, steps=5)
    iterated(joint, start, reference, steps=1)
    errors = [
        np.linalg.norm(p.robot.forward_kinematics(p.q[10])[:3, 3] - reference.pose[10, :3, 3]) for p in (problem, joint)
    ]
    assert POSE_WEIGHT > 1.0
    assert errors[0] < errors[1]


def test_what_no_torque_can_do_has_no_plan(case):
    """Limits below gravity: no answer, and the next problem is solved as if nothing had been."""
    problem, start, reference = case(share=0.01, offset=0.0)
    still = np.zeros((len(BLOCKS), problem.robot.n))
    assert problem.solve(start, still, reference, np.zeros(problem.robot.n)) is None
    problem.limit = 100.0 * problem.limit
    assert problem.solve(start, still, reference, np.zeros(problem.robot.n)) is not None


def test_a_plan_is_the_same_to_the_bit_wherever_memory_lies(case):
    """The solver's own last digits are not."""
    plans, blocks = [], []
    for size in (1, 1000, 77):
        blocks.append(np.zeros(size))
        problem, start, reference = case(share=0.8, offset=0.01)
        plans.append(iterated(problem, start, reference, steps=5)[-1])
    assert np.array_equal(plans[0], plans[1])
    assert np.array_equal(plans[0], plans[2])
