"""One step of model predictive control here and by crocoddyl with mim-solvers, on the same problem in the same run.

The problem: the Rizon 4s with 2 kg in its gripper on T6, 20 knots of 20 ms, joint accelerations as input, the joints'
tracking cost, every joint's torque at every knot within its limits. Two limits: the arm's own, which never bind, and
95 % of what the motion needs at its peak; of these only the steps in which they bind are counted. For the
comparison our horizon takes crocoddyl's Euler step; the lines below it use the product's exact one. Each step starts
from the plan before, shifted, and from the motion's own state, so that both solve the same program.

    python benchmarks/mpc_peer.py
"""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np
import pinocchio as pin
from torquebench.baselines.mpc_horizon import Horizon, tracking_cost
from torquebench.baselines.mpc_kernels import shift
from torquebench.baselines.mpc_problem import JointProblem, PlanProblem
from torquebench.baselines.mpc_tool_problem import ToolProblem
from torquebench.controllers import Reference, RobotModel
from torquebench.scenarios.robots import load_robot
from torquebench.scenarios.world import cached_plan

KNOTS, INTERVAL, BANDWIDTH, PERIOD, STEPS, REPEATS = 20, 0.02, 40.0, 0.005, 400, 5
SINGLE, BLOCKS = (1,) * KNOTS, (1, 1, 1, 1, 2, 2, 4, 8)
LOAD = pin.Inertia(2.3, np.array([0.0, 0.0, 0.2]), 0.01 * np.eye(3))
TIGHT = 0.95
"""Share of the motion's own peak torque."""

PRODUCTS = (
    ("joints, 140 unknowns", SINGLE, JointProblem),
    ("joints, 56 unknowns", BLOCKS, JointProblem),
    ("tool, 56 unknowns", BLOCKS, ToolProblem),
)

INSTALL = "crocoddyl or mim-solvers is missing: pip install crocoddyl mim-solvers"
CAPS = {"max_qp_iters": 200, "eps_abs": 1e-4, "eps_rel": 0.0}
"""Of the peer's inner solver: the tolerance that its plan needs to agree with ours."""

Step = Callable[[np.ndarray, float], np.ndarray]
"""From a state, shape (2, n), and its time to the accelerations of the plan, shape (N, n)."""


@dataclass(frozen=True)
class Case:
    """What both solve.

    Attributes:
        robot: The arm with its load.
        plan: The motion.
        limit: Largest torque, shape (n,) [N m].
    """

    robot: RobotModel
    plan: Reference
    limit: np.ndarray


def cases() -> dict[str, Case]:
    """Return the problem with limits that never bind and with limits that do."""
    arm = load_robot("rizon4s")
    robot, plan = arm.model(rotor_inertia=arm.rotor_inertia / 3.0), cached_plan(arm, "T6", 1.0)
    robot.set_payload(LOAD.toDynamicParameters())
    motions = zip(plan.q, plan.dq, plan.ddq, strict=True)
    peak = np.max([np.abs(robot.inverse_dynamics(*motion)) for motion in motions], axis=0)
    tight = np.where(peak > 0.5 * robot.effort, TIGHT * peak, robot.effort)
    return {"free": Case(robot, plan, robot.effort), "tight": Case(robot, plan, tight)}


def euler_horizon() -> Horizon:
    """Return the horizon of crocoddyl's Euler step: positions move with the new velocity."""
    horizon = Horizon.of(SINGLE, INTERVAL)
    return replace(horizon, position=horizon.position + 0.5 * INTERVAL * horizon.velocity)


def own_step(case: Case, horizon: Horizon, kind: type[PlanProblem]) -> tuple[Step, PlanProblem]:
    """Return a step of this library, and the problem behind it."""
    problem = kind(case.robot, horizon, bandwidth=BANDWIDTH, limit=case.limit)
    accelerations = np.zeros((horizon.selection.shape[1], case.robot.n))
    nothing, knots = np.zeros(case.robot.n), INTERVAL * np.arange(KNOTS + 1)

    def step(state: np.ndarray, now: float) -> np.ndarray:
        shift(problem.ddq, PERIOD / INTERVAL, horizon.selection, accelerations)
        # Where no plan is found the roll-out of the one before stands, as the controller would run it.
        problem.solve(state, accelerations, case.plan.preview(now + knots), nothing)
        return problem.ddq

    return step, problem


def peer_step(case: Case) -> Step:
    """Return a step of crocoddyl's inverse-dynamics model under mim-solvers' constrained SQP."""
    crocoddyl, mim = import_module("crocoddyl"), import_module("mim_solvers")
    n, cost = case.robot.n, tracking_cost(euler_horizon(), BANDWIDTH)
    state = crocoddyl.StateMultibody(case.robot.model)
    drives = crocoddyl.ActuationModelFull(state)
    nodes = [_node(crocoddyl, state, drives, case.limit, cost.weights[0]) for _ in range(KNOTS)]
    end = _end(crocoddyl, state, drives, cost.weights[-1])
    problem = crocoddyl.ShootingProblem(np.zeros(2 * n), nodes, end)
    solver = mim.SolverCSQP(problem)
    for name, value in CAPS.items():
        setattr(solver, name, value)
    xs, us = [np.zeros(2 * n)] * (KNOTS + 1), [np.zeros(n)] * KNOTS
    knots = INTERVAL * np.arange(KNOTS + 1)
    selection = np.eye(KNOTS)

    def step(start: np.ndarray, now: float) -> np.ndarray:
        reference = case.plan.preview(now + knots)
        accelerations = np.diff(reference.dq, axis=0) / INTERVAL
        for k in range(KNOTS + 1):
            costs = (nodes[k].differential if k < KNOTS else end.differential).costs.costs
            costs["state"].cost.residual.reference = np.concatenate([reference.q[k], reference.dq[k]])
            if k < KNOTS:
                costs["input"].cost.residual.reference = accelerations[k]
        shifted = np.zeros((KNOTS, n))
        shift(np.array(us), PERIOD / INTERVAL, selection, shifted)
        problem.x0 = start.ravel()
        inputs = list(shifted)
        solver.solve(problem.rollout(inputs), inputs, 1, True)
        xs[:], us[:] = solver.xs, solver.us
        return np.array(us)

    return step


def _node(crocoddyl: Any, state: Any, drives: Any, limit: np.ndarray, weights: np.ndarray) -> Any:
    """Return a knot: state and input costs, torque within limits. Its cost is multiplied by the interval there."""
    n = state.nv
    costs = crocoddyl.CostModelSum(state, n)
    diagonal = np.repeat(np.diag(weights), n) / INTERVAL
    tracking = crocoddyl.CostModelResidual(
        state, crocoddyl.ActivationModelWeightedQuad(diagonal), crocoddyl.ResidualModelState(state, np.zeros(2 * n), n)
    )
    costs.addCost("state", tracking, 1.0)
    effort = crocoddyl.CostModelResidual(state, crocoddyl.ResidualModelControl(state, np.zeros(n)))
    costs.addCost("input", effort, 1.0 / INTERVAL)
    limits = crocoddyl.ConstraintModelManager(state, n)
    torque = crocoddyl.ResidualModelJointEffort(state, drives, np.zeros(n), n)
    limits.addConstraint("torque", crocoddyl.ConstraintModelResidual(state, torque, -limit, limit, False))
    model = crocoddyl.DifferentialActionModelFreeInvDynamics(state, drives, costs, limits)
    return crocoddyl.IntegratedActionModelEuler(model, INTERVAL)


def _end(crocoddyl: Any, state: Any, drives: Any, weights: np.ndarray) -> Any:
    """Return the last knot; its cost couples position and velocity, for which crocoddyl has no class."""
    n, full = state.nv, np.kron(weights, np.eye(state.nv))

    class Coupled(crocoddyl.ActivationModelAbstract):  # type: ignore[misc, name-defined]
        def calc(self, data: Any, residual: np.ndarray) -> None:
            data.a_value = 0.5 * residual @ full @ residual

        def calcDiff(self, data: Any, residual: np.ndarray) -> None:
            data.Ar, data.Arr = full @ residual, full

    costs = crocoddyl.CostModelSum(state, n)
    residual = crocoddyl.ResidualModelState(state, np.zeros(2 * n), n)
    costs.addCost("state", crocoddyl.CostModelResidual(state, Coupled(2 * n), residual), 1.0)
    model = crocoddyl.DifferentialActionModelFreeInvDynamics(state, drives, costs)
    return crocoddyl.IntegratedActionModelEuler(model, 0.0)


def follow(step: Step, case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Return the time of every step [us], and the plans, shape (steps, N, n)."""
    times, plans = np.empty(STEPS), np.empty((STEPS, KNOTS, case.robot.n))
    for k in range(STEPS):
        now = case.plan.preview(np.array([k * PERIOD]))
        state = np.stack([now.q[0], now.dq[0]])
        begun = time.perf_counter()
        found = step(state, k * PERIOD)
        times[k] = (time.perf_counter() - begun) * 1e6
        plans[k] = found
    return times, plans


def binding(case: Case) -> np.ndarray:
    """Return at which steps a limit binds, all of them if none does, shape (steps,)."""
    step, problem = own_step(case, euler_horizon(), JointProblem)
    asked = [0]

    def watched(state: np.ndarray, now: float) -> np.ndarray:
        plan = step(state, now)
        asked.append(problem.program.solves)
        return plan

    follow(watched, case)
    binds = np.diff(asked) > 0
    return binds if binds.any() else ~binds


def row(title: str, times: list[np.ndarray], counted: np.ndarray) -> float:
    """Print median and 99th percentile of the steps that count, each at its least time, and return the median [us]."""
    # A step's work is the same in each repeat: what one takes longer is what else the machine does.
    best = np.min(times, axis=0)[counted]
    print(f"{title:44s} {np.median(best):10.0f} {np.quantile(best, 0.99):10.0f}")
    return float(np.median(best))


def main() -> int:
    """Print the tables; 0, or 2 where the peer is not installed."""
    try:
        for name in ("crocoddyl", "mim_solvers"):
            import_module(name)
    except ImportError:
        print(INSTALL)
        return 2
    for name, case in cases().items():
        counted = binding(case)
        title = f"limits: {name}, {np.count_nonzero(counted)} of {STEPS} steps"
        print(f"{title:44s} {'median us':>10s} {'p99 us':>10s}")
        ours = [follow(own_step(case, euler_horizon(), JointProblem)[0], case) for _ in range(REPEATS)]
        theirs = [follow(peer_step(case), case) for _ in range(REPEATS)]
        own = row("torquebench, Euler step", [times for times, _ in ours], counted)
        peer = row("crocoddyl, mim-solvers CSQP, Euler step", [times for times, _ in theirs], counted)
        apart = np.abs(ours[0][1][counted, 0] - theirs[0][1][counted, 0]).max()
        print(f"{'':4s}{peer / own:.1f} times; first accelerations differ by {apart:.2g} rad/s^2 at most")
        for title, blocks, kind in PRODUCTS:
            steps = [own_step(case, Horizon.of(blocks, INTERVAL), kind)[0] for _ in range(REPEATS)]
            row(f"torquebench, {title}", [follow(step, case)[0] for step in steps], counted)
    return 0


if __name__ == "__main__":
    sys.exit(main())
