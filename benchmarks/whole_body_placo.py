"""placo's side of whole_body_peer.py: it needs an older Pinocchio, so it runs in an environment of its own.

Called by whole_body_peer.py with a folder: reads arm.urdf and states.npz there, and writes placo.npz.
"""

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

BASE = 6
"""Velocities of placo's floating base, which is masked."""


def build(folder: Path, states: Any) -> tuple[Any, Any, Any, Any]:
    """Return robot, solver, and the tasks of tool and posture."""
    import placo

    robot = placo.RobotWrapper(str(folder / "arm.urdf"), placo.Flags.ignore_collisions)
    joints = list(robot.joint_names())
    for name, inertia in zip(joints, states["rotor_inertia"], strict=True):
        robot.set_rotor_inertia(name, float(inertia))
        robot.set_gear_ratio(name, 1.0)
    solver = placo.DynamicsSolver(robot)
    solver.mask_fbase(True)
    solver.enable_torque_limits(True)
    solver.torque_cost = 0.0
    pose = solver.add_frame_task(str(states["tool_frame"]), states["pose"][0])
    pose.configure("pose", "soft", float(states["pose_weight"]), float(states["pose_weight"]))
    posture = solver.add_joints_task()
    posture.configure("posture", "soft", 1.0)
    for task, gains in (
        (pose.position(), states["pose_gains"]),
        (pose.orientation(), states["pose_gains"]),
        (posture, states["posture_gains"]),
    ):
        task.kp, task.kd = (float(gain) for gain in gains)
    return robot, solver, pose, posture


def rounds(folder: Path, states: Any) -> dict[str, np.ndarray]:
    """Return the tick times of every round, of placo's whole solve in it, and the tool accelerations asked for."""
    robot, solver, pose, posture = build(folder, states)
    position, orientation, joints = pose.position(), pose.orientation(), list(robot.joint_names())
    ticks, repeats = len(states["q"]), int(states["repeats"])
    full_q = np.concatenate([np.tile(robot.state.q[: BASE + 1], (ticks, 1)), states["q"]], axis=1)
    full_dq = np.concatenate([np.zeros((ticks, BASE)), states["dq"]], axis=1)
    plan = [[states[f"{name}_ref"][k].tolist() for name in ("q", "dq", "ddq")] for k in range(ticks)]
    times = np.empty((2, repeats, ticks))
    accelerations = np.empty((ticks, 6))
    for turn in range(repeats):
        for k in range(ticks):
            twist, acceleration, place = states["twist"][k], states["acceleration"][k], states["pose"][k]
            begun = time.perf_counter_ns()
            robot.state.q, robot.state.qd = full_q[k], full_dq[k]
            robot.update_kinematics()
            position.target_world, orientation.R_world_frame = place[:3, 3], place[:3, :3]
            position.dtarget_world, orientation.omega_world = twist[:3], twist[3:]
            position.ddtarget_world, orientation.domega_world = acceleration[:3], acceleration[3:]
            for name, q, dq, ddq in zip(joints, *plan[k], strict=True):
                posture.set_joint(name, q, dq, ddq)
            solving = time.perf_counter_ns()
            result = solver.solve()
            done = time.perf_counter_ns()
            times[:, turn, k] = done - begun, done - solving
            if not result.success:
                raise RuntimeError(f"placo did not solve tick {k}")
            accelerations[k] = states["jacobian"][k] @ np.array(result.qdd)[BASE:]
    return {"tick": times[0], "solve": times[1], "acceleration": accelerations}


if __name__ == "__main__":
    here = Path(sys.argv[1])
    arrays = dict(np.load(here / "states.npz"))
    np.savez(here / "placo.npz", **rounds(here, arrays))
