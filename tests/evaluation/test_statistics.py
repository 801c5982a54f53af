"""Laws of intervals, tests and ranks: closed forms, the reference implementations, and coverage."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from torquebench.evaluation import TooFewUnits
from torquebench.evaluation.statistics import (
    Interval,
    bca_interval,
    clopper_pearson,
    geometric_mean_ratio,
    holm,
    paired_win_rate,
    prob_improvement,
    ratio_of_means,
    shape_range,
    sign_flip_floor,
    sign_flip_test,
    suite_bootstrap,
    suite_interval,
    t_interval,
    welch_interval,
    wilcoxon_test,
)

RATIOS = np.log([0.8, 0.75, 0.9, 0.7, 0.85, 0.95, 0.6, 0.88])
"""Eight trajectories on which a controller wins every time."""

logs = st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=10)


def test_the_geometric_mean_ratio_of_the_eight():
    """The oracle's headline."""
    assert geometric_mean_ratio(RATIOS) == pytest.approx(0.795992, abs=1e-6)


def test_ratio_of_means_and_geometric_mean_ratio_differ():
    """A = 1, 2, 3 against B = 2, 2, 4: the paper's percentage is 0.75, the honest one 0.7211."""
    a, b = np.array([1.0, 2.0, 3.0]), np.array([2.0, 2.0, 4.0])
    assert ratio_of_means(a, b) == pytest.approx(0.75)
    assert geometric_mean_ratio(np.log(a / b)) == pytest.approx(0.7211, abs=1e-4)


def test_a_reference_of_zero_has_no_ratio():
    """NaN, not a division error in the middle of a report."""
    assert math.isnan(ratio_of_means([1.0], [0.0]))


@given(logs)
def test_the_other_way_round_is_the_inverse(d):
    """gmr(A, B) gmr(B, A) = 1: no side is favoured by the choice of the denominator."""
    assert geometric_mean_ratio(d) * geometric_mean_ratio(-np.array(d)) == pytest.approx(1.0)


def test_the_t_interval_of_the_eight():
    """0.70128 to 0.90349."""
    interval = t_interval(RATIOS).exponentiated()
    assert (interval.low, interval.high) == pytest.approx((0.70128, 0.90349), abs=1e-5)


def test_the_t_interval_of_the_eight_reaches_one_at_its_p_value():
    """The p value of the t test is 0.003751: an interval at that level ends exactly where nothing is different."""
    assert t_interval(RATIOS, level=1.0 - 0.003751).high == pytest.approx(0.0, abs=1e-4)


@given(logs.filter(lambda d: np.ptp(d) > 1e-6))
def test_the_t_interval_is_scipys(d):
    """The closed form against the library's test."""
    expected = stats.ttest_1samp(d, 0.0).confidence_interval(0.95)
    interval = t_interval(d)
    assert (interval.low, interval.high) == pytest.approx((expected.low, expected.high), rel=1e-6, abs=1e-9)


def test_values_that_are_all_alike_are_a_point():
    """Deterministic runs have no spread: the point, and a word for it, not NaN."""
    for interval in (t_interval([0.5] * 6), bca_interval([0.5] * 6)):
        assert (interval.low, interval.high, interval.status) == (0.5, 0.5, "degenerate")


def test_one_trajectory_has_no_interval():
    """With one there is nothing to generalise from."""
    with pytest.raises(TooFewUnits, match="at least 2 values, got 1"):
        t_interval([0.1])


def test_the_bootstrap_interval_of_the_eight():
    """About 0.708 to 0.864 with 9999 resamples of seed 0; narrower than t, which is why t is primary."""
    interval = bca_interval(RATIOS).exponentiated()
    assert (interval.low, interval.high) == pytest.approx((0.708, 0.864), abs=5e-3)


def test_the_bootstrap_is_repeatable():
    """One seed, one interval."""
    assert bca_interval(RATIOS, n_resamples=999) == bca_interval(RATIOS, n_resamples=999)


@pytest.mark.parametrize("n", [0, 1, 2, 4])
def test_the_bootstrap_refuses_what_it_cannot_do(n):
    """With two values SciPy returns the two data points without complaint."""
    with pytest.raises(TooFewUnits) as caught:
        bca_interval(RATIOS[:n])
    assert (caught.value.n, caught.value.minimum) == (n, 5)


def test_the_suite_interval_is_the_closed_form():
    """Var = sum of s_c^2 over C^2 R, with C (R - 1) degrees of freedom."""
    cells = np.array([[1.0, 2.0, 3.0], [4.0, 4.5, 5.0]])
    variance = cells.var(axis=1, ddof=1).sum() / (2**2 * 3)
    half = stats.t.ppf(0.975, 4) * math.sqrt(variance)
    interval = suite_interval(cells)
    assert (interval.low, interval.high) == pytest.approx((cells.mean() - half, cells.mean() + half))


def test_one_repetition_has_no_suite_interval():
    """Trajectories are no repetitions of each other."""
    assert suite_interval([[1.0], [2.0], [3.0]]) is None


def test_a_cell_that_lost_a_run_borrows_the_pooled_variance():
    """One failed run must not cost the interval of the whole suite."""
    full = suite_interval([[1.0, 3.0], [5.0, 7.0], [9.0, 11.0]])
    short = suite_interval([[1.0, 3.0], [5.0, 7.0], [10.0]])
    assert short is not None
    assert short.high - short.low > full.high - full.low
    assert (short.low + short.high) / 2.0 == pytest.approx(6.0)


def test_the_sign_flip_test_counts_all_patterns():
    """2 of 256: only all-won and all-lost are as extreme."""
    assert sign_flip_test(RATIOS) == 2.0 / 256.0 == 0.0078125


def test_one_lost_trajectory_raises_the_p_value():
    """18 of 256 with the first sign reversed."""
    reversed_first = RATIOS * np.array([-1.0, *[1.0] * 7])
    assert sign_flip_test(reversed_first) == 18.0 / 256.0 == 0.0703125


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-2.0, 2.0).filter(lambda x: abs(x) > 1e-3), min_size=2, max_size=8))
def test_the_sign_flip_test_is_scipys(d):
    """SciPy's exact permutation of one sample flips signs too."""
    mean = lambda x, axis: np.mean(x, axis=axis)  # noqa: E731
    options = {"permutation_type": "samples", "n_resamples": np.inf, "vectorized": True}
    expected = min(1.0, stats.permutation_test((np.array(d),), mean, **options).pvalue)
    assert sign_flip_test(d) == pytest.approx(expected, abs=1e-12)


def test_beyond_twenty_trajectories_random_flips_agree_with_the_normal_limit():
    """99 999 patterns of 24: close to the z test, and repeatable."""
    d = np.random.default_rng(1).normal(0.4, 1.0, 24)
    p = sign_flip_test(d)
    assert p == sign_flip_test(d)
    assert p == pytest.approx(2.0 * stats.norm.sf(abs(d.sum()) / np.sqrt((d**2).sum())), abs=0.02)


@pytest.mark.parametrize(("n", "floor"), [(1, 1.0), (5, 0.0625), (6, 0.03125), (8, 0.0078125)])
def test_few_trajectories_cannot_be_significant(n, floor):
    """The smallest two-sided p is 2^(1 - n): five trajectories decide nothing at 5 %."""
    assert sign_flip_floor(n) == floor
    assert sign_flip_test(-np.ones(n) - 0.1 * np.arange(n)) == floor


def test_no_difference_is_no_evidence():
    """All zero: every pattern is as extreme."""
    assert sign_flip_test(np.zeros(6)) == 1.0


def test_holm_multiplies_and_never_reverses_the_order():
    """0.01, 0.04, 0.03 become 0.03, 0.06, 0.06."""
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])


def test_seven_opponents_are_too_many_for_eight_trajectories():
    """Six tests at the floor pass 5 %, seven cannot."""
    assert holm([sign_flip_floor(8)] * 6).max() == pytest.approx(0.0469, abs=1e-4)
    assert holm([sign_flip_floor(8)] * 7).max() == pytest.approx(0.0547, abs=1e-4)


@given(st.lists(st.floats(0.0, 1.0), max_size=12))
def test_holm_lies_between_the_p_value_and_bonferroni(p):
    """It corrects, never beyond the crude bound, never above 1."""
    corrected = holm(p)
    assert np.all(corrected >= p)
    assert np.all(corrected <= np.minimum(1.0, np.array(p) * len(p)) + 1e-15)


@pytest.mark.parametrize(("count", "runs"), [(0, 10), (1, 10), (5, 10), (10, 10), (3, 144)])
def test_clopper_pearson_is_scipys_exact_interval(count, runs):
    """Also at no and at all failures, where the normal approximation has no width."""
    expected = stats.binomtest(count, runs).proportion_ci(method="exact")
    interval = clopper_pearson(count, runs)
    assert (interval.low, interval.high) == pytest.approx((expected.low, expected.high), abs=1e-9)


def test_no_run_has_no_failure_rate():
    """Zero of zero is not zero."""
    with pytest.raises(TooFewUnits):
        clopper_pearson(0, 0)


def test_the_probability_of_improvement_ranks_failures_last_and_halves_ties():
    """1, 2, inf against 2, 3, inf: six of nine."""
    assert prob_improvement([1.0, 2.0, np.inf], [2.0, 3.0, np.inf]) == pytest.approx(6.0 / 9.0)


@pytest.mark.parametrize("tied", [1.0, np.inf])
def test_all_tied_is_a_coin(tied):
    """Also when both always fail."""
    assert prob_improvement([tied] * 3, [tied] * 4) == 0.5
    assert paired_win_rate([tied] * 3, [tied] * 3) == 0.5


@given(st.lists(st.floats(0.0, 9.0), min_size=1, max_size=6), st.lists(st.floats(0.0, 9.0), min_size=1, max_size=6))
def test_the_probability_of_improvement_is_mann_whitneys(a, b):
    """U over the number of pairs, and the two sides sum to one."""
    u = stats.mannwhitneyu(b, a).statistic / (len(a) * len(b))
    assert prob_improvement(a, b) == pytest.approx(u)
    assert prob_improvement(a, b) + prob_improvement(b, a) == pytest.approx(1.0)


def test_pairs_are_won_on_common_seeds():
    """Two wins, one tie, one loss."""
    assert paired_win_rate([1.0, 1.0, 2.0, 9.0], [2.0, 3.0, 2.0, np.inf]) == pytest.approx(3.5 / 4.0)
    assert paired_win_rate([1.0, 1.0, 2.0, np.inf], [2.0, 3.0, 2.0, 9.0]) == pytest.approx(2.5 / 4.0)


def test_ranks_of_no_run_are_refused():
    """No runs, no probability."""
    for statistic in (prob_improvement, paired_win_rate):
        with pytest.raises(TooFewUnits):
            statistic([], [])


def test_the_shape_range_is_the_spread_of_path_means():
    """With the interval of the difference of the two extreme paths over repetitions."""
    found = shape_range({"T1": [[1.0, 1.2]], "T2": [[3.0, 3.2]], "T3": [[2.0, 2.2]]})
    assert (found.value, found.largest, found.smallest) == (pytest.approx(2.0), "T2", "T1")
    half = stats.t.ppf(0.975, 2) * math.sqrt(0.02 / 2 + 0.02 / 2)
    assert (found.interval.low, found.interval.high) == pytest.approx((2.0 - half, 2.0 + half))


def test_the_shape_range_of_single_runs_has_no_interval():
    """Resampling trajectories instead would shrink the range: there is none rather than a wrong one."""
    assert shape_range({"T1": [[1.0]], "T2": [[3.0]]}).interval is None


def test_one_path_has_no_range():
    """Zero, without an interval; no path at all is an error."""
    assert shape_range({"T1": [[1.0, 2.0]]}).value == 0.0
    with pytest.raises(TooFewUnits):
        shape_range({})


def test_an_interval_holds_its_limits():
    """A limit of exactly 1 is not a difference."""
    interval = Interval(0.9, 1.0, 0.95, "t")
    assert interval.contains(1.0)
    assert not interval.contains(1.0001)


def campaigns(trials, rng):
    """Draw log-ratios of 8 trajectories, 9 cells, 10 seeds, without any true effect."""
    trajectory = 0.15 * rng.normal(size=(trials, 8, 1, 1))
    mass = 0.05 * rng.normal(size=(trials, 8, 9, 1))
    return trajectory + mass + 0.03 * rng.normal(size=(trials, 8, 9, 10))


def test_the_interval_over_trajectories_covers_and_the_pooled_one_does_not():
    """95 % must mean 95 %; pooling runs as independent covers the truth in less than two of five campaigns."""
    draws = campaigns(300, np.random.default_rng(3))
    over_paths = np.mean([t_interval(d.mean(axis=(1, 2))).contains(0.0) for d in draws])
    pooled = np.mean([t_interval(d.ravel()).contains(0.0) for d in draws])
    assert 0.92 <= over_paths <= 0.98
    assert pooled < 0.4


def test_false_alarms_stay_at_their_level():
    """Sign-flip tests of nothing, single and six in a family after Holm."""
    draws = np.random.default_rng(5).normal(size=(300, 6, 8))
    p = np.array([[sign_flip_test(d) for d in family] for family in draws])
    assert np.mean(p[:, 0] <= 0.05) <= 0.07
    assert np.mean([holm(family).min() <= 0.05 for family in p]) <= 0.07


def test_the_suite_interval_covers_with_two_repetitions():
    """A bootstrap within cells would cover 82 % here; the closed form keeps its word."""
    rng = np.random.default_rng(7)
    truth = rng.normal(size=(24, 1))
    trials = [suite_interval(truth + 0.1 * rng.normal(size=(24, 2))).contains(float(truth.mean())) for _ in range(300)]
    assert 0.92 <= np.mean(trials) <= 0.98


def test_the_bootstrap_of_the_suite_agrees_with_its_closed_form():
    """Inflated deviations: as wide as the t interval is without its small-sample factor."""
    rng = np.random.default_rng(11)
    cells = rng.normal(size=(40, 1)) + 0.1 * rng.normal(size=(40, 3))
    closed, drawn = suite_interval(cells), suite_bootstrap(cells)
    assert drawn.high - drawn.low == pytest.approx(closed.high - closed.low, rel=0.08)
    assert (drawn.low + drawn.high) / 2.0 == pytest.approx(float(cells.mean()), abs=2e-3)


def test_the_bootstrap_of_the_suite_needs_repetitions():
    """And one cell with a second repetition is enough to resample."""
    assert suite_bootstrap([[1.0], [2.0]]) is None
    assert suite_bootstrap([]) is None
    assert suite_bootstrap([[1.0, 3.0], [2.0]]).contains(2.0)
    assert suite_bootstrap([[1.0, 1.0], [2.0]]).status == "degenerate"


def test_the_signed_rank_test_of_the_eight():
    """All of one sign: 2 of 256 rank patterns; with the first reversed 0.078125."""
    assert wilcoxon_test(RATIOS) == pytest.approx(2.0 / 256.0)
    assert wilcoxon_test(RATIOS * np.array([-1.0, *[1.0] * 7])) == pytest.approx(0.078125)


def test_the_signed_rank_test_of_nothing():
    """Pairs without a difference are no evidence, no pairs are an error."""
    assert wilcoxon_test(np.zeros(6)) == 1.0
    assert wilcoxon_test([0.0, 0.1, 0.2, 0.3]) == wilcoxon_test([0.1, 0.2, 0.3]) == 0.25
    with pytest.raises(TooFewUnits):
        wilcoxon_test([])


@given(logs.filter(lambda d: np.ptp(d) > 1e-6), logs.filter(lambda d: np.ptp(d) > 1e-6))
def test_welchs_interval_is_scipys(a, b):
    """The closed form against the library's test."""
    expected = stats.ttest_ind(a, b, equal_var=False).confidence_interval(0.95)
    interval = welch_interval(a, b)
    assert (interval.low, interval.high) == pytest.approx((expected.low, expected.high), rel=1e-6, abs=1e-9)


def test_welchs_interval_needs_two_of_each():
    """One motion has no spread; two groups without any are a point."""
    assert welch_interval([1.0], [1.0, 2.0]) is None
    assert welch_interval([2.0, 2.0], [1.0, 1.0]) == Interval(1.0, 1.0, 0.95, "welch", "degenerate")


def test_t_covers_where_the_bootstrap_does_not():
    """Why t stands first: at eight trajectories BCa covers less than 95 %, and less than t on the same draws."""
    draws = np.random.default_rng(13).normal(size=(150, 8))
    t_covers = np.mean([t_interval(d).contains(0.0) for d in draws])
    bca_covers = np.mean([bca_interval(d, n_resamples=499).contains(0.0) for d in draws])
    assert bca_covers < t_covers
    assert bca_covers < 0.95
