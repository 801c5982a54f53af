"""Intervals: how sure a mean is, for new motions, for this suite, and for a count of failures."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .errors import TooFewUnits

SMALLEST_BOOTSTRAP = 5
"""Fewest values that a bootstrap is computed from; with two, SciPy returns the two data points without complaint."""


@dataclass(frozen=True)
class Interval:
    """A confidence interval.

    Attributes:
        low: Lower limit.
        high: Upper limit.
        level: Confidence level, for example 0.95.
        method: How it was made: ``t``, ``welch``, ``bca``, ``suite``, ``suite bootstrap``, ``blocks``,
            ``clopper-pearson``; ``range``, the smallest and largest value and no confidence.
        status: ``ok``; ``degenerate``, all values alike, so that the limits are the point itself.
    """

    low: float
    high: float
    level: float
    method: str
    status: Literal["ok", "degenerate"] = "ok"

    def contains(self, value: float) -> bool:
        """Return whether a value lies within the limits, limits included."""
        return self.low <= value <= self.high

    def exponentiated(self) -> "Interval":
        """Return the interval of a ratio from that of its logarithm."""
        return Interval(math.exp(self.low), math.exp(self.high), self.level, self.method, self.status)


@dataclass(frozen=True)
class ShapeRange:
    """How much a mean depends on the path: largest less smallest path mean, trajectories fixed.

    Attributes:
        value: The range, in the metric's unit.
        largest: Trajectory with the largest mean.
        smallest: Trajectory with the smallest mean.
        interval: Interval over repetitions, None without repetitions. There is none over trajectories: a resampled
            range is smaller than the true one.
    """

    value: float
    largest: str
    smallest: str
    interval: Interval | None


def t_interval(values: Sequence[float] | np.ndarray, level: float = 0.95) -> Interval:
    """Student's interval of a mean; over trajectory means it answers for new motions.

    Args:
        values: One value for each unit, shape (n,).
        level: Confidence level.

    Returns:
        The interval, in the values' unit; the point itself if all values are alike.

    Raises:
        TooFewUnits: If there are fewer than two values.
    """
    sample = np.asarray(values, dtype=float)
    if len(sample) < 2:
        raise TooFewUnits("t interval", len(sample), 2)
    error = float(sample.std(ddof=1)) / math.sqrt(len(sample))
    return _around(float(sample.mean()), error, len(sample) - 1, level, "t")


def bca_interval(
    values: Sequence[float] | np.ndarray, level: float = 0.95, n_resamples: int = 9999, seed: int = 0
) -> Interval:
    """Bias-corrected and accelerated bootstrap interval of a mean; narrower than it should be at small n.

    Args:
        values: One value for each unit, shape (n,).
        level: Confidence level.
        n_resamples: Number of resamples.
        seed: Of the resampling; one seed, one interval.

    Returns:
        The interval, in the values' unit; the point itself if all values are alike.

    Raises:
        TooFewUnits: If there are fewer than five values.
    """
    from scipy.stats import bootstrap

    sample = np.asarray(values, dtype=float)
    if len(sample) < SMALLEST_BOOTSTRAP:
        raise TooFewUnits("BCa interval", len(sample), SMALLEST_BOOTSTRAP)
    if np.ptp(sample) == 0.0:
        return Interval(float(sample[0]), float(sample[0]), level, "bca", "degenerate")
    rng = np.random.default_rng(seed)
    drawn = bootstrap((sample,), np.mean, confidence_level=level, method="BCa", n_resamples=n_resamples, rng=rng)
    limits = drawn.confidence_interval
    return Interval(float(limits.low), float(limits.high), level, "bca")


def suite_interval(
    cells: Sequence[Sequence[float] | np.ndarray],
    weights: Sequence[float] | None = None,
    level: float = 0.95,
) -> Interval | None:
    r"""Interval of a weighted sum of cell means over repetitions, the cells being fixed.

    .. math:: \mathrm{Var} = \sum_c w_c^2 s_c^2 / R_c, \quad \text{t with } \sum_c (R_c - 1) \text{ degrees of freedom}

    With equal weights 1/C and equal R this is the sum of variances over C^2 R. A bootstrap within cells would be too
    narrow by the root of (R - 1) / R. A cell left with one repetition borrows the pooled variance.

    Args:
        cells: The repetitions of each cell.
        weights: One weight for each cell; 1/C each if None.
        level: Confidence level.

    Returns:
        The interval, in the values' unit; None if no cell has a second repetition.
    """
    samples = [np.asarray(cell, dtype=float) for cell in cells]
    counts = np.array([len(sample) for sample in samples])
    freedom = int((counts - 1).sum())
    if freedom < 1:
        return None
    factors = np.full(len(samples), 1.0 / len(samples)) if weights is None else np.asarray(weights, dtype=float)
    squares = np.array([((sample - sample.mean()) ** 2).sum() for sample in samples])
    variances = np.where(counts > 1, squares / np.maximum(counts - 1, 1), squares.sum() / freedom)
    mean = float(np.sum(factors * [sample.mean() for sample in samples]))
    return _around(mean, math.sqrt(float(np.sum(factors**2 * variances / counts))), freedom, level, "suite")


def suite_bootstrap(
    cells: Sequence[Sequence[float] | np.ndarray],
    weights: Sequence[float] | None = None,
    level: float = 0.95,
    n_resamples: int = 1999,
    seed: int = 0,
) -> Interval | None:
    """Bootstrap interval of the same sum as :func:`suite_interval`, repetitions resampled within each cell.

    Deviations from a cell's mean are inflated by the root of R / (R - 1), or the interval would be too narrow by it. A
    cell with one repetition stays as it is.

    Args:
        cells: The repetitions of each cell.
        weights: One weight for each cell; 1/C each if None.
        level: Confidence level.
        n_resamples: Number of resamples.
        seed: Of the resampling; one seed, one interval.

    Returns:
        The percentile interval, in the values' unit; None if no cell has a second repetition.
    """
    samples = [np.asarray(cell, dtype=float) for cell in cells]
    if max((len(sample) for sample in samples), default=0) < 2:
        return None
    factors = np.full(len(samples), 1.0 / len(samples)) if weights is None else np.asarray(weights, dtype=float)
    rng, total = np.random.default_rng(seed), np.zeros(n_resamples)
    for factor, sample in zip(factors, samples, strict=True):
        count, mean = len(sample), sample.mean()
        inflated = (sample - mean) * math.sqrt(count / max(count - 1, 1))
        total += factor * (mean + inflated[rng.integers(0, count, (n_resamples, count))].mean(axis=1))
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(total, [tail, 1.0 - tail])
    return Interval(float(low), float(high), level, "suite bootstrap", "ok" if high > low else "degenerate")


def welch_interval(
    a: Sequence[float] | np.ndarray, b: Sequence[float] | np.ndarray, level: float = 0.95
) -> Interval | None:
    """Welch's interval of the difference of two means with spreads of their own, for example fast less slow motions.

    Args:
        a: One value for each unit of the first group, shape (n,).
        b: The same of the second group, shape (m,).
        level: Confidence level.

    Returns:
        The interval of mean a less mean b; None if a group has fewer than two values.
    """
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    if min(len(first), len(second)) < 2:
        return None
    parts = np.array([group.var(ddof=1) / len(group) for group in (first, second)])
    difference, total = float(first.mean() - second.mean()), float(parts.sum())
    if total == 0.0:
        return Interval(difference, difference, level, "welch", "degenerate")
    freedom = total**2 / float((parts**2 / (np.array([len(first), len(second)]) - 1)).sum())
    return _around(difference, math.sqrt(total), freedom, level, "welch")


def shape_range(paths: Mapping[str, Sequence[Sequence[float] | np.ndarray]], level: float = 0.95) -> ShapeRange:
    """Range of the path means, with its interval over repetitions.

    The two extreme paths are taken as given, so the interval is that of the difference of their means.

    Args:
        paths: Trajectory to its cells, each with its repetitions.
        level: Confidence level.

    Returns:
        The range with the two paths' names.

    Raises:
        TooFewUnits: If there is no path.
    """
    if not paths:
        raise TooFewUnits("shape range", 0, 1)
    means = {name: float(np.mean([np.mean(cell) for cell in cells])) for name, cells in paths.items()}
    largest, smallest = max(means, key=means.__getitem__), min(means, key=means.__getitem__)
    if len(paths) < 2:
        return ShapeRange(0.0, largest, smallest, None)
    high, low = paths[largest], paths[smallest]
    weights = [1.0 / len(high)] * len(high) + [-1.0 / len(low)] * len(low)
    return ShapeRange(
        means[largest] - means[smallest], largest, smallest, suite_interval([*high, *low], weights, level)
    )


def clopper_pearson(count: int, runs: int, level: float = 0.95) -> Interval:
    """Exact interval of a failure rate.

    Args:
        count: Failures.
        runs: Runs, at least one.
        level: Confidence level.

    Returns:
        The interval of the rate, within [0, 1].

    Raises:
        TooFewUnits: If there is no run.
    """
    from scipy.special import betaincinv

    if runs < 1:
        raise TooFewUnits("Clopper-Pearson interval", runs, 1)
    tail = (1.0 - level) / 2.0
    low = 0.0 if count == 0 else float(betaincinv(count, runs - count + 1, tail))
    high = 1.0 if count == runs else float(betaincinv(count + 1, runs - count, 1.0 - tail))
    return Interval(low, high, level, "clopper-pearson")


def _around(mean: float, error: float, freedom: float, level: float, method: str) -> Interval:
    """Return Student's interval of a mean with a standard error."""
    from scipy.special import stdtrit

    if error == 0.0:
        return Interval(mean, mean, level, method, "degenerate")
    half = float(stdtrit(freedom, 0.5 + level / 2.0)) * error
    return Interval(mean - half, mean + half, level, method)
