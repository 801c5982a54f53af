"""Velocity tracking: how far joints and tool are from the speed that the plan asks for."""

import math

import numpy as np

from .geometry import distances, root_mean_square
from .registry import UNDEFINED, metric

RESTING_SPEED = 1e-6
"""Root mean square speed below which a plan rests and nothing can be divided by it [rad/s]."""


@metric(
    unit="rad/s",
    better="lower",
    family="velocity",
    needs=("dq", "dq_ref"),
    source="mean norm of dq_ref - dq",
    label="mean joint velocity error",
)
def joint_velocity_error_mean(dq: np.ndarray, dq_ref: np.ndarray) -> float:
    """Mean norm of the joint velocity error.

    Args:
        dq: Joint velocities, shape (N, n) [rad/s].
        dq_ref: Planned joint velocities of the same ticks, shape (N, n) [rad/s].

    Returns:
        The mean norm [rad/s]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(distances(dq, dq_ref).mean())


@metric(
    unit="rad/s",
    better="lower",
    family="velocity",
    needs=("dq", "dq_ref"),
    source="root mean square of the norm of dq_ref - dq",
    label="RMS joint velocity error",
)
def joint_velocity_error_rms(dq: np.ndarray, dq_ref: np.ndarray) -> float:
    """Root mean square of the joint velocity error's norm.

    Args:
        dq: Joint velocities, shape (N, n) [rad/s].
        dq_ref: Planned joint velocities of the same ticks, shape (N, n) [rad/s].

    Returns:
        The root mean square [rad/s]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return root_mean_square(distances(dq, dq_ref))


@metric(
    unit="1",
    better="lower",
    family="velocity",
    needs=("dq", "dq_ref"),
    source="RMS of |dq_ref - dq| / RMS of |dq_ref|",
    label="joint velocity error by planned velocity",
)
def velocity_error_ratio(dq: np.ndarray, dq_ref: np.ndarray) -> float:
    """Velocity error as a share of the planned velocity: comparable between slow and fast motions.

    Args:
        dq: Joint velocities, shape (N, n) [rad/s].
        dq_ref: Planned joint velocities of the same ticks, shape (N, n) [rad/s].

    Returns:
        The share [1]; NaN if any sample is not finite or the plan rests.

    Raises:
        EmptyWindow: If there is no sample.
    """
    planned = math.sqrt(np.einsum("kn,kn->", dq_ref, dq_ref) / len(dq_ref))
    return UNDEFINED if planned < RESTING_SPEED else root_mean_square(distances(dq, dq_ref)) / planned


@metric(
    unit="m/s",
    better="lower",
    family="velocity",
    needs=("twist", "twist_ref"),
    source="mean of | |v_ref| - |v| |",
    label="mean error of the tool's speed",
)
def tcp_speed_error_mean(twist: np.ndarray, twist_ref: np.ndarray) -> float:
    """Mean difference between the speeds of tool and plan, whatever their directions.

    Args:
        twist: Tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Reference twists of the same ticks, shape (N, 6) [m/s, rad/s].

    Returns:
        The mean magnitude [m/s]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    speed, planned = (np.linalg.norm(t[:, :3], axis=1) for t in (twist, twist_ref))
    return float(np.abs(planned - speed).mean())


@metric(
    unit="m/s",
    better="lower",
    family="velocity",
    needs=("twist", "twist_ref"),
    source="mean norm of v_ref - v",
    label="mean error of the tool's velocity",
)
def tcp_velocity_error_mean(twist: np.ndarray, twist_ref: np.ndarray) -> float:
    """Mean norm of the tool's velocity error; a wrong direction counts, too.

    Args:
        twist: Tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Reference twists of the same ticks, shape (N, 6) [m/s, rad/s].

    Returns:
        The mean norm [m/s]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.linalg.norm(twist_ref[:, :3] - twist[:, :3], axis=1).mean())


@metric(
    unit="rad/s",
    better="lower",
    family="velocity",
    needs=("twist", "twist_ref"),
    source="mean norm of omega_ref - omega",
    label="mean error of the tool's angular velocity",
)
def tcp_angular_velocity_error_mean(twist: np.ndarray, twist_ref: np.ndarray) -> float:
    """Mean norm of the tool's angular velocity error.

    Args:
        twist: Tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Reference twists of the same ticks, shape (N, 6) [m/s, rad/s].

    Returns:
        The mean norm [rad/s]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.linalg.norm(twist_ref[:, 3:] - twist[:, 3:], axis=1).mean())
