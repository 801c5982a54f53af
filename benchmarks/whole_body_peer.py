"""The whole-body quadratic program beside placo's: same arm, same tasks, same measured states, in one run.

Both get a pose task (weight 1e4, double pole at 20 rad/s), a posture task (weight 1) and the arm's torque limits. Ours
holds torque rates and joint limits by viability besides, and spends effort; placo has a masked floating base. Ours is
ProxQP between NumPy and numba, placo is C++ with eiquadprog. placo 0.10 needs Pinocchio 3.8 and this library 4, so it
runs in an environment of its own, round by round on the same core:

    python3 -m venv /tmp/placo && /tmp/placo/bin/pip install placo
    OMP_NUM_THREADS=1 python benchmarks/whole_body_peer.py /tmp/placo/bin/python

Without an argument only our side is measured. (TSID's wheel, 1.10 with Pinocchio 4.0 or 4.1, ends in its constructor.)
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from torquebench.baselines.whole_body_presets import whole_body_qp
from torquebench.baselines.whole_body_qp import WholeBodyQp
from torquebench.controllers import Observation, RobotModel, Target
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.robots import load_robot
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World

TRAJECTORY, TICKS, REPEATS = "T6", 2000, 5
LOAD = LoadSchedule.constant(Payload(mass=1.5))
POSITION_NOISE, VELOCITY_NOISE = 1e-3, 1e-2
"""How far measured states lie off the plan [rad, rad/s]."""

TICK_BAR, SOLVE_BAR, SOLVE_BAR_P99 = 60.0, 15.0, 40.0
"""What our tick, its solve, and the 99th percentile of the solve should keep to [us]."""

PLAN = ("q", "dq", "ddq", "pose", "twist", "acceleration")
State = tuple[Observation, Target]


@dataclass(frozen=True, kw_only=True)
class Times:
    """What one side took.

    Attributes:
        tick: Every whole tick, targets in and torque out, shape (REPEATS, TICKS) [ns].
        solve: The solver's part of it, likewise.
        acceleration: Tool accelerations that were asked for, shape (TICKS, 6) [m/s^2, rad/s^2].
    """

    tick: np.ndarray
    solve: np.ndarray
    acceleration: np.ndarray

    def best(self) -> tuple[float, float, float]:
        """Return tick median, solve median and solve 99th percentile, each the best of the rounds [us]."""
        figures = np.median(self.tick, axis=1), np.median(self.solve, axis=1), np.quantile(self.solve, 0.99, axis=1)
        tick, solve, solve_p99 = (1e-3 * float(figure.min()) for figure in figures)
        return tick, solve, solve_p99


def build_world() -> World:
    """Return the arm, its tier and its motion."""
    specification = RunSpecification(
        controller="whole_body_qp",
        trajectory=TRAJECTORY,
        schedule=LOAD,
        robot="rizon4s",
        plant="pinocchio",
        tier="actuated",
    )
    return World(specification, LOAD)


def measured_states(world: World) -> list[State]:
    """Return consecutive ticks of a motion, measured a little off the plan, with the torque before each."""
    rng, model = np.random.default_rng(0), world.task().robot
    states = []
    for row in world.plan.rows(np.arange(TICKS) * 1e-3):
        q = row["q"] + POSITION_NOISE * rng.standard_normal(model.n)
        dq = row["dq"] + VELOCITY_NOISE * rng.standard_normal(model.n)
        torque = model.inverse_dynamics(row["q"], row["dq"], row["ddq"]).copy()
        target = Target(**{name: np.array(row[name]) for name in PLAN}, reference=world.plan)
        states.append((Observation(time=0.0, q=q, dq=dq, wrench=np.zeros(6), command=torque, torque=torque), target))
    return states


def own_times(law: WholeBodyQp, model: RobotModel, states: Sequence[State]) -> Times:
    """Measure a law that is reset."""
    ticks, solves = np.empty((REPEATS, TICKS)), np.empty((REPEATS, TICKS))
    accelerations, solve, spent = np.empty((TICKS, 6)), law._program.solve, [0]

    def timed(*arrays: np.ndarray) -> np.ndarray | None:
        begun = time.perf_counter_ns()
        found = solve(*arrays)
        spent[0] = time.perf_counter_ns() - begun
        return found

    law._program.solve = timed  # type: ignore[method-assign]
    for turn in range(REPEATS):
        for k, (observation, target) in enumerate(states):
            begun = time.perf_counter_ns()
            torque = law.compute(observation, target)
            ticks[turn, k] = time.perf_counter_ns() - begun
            solves[turn, k] = spent[0]
            state = model.at(observation.q, observation.dq)
            accelerations[k] = state.jacobian @ np.linalg.solve(state.mass_matrix, torque - state.bias)
    return Times(tick=ticks, solve=solves, acceleration=accelerations)


def peer_times(python: str, law: WholeBodyQp, model: RobotModel, states: Sequence[State]) -> Times:
    """Measure placo on the same states, by another interpreter."""
    arrays = {name: np.array([getattr(target, name) for _, target in states]) for name in PLAN[3:]}
    arrays |= {f"{name}_ref": np.array([getattr(target, name) for _, target in states]) for name in PLAN[:3]}
    arrays |= {name: np.array([getattr(observation, name) for observation, _ in states]) for name in ("q", "dq")}
    arrays["jacobian"] = np.array([model.jacobian(observation.q).copy() for observation, _ in states])
    arrays["rotor_inertia"], arrays["repeats"] = model.rotor_inertia, np.array(REPEATS)
    arrays["tool_frame"] = np.array(model.model.frames[model.tool_id].name)
    arrays["pose_weight"], arrays["pose_gains"] = np.array(law.pose_weight), law._gains
    arrays["posture_gains"] = np.array([law.posture_stiffness, law.posture_damping])
    script = Path(__file__).with_name("whole_body_placo.py")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "arm.urdf").write_text(load_robot("rizon4s").urdf, encoding="utf-8")
        np.savez(folder / "states.npz", **arrays)
        subprocess.run([python, str(script), name], check=True)
        return Times(**np.load(folder / "placo.npz"))


def main(python: str | None) -> int:
    """Print a row for each side, their ratio, their agreement and our bars; 1 if a bar is missed."""
    world = build_world()
    states, task, law = measured_states(world), world.task(), whole_body_qp()
    law.reset(task)
    own = own_times(law, task.robot, states)
    tick, solve, solve_p99 = own.best()
    print(f"{TRAJECTORY}, {TICKS} states, best of {REPEATS} rounds [us]")
    print(f"{'':14s} {'tick median':>12s} {'solve median':>13s} {'solve p99':>10s}")
    print(f"{'whole_body_qp':14s} {tick:12.1f} {solve:13.1f} {solve_p99:10.1f}")
    if python is not None:
        peer = peer_times(python, law, task.robot, states)
        peer_tick, peer_solve, peer_p99 = peer.best()
        apart = np.abs(own.acceleration - peer.acceleration).max() / np.abs(own.acceleration).max()
        print(f"{'placo':14s} {peer_tick:12.1f} {peer_solve:13.1f} {peer_p99:10.1f}")
        print(f"placo's solve builds its matrices too; our tick takes {tick / peer_tick:.1f} times its tick")
        print(f"tool accelerations differ by {apart:.1e} of the largest at most")
    met = tick <= TICK_BAR and solve <= SOLVE_BAR and solve_p99 <= SOLVE_BAR_P99
    print(f"bars: tick {TICK_BAR:g}, solve {SOLVE_BAR:g}, its p99 {SOLVE_BAR_P99:g}: {'met' if met else 'MISSED'}")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else None))
