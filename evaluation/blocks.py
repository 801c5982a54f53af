"""Correlation of series that remember: resampled lap by lap, since a single sample is no evidence of its own."""

from collections.abc import Sequence

import numpy as np

from .errors import TooFewUnits
from .intervals import Interval

FEWEST_BLOCKS = 20
"""Fewest laps of a run that an interval is computed from."""


def block_correlation(
    runs: Sequence[tuple[np.ndarray, np.ndarray]],
    block: int,
    level: float = 0.95,
    n_resamples: int = 1999,
    seed: int = 0,
) -> tuple[float, Interval]:
    """Return the mean over runs of Pearson's r of two series, with its circular moving-block bootstrap interval.

    Every run is resampled by itself, in as many blocks as it has whole ones, each from any place of it. A block that
    passes the end goes on at the start, or the first lap, in which gains change most, would count less than others.
    The interval tells runs as long as these of the same seeds apart; how much seeds differ is another matter.

    Args:
        runs: The two series of each run, shape (K,) each; a run in which either is constant is left out.
        block: Samples of a block, one lap.
        level: Confidence level.
        n_resamples: Number of resamples.
        seed: Of the resampling.

    Returns:
        The mean r and its percentile interval.

    Raises:
        TooFewUnits: If no run has two series that change, or one of them has fewer than twenty blocks.
    """
    able = [(np.asarray(x, float), np.asarray(y, float)) for x, y in runs if np.ptp(x) > 0.0 and np.ptp(y) > 0.0]
    if not able:
        raise TooFewUnits("correlation", 0, 1)
    shortest = min(len(x) // block for x, _ in able)
    if shortest < FEWEST_BLOCKS:
        raise TooFewUnits("block bootstrap of a correlation", shortest, FEWEST_BLOCKS)
    rng = np.random.default_rng(seed)
    resampled = np.mean([_resampled(x, y, block, n_resamples, rng) for x, y in able], axis=0)
    estimate = float(np.mean([np.corrcoef(x, y)[0, 1] for x, y in able]))
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(resampled, [tail, 1.0 - tail])
    return estimate, Interval(float(low), float(high), level, "blocks")


def _resampled(x: np.ndarray, y: np.ndarray, block: int, n_resamples: int, rng: np.random.Generator) -> np.ndarray:
    """Return r of each resample; sums of a block are differences of running sums."""
    a, b = x - x.mean(), y - y.mean()
    series = np.stack([a, b, a * a, b * b, a * b])
    series = np.concatenate([series, series[:, : block - 1]], axis=1)
    running = np.concatenate([np.zeros((5, 1)), np.cumsum(series, axis=1)], axis=1)
    sums = running[:, block:] - running[:, :-block]
    count = len(x) // block
    drawn = sums[:, rng.integers(0, sums.shape[1], (n_resamples, count))].sum(axis=2) / (count * block)
    mean_a, mean_b, square_a, square_b, product = drawn
    spread = np.sqrt(np.maximum((square_a - mean_a**2) * (square_b - mean_b**2), 1e-300))
    return np.asarray((product - mean_a * mean_b) / spread)
