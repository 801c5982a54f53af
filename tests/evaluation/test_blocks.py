"""Laws of correlations of series that remember."""

import numpy as np
import pytest
from scipy.stats import pearsonr
from torquebench.evaluation import TooFewUnits
from torquebench.evaluation.blocks import block_correlation

LAP = 50


def laps(rng, relation):
    """Twenty laps of two series, one value a lap for each, so that a lap is one piece of evidence."""
    x, noise = np.repeat(rng.normal(size=20), LAP), np.repeat(rng.normal(size=20), LAP)
    return x, relation * x + np.sqrt(1.0 - relation**2) * noise


def test_opposite_series_correlate_at_minus_one():
    """With no width at all: every resample says the same."""
    t = np.arange(20 * LAP) / LAP
    x = np.sin(2.0 * np.pi * t) + 0.1 * t
    r, interval = block_correlation([(x, 1.0 - x)], LAP, n_resamples=99)
    assert (r, interval.low, interval.high) == pytest.approx((-1.0, -1.0, -1.0))


def test_series_that_have_nothing_to_do_with_each_other_are_not_found_related():
    """A thousand samples of twenty laps are twenty pieces of evidence; the textbook test would find most related."""
    rng = np.random.default_rng(3)
    draws = [laps(rng, 0.0) for _ in range(200)]
    covered = np.mean([block_correlation([draw], LAP, n_resamples=199)[1].contains(0.0) for draw in draws])
    textbook = np.mean([pearsonr(*draw).pvalue > 0.05 for draw in draws])
    assert textbook < 0.5
    assert 0.89 <= covered <= 0.99


def test_a_relation_is_found_and_more_runs_make_it_surer():
    """Nine runs of r = -0.7."""
    rng = np.random.default_rng(4)
    runs = [laps(rng, -0.7) for _ in range(9)]
    (r, many), (_, one) = block_correlation(runs, LAP), block_correlation(runs[:1], LAP)
    assert r == pytest.approx(-0.7, abs=0.12)
    assert many.high < 0.0
    assert many.high - many.low < one.high - one.low


def test_the_first_lap_counts_as_much_as_any_other():
    """Two gains that rise together in the first lap only, as at a start: the interval lies around the estimate."""
    rng = np.random.default_rng(5)
    x, y = rng.normal(size=(2, 20 * LAP))
    x[:LAP] += np.linspace(-8.0, 0.0, LAP)
    y[:LAP] += np.linspace(-8.0, 0.0, LAP)
    r, interval = block_correlation([(x, y)], LAP)
    assert interval.low < r < interval.high


def test_constant_gains_have_no_correlation():
    """Neither alone nor beside a run that has one."""
    x = np.arange(20.0 * LAP)
    with pytest.raises(TooFewUnits, match="correlation needs at least 1"):
        block_correlation([(x, np.ones_like(x))], LAP)
    assert block_correlation([(x, np.ones_like(x)), (x, x)], LAP, n_resamples=9)[0] == pytest.approx(1.0)


def test_a_few_laps_are_too_few():
    """Nineteen blocks are refused."""
    x = np.arange(19.0 * LAP)
    with pytest.raises(TooFewUnits, match="at least 20 values, got 19"):
        block_correlation([(x, x)], LAP)
