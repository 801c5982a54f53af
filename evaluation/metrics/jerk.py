"""Smoothness of the tool's motion: its jerk, and two measures made for point-to-point movements."""

import math

import numpy as np

from .geometry import root_mean_square
from .registry import UNDEFINED, metric
from .shared import shared_series

JERK_WINDOW, JERK_ORDER = 0.051, 4
"""Width of the Savitzky-Golay filter [s] (51 samples at 1 kHz), and the order of its polynomial."""

SMALLEST_JERK = 1e-6
"""Root mean square jerk below which a reference has none to divide by [m/s^3]."""

SPARC_PADDING, SPARC_CUTOFF, SPARC_THRESHOLD = 4, 10.0, 0.05
"""Factor of zero padding as a power of two, highest frequency [Hz], smallest amplitude that counts [1]."""


def filter_length(width: float, order: int, dt: float) -> int:
    """Return the odd number of samples of a Savitzky-Golay filter, enough for its polynomial.

    Args:
        width: Its width [s].
        order: Order of the polynomial.
        dt: Time between samples [s].
    """
    half = max(round((width / dt - 1.0) / 2.0), order // 2 + 1)
    return 2 * half + 1


@shared_series
def jerk_series(p: np.ndarray, dt: float) -> np.ndarray:
    """Norm of the third derivative of a path by a Savitzky-Golay filter.

    Args:
        p: Positions, shape (N, 3), at least a filter's length of them [m].
        dt: Control period [s].

    Returns:
        Shape (N,) [m/s^3].
    """
    from scipy.signal import savgol_filter

    length = filter_length(JERK_WINDOW, JERK_ORDER, dt)
    jerk = savgol_filter(p, length, JERK_ORDER, deriv=3, delta=dt, axis=0)
    return np.asarray(np.sqrt(np.einsum("kd,kd->k", jerk, jerk)))


@metric(
    unit="1",
    better="lower",
    family="smoothness",
    needs=("p", "p_ref", "dt"),
    source="RMS of the tool's jerk / RMS of the reference's (Savitzky-Golay, 51 ms, order 4, both)",
    label="jerk by planned jerk",
)
def jerk_ratio(p: np.ndarray, p_ref: np.ndarray, dt: float) -> float:
    """How much rougher the tool moves than its reference; 1 is as smooth.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].

    Returns:
        The ratio [1]; NaN if any sample is not finite, the filter is longer than the window, or the reference has no
        jerk (a line at constant speed).

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    if len(p) < filter_length(JERK_WINDOW, JERK_ORDER, dt):
        return UNDEFINED
    planned = root_mean_square(jerk_series(p_ref, dt))
    return UNDEFINED if planned < SMALLEST_JERK else root_mean_square(jerk_series(p, dt)) / planned


def log_dimensionless_jerk(speed: np.ndarray, dt: float) -> float:
    """Return the log dimensionless jerk of a speed profile.

    Args:
        speed: Shape (N,) [m/s].
        dt: Time between samples [s].

    Returns:
        ``-ln(T^3 / peak^2 x sum of (second difference / dt^2)^2 dt)`` [1]; NaN for fewer than three samples, rest or
        a constant acceleration.
    """
    if len(speed) < 3:
        return UNDEFINED
    peak, change = float(np.abs(speed).max()), np.diff(speed, 2) / dt**2
    cost = float(change @ change) * dt * (len(speed) * dt) ** 3
    return -math.log(cost / peak**2) if peak > 0.0 and cost > 0.0 else UNDEFINED


@metric(
    unit="1",
    better="lower",
    family="smoothness",
    needs=("twist", "dt"),
    source="log dimensionless jerk, Balasubramanian et al. 2012",
    label="log dimensionless jerk (exploratory)",
)
def ldlj(twist: np.ndarray, dt: float) -> float:
    """Log dimensionless jerk of the tool's speed; less negative, so a lower magnitude, is smoother.

    Made for one movement from rest to rest; on laps it falls with their number. Exploratory.

    Args:
        twist: Tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        dt: Control period [s].

    Returns:
        The logarithm [1]; NaN if any sample is not finite, there are fewer than three, or the tool rests.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return log_dimensionless_jerk(np.linalg.norm(twist[:, :3], axis=1), dt)


def spectral_arc_length(speed: np.ndarray, dt: float) -> float:
    """Return the spectral arc length of a speed profile.

    Args:
        speed: Shape (N,) [m/s].
        dt: Time between samples [s].

    Returns:
        Minus the length of the normalised amplitude spectrum up to 10 Hz and down to 5 % of its peak [1]; NaN for rest
        or fewer than two samples.
    """
    if len(speed) < 2 or not np.abs(speed).max() > 0.0:
        return UNDEFINED
    length = 2 ** (math.ceil(math.log2(len(speed))) + SPARC_PADDING)
    amplitude = np.abs(np.fft.rfft(speed, length))
    amplitude /= amplitude.max()
    kept = amplitude[: int(SPARC_CUTOFF * length * dt) + 1]
    strong = np.flatnonzero(kept >= SPARC_THRESHOLD)
    kept = kept[strong[0] : strong[-1] + 1] if len(strong) else kept[:0]
    if len(kept) < 2:
        return UNDEFINED
    return -float(np.hypot(np.diff(kept), 1.0 / (len(kept) - 1)).sum())


@metric(
    unit="1",
    better="lower",
    family="smoothness",
    needs=("twist", "dt"),
    source="spectral arc length, Balasubramanian et al. 2015; 10 Hz, threshold 5 %",
    label="spectral arc length (exploratory)",
)
def sparc(twist: np.ndarray, dt: float) -> float:
    """Spectral arc length of the tool's speed; less negative, so a lower magnitude, is smoother.

    Made for one movement from rest to rest: on a circle at constant speed it does not see a ripple of 5 %.
    Exploratory.

    Args:
        twist: Tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        dt: Control period [s].

    Returns:
        The arc length, negative [1]; NaN if any sample is not finite, there is only one, or the tool rests.

    Raises:
        EmptyWindow: If there is no sample.
    """
    return spectral_arc_length(np.linalg.norm(twist[:, :3], axis=1), dt)
