"""Precision of joints and tool point: how far they are from the plan at the same instant."""

import math

import numpy as np

from .geometry import distances, root_mean_square
from .laps import last_lap, last_rows
from .registry import UNDEFINED, metric

FAILED_JOINTS, FAILED_POSITION = 3.0, 0.5
"""What a failed run counts as: errors that no run comes near which still tracks [rad, m]."""

FINAL = 0.2
"""The end of a motion, over which its final error is averaged [s]."""


def joint_error_norm_series(q: np.ndarray, q_ref: np.ndarray) -> np.ndarray:
    """Norm of the joint error at each tick; the paper's RMSE(t).

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions, shape (N, n) [rad].

    Returns:
        Shape (N,) [rad].
    """
    return distances(q, q_ref)


def joint_error_rms_by_joint(q: np.ndarray, q_ref: np.ndarray) -> np.ndarray:
    """Root mean square error of each joint.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions, shape (N, n) [rad].

    Returns:
        Shape (n,) [rad].
    """
    return np.asarray(np.sqrt(np.mean((q_ref - q) ** 2, axis=0)))


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("q", "q_ref"),
    source="paper, RMSE",
    label="mean joint error (the paper's RMSE)",
    fail_value=FAILED_JOINTS,
)
def joint_error_mean(q: np.ndarray, q_ref: np.ndarray) -> float:
    """Mean norm of the joint error.

    The paper calls this RMSE; it is a mean of norms. For the root mean square see :func:`joint_error_rms`.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions of the same ticks, shape (N, n) [rad].

    Returns:
        The mean norm [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(distances(q, q_ref).mean())


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("q", "q_ref"),
    source="root mean square of the error norm",
    label="RMS joint error",
    fail_value=FAILED_JOINTS,
)
def joint_error_rms(q: np.ndarray, q_ref: np.ndarray) -> float:
    """Root mean square of the joint error's norm; its ratio to the mean tells bursts from a constant error.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions of the same ticks, shape (N, n) [rad].

    Returns:
        The root mean square [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return root_mean_square(distances(q, q_ref))


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("q", "q_ref"),
    source="root mean square over ticks and joints",
    label="RMS error per joint",
    fail_value=FAILED_JOINTS,
)
def joint_error_rms_per_joint(q: np.ndarray, q_ref: np.ndarray) -> float:
    """Root mean square over ticks and joints: :func:`joint_error_rms` over the root of the number of joints.

    Comparable between arms of different size; :func:`joint_error_rms_by_joint` gives each joint.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions of the same ticks, shape (N, n) [rad].

    Returns:
        The root mean square [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return root_mean_square(distances(q, q_ref)) / math.sqrt(q.shape[1])


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("q", "q_ref", "dt", "lap"),
    source="mean norm over the last lap",
    label="settled joint error (last lap)",
    fail_value=FAILED_JOINTS,
)
def joint_error_last_lap(q: np.ndarray, q_ref: np.ndarray, dt: float, lap: float) -> float:
    """Mean norm of the joint error over the last lap.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions of the same ticks, shape (N, n) [rad].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The mean norm [rad]; NaN if any sample is not finite or the window is shorter than a lap.

    Raises:
        EmptyWindow: If there is no sample.
    """
    rows = last_lap(len(q), lap, dt)
    return UNDEFINED if rows is None else float(distances(q, q_ref)[rows].mean())


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("q", "q_ref", "dt"),
    source="mean norm over the last 0.2 s",
    label="final joint error",
    fail_value=FAILED_JOINTS,
)
def joint_error_final(q: np.ndarray, q_ref: np.ndarray, dt: float) -> float:
    """Mean norm of the joint error over the last 0.2 s: where a motion that is no cycle arrives.

    Args:
        q: Joint positions, shape (N, n) [rad].
        q_ref: Planned joint positions of the same ticks, shape (N, n) [rad].
        dt: Control period [s].

    Returns:
        The mean norm [rad]; NaN if any sample is not finite or the window is shorter than 0.2 s.

    Raises:
        EmptyWindow: If there is no sample.
    """
    rows = last_rows(len(q), FINAL, dt)
    return UNDEFINED if rows is None else float(distances(q, q_ref)[rows].mean())


@metric(
    unit="m",
    better="lower",
    family="precision",
    needs=("p", "p_ref"),
    source="paper, RMSE_p",
    label="mean position error (the paper's RMSE_p)",
    fail_value=FAILED_POSITION,
)
def tcp_position_error_mean(p: np.ndarray, p_ref: np.ndarray) -> float:
    """Mean distance between tool point and reference.

    The paper calls this RMSE; it is a mean of norms. For the root mean square see
    :func:`tcp_position_error_rms`.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].

    Returns:
        The mean distance [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(distances(p, p_ref).mean())


@metric(
    unit="m",
    better="lower",
    family="precision",
    needs=("p", "p_ref"),
    source="root mean square of the distance",
    label="RMS position error",
    fail_value=FAILED_POSITION,
)
def tcp_position_error_rms(p: np.ndarray, p_ref: np.ndarray) -> float:
    """Root mean square of the distance between tool point and reference.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].

    Returns:
        The root mean square [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return root_mean_square(distances(p, p_ref))


@metric(
    unit="m",
    better="lower",
    family="precision",
    needs=("p", "p_ref"),
    source="95th percentile of the distance",
    label="position error, 95th percentile",
    fail_value=FAILED_POSITION,
)
def tcp_position_error_p95(p: np.ndarray, p_ref: np.ndarray) -> float:
    """Distance between tool point and reference that 95 % of the ticks stay within (linear interpolation).

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].

    Returns:
        The percentile [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.percentile(distances(p, p_ref), 95.0))


@metric(
    unit="m",
    better="lower",
    family="precision",
    needs=("p", "p_ref"),
    source="largest distance",
    label="largest position error",
    fail_value=FAILED_POSITION,
)
def tcp_position_error_max(p: np.ndarray, p_ref: np.ndarray) -> float:
    """Largest distance between tool point and reference.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].

    Returns:
        The maximum [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(distances(p, p_ref).max())


@metric(
    unit="m",
    better="lower",
    family="precision",
    needs=("p", "p_ref", "dt", "lap"),
    source="mean distance over the last lap",
    label="settled position error (last lap)",
    fail_value=FAILED_POSITION,
)
def tcp_position_error_last_lap(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> float:
    """Mean distance over the last lap: what is left once a controller has learnt what it learns.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The mean distance [m]; NaN if any sample is not finite or the window is shorter than a lap.

    Raises:
        EmptyWindow: If there is no sample.
    """
    rows = last_lap(len(p), lap, dt)
    return UNDEFINED if rows is None else float(distances(p, p_ref)[rows].mean())


@metric(
    unit="m",
    better="lower",
    family="precision",
    needs=("p", "p_ref", "dt"),
    source="mean distance over the last 0.2 s",
    label="final position error",
    fail_value=FAILED_POSITION,
)
def tcp_position_error_final(p: np.ndarray, p_ref: np.ndarray, dt: float) -> float:
    """Mean distance over the last 0.2 s: where a motion that is no cycle arrives.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].

    Returns:
        The mean distance [m]; NaN if any sample is not finite or the window is shorter than 0.2 s.

    Raises:
        EmptyWindow: If there is no sample.
    """
    rows = last_rows(len(p), FINAL, dt)
    return UNDEFINED if rows is None else float(distances(p, p_ref)[rows].mean())
