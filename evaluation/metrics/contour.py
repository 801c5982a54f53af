"""Along, across, and off the path: the error split by the reference's motion."""

import numpy as np

from .geometry import distances, root_mean_square
from .polyline import contour_distances
from .precision import FAILED_POSITION
from .registry import metric

STANDING = 1e-6
"""Reference speed below which a tick has no direction of travel [m/s]."""


def along_track_series(p: np.ndarray, p_ref: np.ndarray, twist_ref: np.ndarray) -> np.ndarray:
    """Error along the reference's direction of travel at each tick.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions, shape (N, 3) [m].
        twist_ref: Reference twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].

    Returns:
        Shape (N,) [m], negative when behind; 0 where the reference stands and has no direction.
    """
    velocity = twist_ref[:, :3]
    speed = np.linalg.norm(velocity, axis=1)
    inverse = np.divide(1.0, speed, out=np.zeros_like(speed), where=speed > STANDING)
    return np.asarray(np.einsum("kd,kd->k", p - p_ref, velocity) * inverse)


def cross_track_series(p: np.ndarray, p_ref: np.ndarray, twist_ref: np.ndarray) -> np.ndarray:
    """Error across the reference's direction of travel at each tick; with the one along, it makes up the norm.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions, shape (N, 3) [m].
        twist_ref: Reference twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].

    Returns:
        Shape (N,) [m]; the whole error where the reference stands.
    """
    square = distances(p, p_ref) ** 2 - along_track_series(p, p_ref, twist_ref) ** 2
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "twist_ref"),
    source="error projected on the reference velocity",
    label="mean along-track error",
    fail_value=FAILED_POSITION,
)
def along_track_error_mean(p: np.ndarray, p_ref: np.ndarray, twist_ref: np.ndarray) -> float:
    """Mean error along the direction of travel, with its sign.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        twist_ref: Reference twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].

    Returns:
        The mean [m], negative when behind; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(along_track_series(p, p_ref, twist_ref).mean())


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "twist_ref"),
    source="error projected on the reference velocity",
    label="RMS along-track error",
    fail_value=FAILED_POSITION,
)
def along_track_error_rms(p: np.ndarray, p_ref: np.ndarray, twist_ref: np.ndarray) -> float:
    """Root mean square of the error along the direction of travel.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        twist_ref: Reference twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].

    Returns:
        The root mean square [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return root_mean_square(along_track_series(p, p_ref, twist_ref))


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "twist_ref"),
    source="error less its projection on the reference velocity",
    label="mean cross-track error",
    fail_value=FAILED_POSITION,
)
def cross_track_error_mean(p: np.ndarray, p_ref: np.ndarray, twist_ref: np.ndarray) -> float:
    """Mean error across the direction of travel; on a curve, lag shows here too, unlike in the contour error.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        twist_ref: Reference twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].

    Returns:
        The mean [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(cross_track_series(p, p_ref, twist_ref).mean())


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "twist_ref"),
    source="error less its projection on the reference velocity",
    label="RMS cross-track error",
    fail_value=FAILED_POSITION,
)
def cross_track_error_rms(p: np.ndarray, p_ref: np.ndarray, twist_ref: np.ndarray) -> float:
    """Root mean square of the error across the direction of travel.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        twist_ref: Reference twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].

    Returns:
        The root mean square [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return root_mean_square(cross_track_series(p, p_ref, twist_ref))


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "dt", "lap"),
    source="distance to the reference polyline within a quarter lap",
    label="mean contour error",
    fail_value=FAILED_POSITION,
)
def contour_error_mean(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> float:
    """Mean distance between tool point and reference path; see :func:`contour_distances`.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s]; infinite for a reference that is no cycle.

    Returns:
        The mean [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(contour_distances(p, p_ref, dt, lap).mean())


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "dt", "lap"),
    source="distance to the reference polyline within a quarter lap",
    label="contour error, 95th percentile",
    fail_value=FAILED_POSITION,
)
def contour_error_p95(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> float:
    """Distance to the reference path that 95 % of the ticks stay within (linear interpolation).

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s]; infinite for a reference that is no cycle.

    Returns:
        The percentile [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(np.percentile(contour_distances(p, p_ref, dt, lap), 95.0))


@metric(
    unit="m",
    better="lower",
    family="lag",
    needs=("p", "p_ref", "dt", "lap"),
    source="distance to the reference polyline within a quarter lap",
    label="largest contour error",
    fail_value=FAILED_POSITION,
)
def contour_error_max(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> float:
    """Largest distance between tool point and reference path.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s]; infinite for a reference that is no cycle.

    Returns:
        The maximum [m]; NaN if any sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return float(contour_distances(p, p_ref, dt, lap).max())
