"""Statistics of paired comparisons: ratios, tests, ranks. The trajectory is the unit, lower is better."""

from collections.abc import Sequence

import numpy as np

from .errors import TooFewUnits
from .intervals import (
    Interval,
    ShapeRange,
    bca_interval,
    clopper_pearson,
    shape_range,
    suite_bootstrap,
    suite_interval,
    t_interval,
    welch_interval,
)

__all__ = [
    "Interval",
    "ShapeRange",
    "bca_interval",
    "clopper_pearson",
    "geometric_mean_ratio",
    "holm",
    "paired_win_rate",
    "prob_improvement",
    "ratio_of_means",
    "shape_range",
    "sign_flip_floor",
    "sign_flip_test",
    "suite_bootstrap",
    "suite_interval",
    "t_interval",
    "welch_interval",
    "wilcoxon_test",
]

EXACT_FLIPS = 20
"""Most values whose sign patterns are all counted; beyond, 99 999 random ones are."""

RANDOM_FLIPS = 99_999


def geometric_mean_ratio(log_ratios: Sequence[float] | np.ndarray) -> float:
    """Geometric mean of ratios: unit-free, and its inverse is the ratio the other way round.

    Args:
        log_ratios: ln(A / B) for each unit, shape (n,).

    Returns:
        The ratio; below 1 where A is smaller.

    Raises:
        TooFewUnits: If there is no value.
    """
    sample = np.asarray(log_ratios, dtype=float)
    if len(sample) == 0:
        raise TooFewUnits("geometric mean ratio", 0, 1)
    return float(np.exp(sample.mean()))


def ratio_of_means(a: Sequence[float] | np.ndarray, b: Sequence[float] | np.ndarray) -> float:
    """Mean of A over mean of B: the paper's percentage, dominated by the units with large errors.

    Args:
        a: One value for each unit, shape (n,).
        b: The same for the reference, in the same unit.

    Returns:
        The ratio; NaN if the reference's mean is zero.
    """
    below = float(np.mean(b))
    return float(np.mean(a)) / below if below != 0.0 else float("nan")


def sign_flip_test(differences: Sequence[float] | np.ndarray, seed: int = 0) -> float:
    """Two-sided permutation test of paired differences: how often random signs give as large a mean.

    Exact up to twenty values, where all 2^n patterns are counted; 99 999 random patterns beyond.

    Args:
        differences: One difference for each unit, for example log-ratios, shape (n,).
        seed: Of the random patterns.

    Returns:
        The p value; never below :func:`sign_flip_floor`.

    Raises:
        TooFewUnits: If there is no value.
    """
    sample = np.asarray(differences, dtype=float)
    if len(sample) == 0:
        raise TooFewUnits("sign-flip test", 0, 1)
    # Sums that are equal in exact arithmetic differ by rounding; they must count as equal.
    threshold = abs(float(sample.sum())) - 1e-12 * float(np.abs(sample).sum())
    if len(sample) <= EXACT_FLIPS:
        sums = np.zeros(1)
        for value in sample:
            sums = np.concatenate([sums + value, sums - value])
        return float(np.mean(np.abs(sums) >= threshold))
    rng = np.random.default_rng(seed)
    extreme = 0
    for start in range(0, RANDOM_FLIPS, 10_000):
        signs = rng.integers(0, 2, size=(min(10_000, RANDOM_FLIPS - start), len(sample))) * 2 - 1
        extreme += int(np.sum(np.abs(signs @ sample) >= threshold))
    return (extreme + 1) / (RANDOM_FLIPS + 1)


def sign_flip_floor(n: int) -> float:
    """Smallest two-sided p value that n paired differences can give.

    Args:
        n: Number of units.

    Returns:
        2^(1 - n), at most 1.
    """
    return min(1.0, 2.0 ** (1 - n))


def wilcoxon_test(differences: Sequence[float] | np.ndarray) -> float:
    """Two-sided exact signed-rank test of paired differences: beside the sign-flip test, and deaf to outliers.

    Args:
        differences: One difference for each unit, for example log-ratios, shape (n,).

    Returns:
        The p value; 1 if no difference is other than zero.

    Raises:
        TooFewUnits: If there is no value.
    """
    from scipy.stats import wilcoxon

    sample = np.asarray(differences, dtype=float)
    if len(sample) == 0:
        raise TooFewUnits("signed-rank test", 0, 1)
    # A pair without a difference has no sign to rank.
    signed = sample[sample != 0.0]
    if len(signed) == 0:
        return 1.0
    return float(wilcoxon(signed, method="exact" if len(signed) <= EXACT_FLIPS else "approx").pvalue)


def holm(p_values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Holm's correction for a family: one metric, one reference controller, all its opponents.

    Args:
        p_values: Shape (m,).

    Returns:
        Corrected p values in the same order, shape (m,).
    """
    p = np.asarray(p_values, dtype=float)
    order = np.argsort(p, kind="stable")
    corrected = np.empty_like(p)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)))
    return corrected


def prob_improvement(a: Sequence[float] | np.ndarray, b: Sequence[float] | np.ndarray) -> float:
    """Probability that a run of A beats a run of B in one cell, lower being better; ties count one half.

    Args:
        a: Errors of A's runs, infinite for a failed run, shape (R_a,).
        b: Errors of B's runs, shape (R_b,).

    Returns:
        The probability; 0.5 if all are tied, also if all failed.

    Raises:
        TooFewUnits: If either side has no run.
    """
    ours, theirs = np.asarray(a, dtype=float)[:, None], np.asarray(b, dtype=float)
    if min(len(ours), len(theirs)) == 0:
        raise TooFewUnits("probability of improvement", 0, 1)
    return float(np.mean((ours < theirs) + 0.5 * (ours == theirs)))


def paired_win_rate(a: Sequence[float] | np.ndarray, b: Sequence[float] | np.ndarray) -> float:
    """Share of common seeds on which A beats B, lower being better; ties count one half.

    Args:
        a: Errors of A, infinite for a failed run, shape (n,).
        b: Errors of B on the same seeds, shape (n,).

    Returns:
        The share.

    Raises:
        TooFewUnits: If there is no pair.
    """
    ours, theirs = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    if len(ours) == 0:
        raise TooFewUnits("paired win rate", 0, 1)
    return float(np.mean((ours < theirs) + 0.5 * (ours == theirs)))
