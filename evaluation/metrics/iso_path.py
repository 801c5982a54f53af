"""Path accuracy and repeatability in the style of ISO 9283:1998, 8.2 and 8.3: geometry, blind to lag along the path.

The standard asks for ten cycles at rated load and speed; here a cycle is a whole lap of the window, however few.
"""

import numpy as np

from .precision import FAILED_POSITION
from .registry import UNDEFINED, metric
from .stations import crossed_by_all, station_crossings, station_rotations


@metric(
    unit="m",
    better="lower",
    family="iso",
    needs=("p", "p_ref", "dt", "lap"),
    source="ISO 9283:1998, 8.2, AT_p",
    label="path accuracy, ISO style",
    fail_value=FAILED_POSITION,
)
def iso_path_accuracy(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> float:
    """Largest distance between the command path and the mean attained path, over 50 stations.

    Args:
        p: Tool positions from phase 0 of a lap, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The distance [m]; NaN if any sample is not finite, there is no whole lap, the path is a point, or more than a
        tenth of the stations are not crossed by every lap.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    found = station_crossings(p, p_ref, dt, lap)
    offset = crossed_by_all(found.offset) if found is not None else None
    return UNDEFINED if offset is None else float(np.linalg.norm(offset.mean(axis=1), axis=1).max())


@metric(
    unit="m",
    better="lower",
    family="iso",
    needs=("p", "p_ref", "dt", "lap"),
    source="ISO 9283:1998, 8.3, RT_p",
    label="path repeatability, ISO style",
    fail_value=FAILED_POSITION,
)
def iso_path_repeatability(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> float:
    """Largest radius, over 50 stations, of mean plus three standard deviations of the laps about their mean path.

    Args:
        p: Tool positions from phase 0 of a lap, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The radius [m]; NaN if any sample is not finite, there are no two laps, the path is a point, or more than a
        tenth of the stations are not crossed by every lap.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    found = station_crossings(p, p_ref, dt, lap)
    offset = crossed_by_all(found.offset) if found is not None else None
    if offset is None or offset.shape[1] < 2:
        return UNDEFINED
    radius = np.linalg.norm(offset - offset.mean(axis=1, keepdims=True), axis=2)
    return float((radius.mean(axis=1) + 3.0 * radius.std(axis=1, ddof=1)).max())


@metric(
    unit="rad",
    better="lower",
    family="iso",
    needs=("p", "p_ref", "quat", "quat_ref", "dt", "lap"),
    source="ISO 9283:1998, 8.2, largest of AT_a, AT_b, AT_c; rotation vector in place of Euler angles",
    label="path accuracy of the attitude, ISO style",
)
def iso_path_accuracy_orientation(
    p: np.ndarray, p_ref: np.ndarray, quat: np.ndarray, quat_ref: np.ndarray, dt: float, lap: float
) -> float:
    """Largest mean deviation of the attitude about any axis of the commanded tool, over 50 stations.

    Args:
        p: Tool positions from phase 0 of a lap, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        quat: Tool attitudes xyzw, shape (N, 4).
        quat_ref: Reference attitudes xyzw, shape (N, 4).
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The angle [rad]; NaN as for :func:`iso_path_accuracy`.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    found = station_crossings(p, p_ref, dt, lap)
    angles = crossed_by_all(station_rotations(found, quat, quat_ref)) if found is not None else None
    return UNDEFINED if angles is None else float(np.abs(angles.mean(axis=1)).max())


@metric(
    unit="rad",
    better="lower",
    family="iso",
    needs=("p", "p_ref", "quat", "quat_ref", "dt", "lap"),
    source="ISO 9283:1998, 8.3, largest of RT_a, RT_b, RT_c; rotation vector in place of Euler angles",
    label="path repeatability of the attitude, ISO style",
)
def iso_path_repeatability_orientation(
    p: np.ndarray, p_ref: np.ndarray, quat: np.ndarray, quat_ref: np.ndarray, dt: float, lap: float
) -> float:
    """Three standard deviations of the attitude over the laps, about the worst axis at the worst of 50 stations.

    Args:
        p: Tool positions from phase 0 of a lap, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        quat: Tool attitudes xyzw, shape (N, 4).
        quat_ref: Reference attitudes xyzw, shape (N, 4).
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The angle [rad]; NaN as for :func:`iso_path_repeatability`.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    found = station_crossings(p, p_ref, dt, lap)
    angles = crossed_by_all(station_rotations(found, quat, quat_ref)) if found is not None else None
    if angles is None or angles.shape[1] < 2:
        return UNDEFINED
    return 3.0 * float(angles.std(axis=1, ddof=1).max())
