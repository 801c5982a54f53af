"""Smoothness of the torque: a limit cycle or noise that tracking errors can hide."""

import math

import numpy as np

from .registry import UNDEFINED, metric

RIPPLE_CUTOFF, RIPPLE_ORDER = 10.0, 4
"""Where ripple begins [Hz], and the order of the Butterworth filter, applied forwards and backwards."""

RIPPLE_PADDING = 3.0
"""Periods of the cutoff by which the log is continued (odd) at either end."""


def torque_rate_rms_by_joint(tau: np.ndarray, dt: float) -> np.ndarray:
    """Root mean square torque rate of each joint.

    Args:
        tau: Torques that acted, shape (N, n) [N m].
        dt: Control period [s].

    Returns:
        Shape (n,) [N m/s].
    """
    return np.asarray(np.sqrt(np.mean((np.diff(tau, axis=0) / dt) ** 2, axis=0)))


@metric(
    unit="N m/s",
    better="lower",
    family="smoothness",
    needs=("tau", "dt"),
    source="root mean square of the norm of diff(tau) / dt",
    label="RMS torque rate",
)
def torque_rate_rms(tau: np.ndarray, dt: float) -> float:
    """Root mean square of the torque rate's norm; :func:`torque_rate_rms_by_joint` gives each joint.

    Stands beside every tracking figure: a controller on the edge of a limit cycle tracks well.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        dt: Control period [s].

    Returns:
        The root mean square [N m/s]; NaN if any sample is not finite or there is only one.

    Raises:
        EmptyWindow: If there is no sample.
    """
    if len(tau) < 2:
        return UNDEFINED
    change = np.diff(tau, axis=0)
    return math.sqrt(float(np.einsum("kn,kn->", change, change)) / len(change)) / dt


@metric(
    unit="N m/s",
    better="lower",
    family="smoothness",
    needs=("tau", "dt"),
    source="sum of |diff(tau)| / duration",
    label="torque total variation",
)
def torque_total_variation(tau: np.ndarray, dt: float) -> float:
    """Ups and downs of all joints' torques, for each second between the first and the last sample.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        dt: Control period [s].

    Returns:
        The variation [N m/s]; NaN if any sample is not finite or there is only one.

    Raises:
        EmptyWindow: If there is no sample.
    """
    if len(tau) < 2:
        return UNDEFINED
    return float(np.abs(np.diff(tau, axis=0)).sum() / ((len(tau) - 1) * dt))


@metric(
    unit="N m",
    better="lower",
    family="smoothness",
    needs=("tau", "dt"),
    source="root mean square of tau less its zero-phase 10 Hz Butterworth (order 4)",
    label="torque ripple above 10 Hz",
)
def torque_ripple(tau: np.ndarray, dt: float) -> float:
    """Root mean square norm of the torque above 10 Hz, where the plan asks for nothing; spiking noise shows here.

    Args:
        tau: Torques that acted at the joints, shape (N, n) [N m].
        dt: Control period [s].

    Returns:
        The root mean square [N m]; NaN if any sample is not finite, they last no longer than the
        filter's ends (0.3 s), or the sampling rate cannot hold 10 Hz.

    Raises:
        EmptyWindow: If there is no sample.
    """
    from scipy.signal import butter, sosfiltfilt

    if 2.0 * RIPPLE_CUTOFF * dt >= 1.0:
        return UNDEFINED
    sections = butter(RIPPLE_ORDER, RIPPLE_CUTOFF, fs=1.0 / dt, output="sos")
    # SciPy's default of 15 ticks is shorter than the filter's memory: its ends would outweigh the ripple of a lap.
    padding = round(RIPPLE_PADDING / (RIPPLE_CUTOFF * dt))
    if len(tau) <= padding:
        return UNDEFINED
    ripple = tau - sosfiltfilt(sections, tau, axis=0, padlen=padding)
    return math.sqrt(float(np.einsum("kn,kn->", ripple, ripple)) / len(tau))
