"""Tare: what the force sensor reads too much, weighed off with the gripper alone before a run, as on a real arm."""

import numpy as np

from ..controllers import RobotModel
from .tick import begin_tick, frame_dtype, memory_dtype, start_memory, target_dtype

TARE_TICKS = 500
"""Readings that a tare averages: half a second at rest."""


def tare_offset(
    q: np.ndarray, wrench: np.ndarray, *, known: np.ndarray, constants: np.ndarray, noise: np.ndarray
) -> np.ndarray:
    """Return the mean of the readings at rest less what the known gripper gives there.

    What is left of the bias afterwards is the mean of the noise: with 0.1 N at 1 kHz about 0.005 N.

    Args:
        q: Posture at rest, shape (n,) [rad].
        wrench: True wrench there with the gripper alone, shape (6,) [N, N m].
        known: What the model says of it, shape (6,) [N, N m].
        constants: The run's constants, with the sensor's bias and filter.
        noise: Noise of the readings that are averaged, shape (ticks, 6) [N, N m].

    Returns:
        What to take from all later readings, shape (6,) [N, N m].
    """
    n, ticks = q.shape[0], noise.shape[0]
    frame, memory = np.zeros(1, frame_dtype(n)), np.zeros(1, memory_dtype(n, delay=0))
    target, plan = np.zeros(1, target_dtype(n)), np.zeros(ticks, target_dtype(n))
    at_rest = (q, np.zeros(n), q, np.zeros(n), wrench)
    start_memory(memory, constants, q, wrench, np.zeros(n))
    readings = np.empty((ticks, 6))
    for k in range(ticks):
        begin_tick(frame, target, plan, memory, constants, at_rest, noise, k)
        readings[k] = frame["wrench_measured"][0]
    return np.asarray(readings.mean(axis=0) - known)


def gripper_wrench(model: RobotModel, q: np.ndarray) -> np.ndarray:
    """Return what the known gripper at rest exerts on the arm, flange axes at its origin, shape (6,) [N, N m]."""
    mass, *first_moments = model.tool_parameters[:4]
    gravity = model.flange_pose(q)[:3, :3].T @ model.model.gravity.linear
    return np.concatenate([mass * gravity, np.cross(first_moments, gravity)])
