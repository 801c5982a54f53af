"""Precision of the tool attitude; the geodesic angle is primary, Euler angles only speak to printed numbers."""

import math

import numpy as np

from .geometry import roll_pitch_yaw, root_mean_square, rotation_angles
from .laps import last_lap, last_rows
from .precision import FINAL
from .registry import UNDEFINED, metric

FAILED_ORIENTATION = math.pi
"""What a failed run counts as: no attitude is further away [rad]."""


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("quat", "quat_ref"),
    source="geodesic on SO(3)",
    label="mean orientation error",
    fail_value=FAILED_ORIENTATION,
)
def tcp_orientation_error_mean(quat: np.ndarray, quat_ref: np.ndarray) -> float:
    """Mean geodesic angle between tool attitude and reference.

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).

    Returns:
        The mean angle [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(rotation_angles(quat, quat_ref).mean())


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("quat", "quat_ref"),
    source="geodesic on SO(3)",
    label="RMS orientation error",
    fail_value=FAILED_ORIENTATION,
)
def tcp_orientation_error_rms(quat: np.ndarray, quat_ref: np.ndarray) -> float:
    """Root mean square of the geodesic angle between tool attitude and reference.

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).

    Returns:
        The root mean square [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return root_mean_square(rotation_angles(quat, quat_ref))


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("quat", "quat_ref"),
    source="geodesic on SO(3)",
    label="orientation error, 95th percentile",
    fail_value=FAILED_ORIENTATION,
)
def tcp_orientation_error_p95(quat: np.ndarray, quat_ref: np.ndarray) -> float:
    """Geodesic angle that 95 % of the ticks stay within (linear interpolation).

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).

    Returns:
        The percentile [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.percentile(rotation_angles(quat, quat_ref), 95.0))


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("quat", "quat_ref"),
    source="geodesic on SO(3)",
    label="largest orientation error",
    fail_value=FAILED_ORIENTATION,
)
def tcp_orientation_error_max(quat: np.ndarray, quat_ref: np.ndarray) -> float:
    """Largest geodesic angle between tool attitude and reference.

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).

    Returns:
        The maximum [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(rotation_angles(quat, quat_ref).max())


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("quat", "quat_ref", "dt", "lap"),
    source="mean geodesic angle over the last lap",
    label="settled orientation error (last lap)",
    fail_value=FAILED_ORIENTATION,
)
def tcp_orientation_error_last_lap(quat: np.ndarray, quat_ref: np.ndarray, dt: float, lap: float) -> float:
    """Mean geodesic angle over the last lap.

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The mean angle [rad]; NaN if any sample is not finite or the window is shorter than a lap.

    Raises:
        EmptyWindow: If there is no sample.
    """
    rows = last_lap(len(quat), lap, dt)
    return UNDEFINED if rows is None else float(rotation_angles(quat, quat_ref)[rows].mean())


@metric(
    unit="rad",
    better="lower",
    family="precision",
    needs=("quat", "quat_ref", "dt"),
    source="mean geodesic angle over the last 0.2 s",
    label="final orientation error",
    fail_value=FAILED_ORIENTATION,
)
def tcp_orientation_error_final(quat: np.ndarray, quat_ref: np.ndarray, dt: float) -> float:
    """Mean geodesic angle over the last 0.2 s: where a motion that is no cycle arrives.

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).
        dt: Control period [s].

    Returns:
        The mean angle [rad]; NaN if any sample is not finite or the window is shorter than 0.2 s.

    Raises:
        EmptyWindow: If there is no sample.
    """
    rows = last_rows(len(quat), FINAL, dt)
    return UNDEFINED if rows is None else float(rotation_angles(quat, quat_ref)[rows].mean())


@metric(
    unit="rad",
    better="none",
    family="precision",
    needs=("quat", "quat_ref"),
    source="paper, RMSE_o, with the angles' differences wrapped",
    label="mean Euler-angle error (paper form)",
    fail_value=FAILED_ORIENTATION,
)
def tcp_orientation_error_euler_wrapped(quat: np.ndarray, quat_ref: np.ndarray) -> float:
    """Mean norm of the wrapped differences of roll, pitch and yaw.

    Equals the geodesic angle near tool-down, and grows without meaning as the pitch nears 90 degrees: only for
    comparison with printed numbers. :func:`tcp_orientation_error_mean` is the honest one.

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).

    Returns:
        The mean norm [rad]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    difference = roll_pitch_yaw(quat_ref) - roll_pitch_yaw(quat)
    wrapped = (difference + math.pi) % (2.0 * math.pi) - math.pi
    return float(np.linalg.norm(wrapped, axis=1).mean())


def tcp_orientation_error_euler_raw(quat: np.ndarray, quat_ref: np.ndarray) -> float:
    """Mean norm of the bare differences of roll, pitch and yaw: the paper's formula taken literally.

    Not a registered metric: at tool-down the roll jumps between -pi and pi, and half of all ticks are wrong by
    more than a radian. It stands here to show that.

    Args:
        quat: Tool attitudes, unit quaternions xyzw in the base frame, shape (N, 4).
        quat_ref: Reference attitudes of the same ticks, shape (N, 4).

    Returns:
        The mean norm [rad].
    """
    return float(np.linalg.norm(roll_pitch_yaw(quat_ref) - roll_pitch_yaw(quat), axis=1).mean())
