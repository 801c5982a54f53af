"""How the gains of the spiking controller move together, at the instants at which it updates them."""

from itertools import pairwise

import numpy as np

from .laps import lap_bounds
from .registry import UNDEFINED, metric


def less_lap_mean(series: np.ndarray, lap: float, dt: float) -> np.ndarray:
    """Subtract from each lap of a series its own mean: two ramps correlate without any relation.

    Args:
        series: From phase 0 of a lap, shape (K, n).
        lap: Duration of one lap [s].
        dt: Time between samples [s].

    Returns:
        Whole laps only, shape (L, n) with L <= K.
    """
    bounds = lap_bounds(len(series), lap, dt)
    parts = [series[start:stop] - series[start:stop].mean(axis=0) for start, stop in pairwise(bounds)]
    return np.concatenate(parts) if parts else series[:0]


def gain_correlation_by_joint(stiffness: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Pearson correlation of each joint's two gains.

    Args:
        stiffness: Stiffness of each joint, shape (K, n) [N m/rad].
        damping: Damping of each joint at the same instants, shape (K, n) [N m s/rad].

    Returns:
        Shape (n,) [1]; NaN for a joint with a gain that does not change.
    """
    if len(stiffness) < 2:
        return np.full(stiffness.shape[1], np.nan)
    a, b = stiffness - stiffness.mean(axis=0), damping - damping.mean(axis=0)
    # A constant has no correlation, and the mean of a constant may be a rounding error beside it.
    moves = (np.ptp(stiffness, axis=0) > 0.0) & (np.ptp(damping, axis=0) > 0.0)
    scale = np.sqrt((a * a).sum(axis=0) * (b * b).sum(axis=0))
    return np.where(moves, (a * b).sum(axis=0) / np.where(moves, scale, 1.0), np.nan)


@metric(
    unit="-",
    better="none",
    family="modules",
    needs=("stiffness", "damping"),
    source="median over joints of Pearson's r of k_p and k_v",
    label="correlation of the gains",
    kind="table",
)
def gain_correlation(stiffness: np.ndarray, damping: np.ndarray) -> float:
    """Median over joints of the correlation of their two gains.

    Take the controller's own updates, not values held in between. What is left of it without the lap means, see
    :func:`gain_correlation_within_laps`, is no common drift.

    Args:
        stiffness: Stiffness of each joint at each update, shape (K, n) [N m/rad].
        damping: Damping of each joint at each update, shape (K, n) [N m s/rad].

    Returns:
        The median [1]; NaN if a sample is not finite or no joint has two gains that change.

    Raises:
        EmptyWindow: If there is no update.
        UnequalLengths: If the arrays hold different numbers of updates.
    """
    return _median(gain_correlation_by_joint(stiffness, damping))


@metric(
    unit="-",
    better="none",
    family="modules",
    needs=("stiffness", "damping", "lap", "dt"),
    source="median over joints of Pearson's r of k_p and k_v, each less its mean in each lap",
    label="correlation of the gains within laps",
    kind="table",
)
def gain_correlation_within_laps(stiffness: np.ndarray, damping: np.ndarray, lap: float, dt: float) -> float:
    """Median over joints of the correlation of their two gains, the drift from lap to lap taken out.

    Args:
        stiffness: Stiffness of each joint at each update from phase 0 of a lap, shape (K, n) [N m/rad].
        damping: Damping of each joint at each update, shape (K, n) [N m s/rad].
        lap: Duration of one lap [s].
        dt: Time between updates [s].

    Returns:
        The median [1]; NaN if a sample is not finite, there is no whole lap, or no joint has two gains that change.

    Raises:
        EmptyWindow: If there is no update.
        UnequalLengths: If the arrays hold different numbers of updates.
    """
    cut = [less_lap_mean(gain, lap, dt) for gain in (stiffness, damping)]
    return _median(gain_correlation_by_joint(*cut))


@metric(
    unit="1",
    better="none",
    family="modules",
    needs=("stiffness",),
    source="median over joints of std / mean of k_p",
    label="variation of the stiffness",
    kind="table",
)
def gain_variation(stiffness: np.ndarray) -> float:
    """Median over joints of how much their stiffness varies, as a share of its mean.

    Args:
        stiffness: Stiffness of each joint at each update, shape (K, n) [N m/rad].

    Returns:
        The median [1]; NaN if a sample is not finite or every mean is zero.

    Raises:
        EmptyWindow: If there is no update.
    """
    mean = np.abs(stiffness.mean(axis=0))
    return _median(np.where(mean > 0.0, stiffness.std(axis=0) / np.where(mean > 0.0, mean, 1.0), np.nan))


def _median(values: np.ndarray) -> float:
    """Return the median of the values that are defined."""
    defined = values[np.isfinite(values)]
    return float(np.median(defined)) if len(defined) else UNDEFINED
