"""Laws of paired comparisons: what pairs, what a failure costs, and when there is a verdict."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from torquebench.evaluation import (
    AmbiguousRuns,
    Interval,
    NothingToCompare,
    UnknownMetric,
    compare,
    compare_all,
    decide,
)
from torquebench.evaluation.metrics import METRICS
from torquebench.evaluation.rows import Reading, read

ERROR = "tcp_position_error_mean"
EASE = {f"T{i}": ratio for i, ratio in enumerate([0.8, 0.75, 0.9, 0.7, 0.85, 0.95, 0.6, 0.88], start=1)}
"""Ratio of the better controller on each trajectory: the oracle's eight."""


def plain(trajectory, mass, repetition):
    """A reference that is worse on heavier loads, the same on every trajectory and repetition."""
    return 0.01 * mass


def better(trajectory, mass, repetition):
    """A controller with the oracle's ratios."""
    return EASE[trajectory] * plain(trajectory, mass, repetition)


def noisy(base, scale, seed=0):
    """Give a controller's runs a scatter between repetitions."""
    rng = np.random.default_rng(seed)
    return lambda *run: base(*run) * math.exp(scale * rng.normal())


def except_where(base, outcomes):
    """Replace single outcomes, by trajectory, mass and repetition."""
    return lambda *run: outcomes.get(run, base(*run))


def test_the_ratio_is_the_geometric_mean_over_trajectories(grid):
    """The oracle's eight, through the whole path from rows to word."""
    found = compare(grid.of("a", better).of("b", plain).rows, "a", "b", ERROR)
    assert found.gmr == pytest.approx(0.795992, abs=1e-6)
    assert (found.interval_new_motions.low, found.interval_new_motions.high) == pytest.approx(
        (0.70128, 0.90349), abs=1e-5
    )
    assert (found.bca.low, found.bca.high) == pytest.approx((0.708, 0.864), abs=5e-3)
    assert found.p_sign_flip == 0.0078125
    assert (found.n_trajectories, found.n_pairs, found.runs) == (8, 32, 32)
    assert found.verdict == "better"
    assert found.remarks == ()


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_other_way_round_is_the_inverse_with_the_opposite_word(grid, seed):
    """Which controller is called the reference decides nothing."""
    rows = grid.of("a", noisy(better, 0.2, seed)).of("b", noisy(plain, 0.2, seed + 1)).rows
    ours, theirs = compare(rows, "a", "b", ERROR), compare(rows, "b", "a", ERROR)
    assert ours.gmr * theirs.gmr == pytest.approx(1.0)
    assert ours.prob_improvement + theirs.prob_improvement == pytest.approx(1.0)
    opposite = {"better": "worse", "worse": "better"}
    assert theirs.verdict == opposite.get(ours.verdict, ours.verdict)


def test_a_controller_against_itself_is_undecided(grid):
    """Ratio 1, a coin, and no word."""
    found = compare(grid.of("a", noisy(plain, 0.1)).rows, "a", "a", ERROR)
    assert (found.gmr, found.prob_improvement, found.win_rate) == (1.0, 0.5, 0.5)
    assert found.verdict == "not enough to decide"
    assert "practically equal" in found.remarks


def test_more_repetitions_do_not_decide_about_new_motions(grid):
    """Trajectories carry the uncertainty: the suite interval shrinks, the other stays."""
    few, many = grid, replace(grid, repetitions=10)
    narrow, wide = (
        compare(g.of("a", noisy(better, 0.02)).of("b", noisy(plain, 0.02, 1)).rows, "a", "b", ERROR)
        for g in (many, few)
    )
    width = lambda interval: interval.high - interval.low  # noqa: E731
    assert width(narrow.interval_suite) < 0.6 * width(wide.interval_suite)
    assert width(narrow.interval_new_motions) == pytest.approx(width(wide.interval_new_motions), rel=0.2)
    assert width(narrow.interval_suite) < width(narrow.interval_new_motions)


def test_single_runs_have_no_suite_interval(grid):
    """One repetition says nothing about the next."""
    rows = replace(grid, repetitions=1).of("a", better).of("b", plain).rows
    assert compare(rows, "a", "b", ERROR).interval_suite is None


def test_five_trajectories_decide_nothing(grid):
    """No p value below 5 % exists there, however large the effect."""
    few = replace(grid, trajectories=("T1", "T2", "T3", "T4", "T5"))
    found = compare(few.of("a", lambda *run: 0.1 * better(*run)).of("b", plain).rows, "a", "b", ERROR)
    assert found.interval_new_motions.high < 1.0
    assert found.verdict == "not enough to decide"
    assert "too few trajectories" in found.remarks


def test_one_trajectory_has_a_ratio_and_no_interval(grid):
    """A first look is allowed; a word is not."""
    found = compare(replace(grid, trajectories=("T1",)).of("a", better).of("b", plain).rows, "a", "b", ERROR)
    assert found.gmr == pytest.approx(0.8)
    assert found.interval_new_motions is None
    assert found.bca is None
    assert found.verdict == "not enough to decide"


def test_a_failed_run_costs_the_fail_value_and_ranks_last(grid):
    """0.5 m against 15 mm: diverging must never pay, however good the other runs."""
    gone = {("T1", 1.5, 0): "failed"}
    found = compare(grid.of("a", except_where(better, gone)).of("b", plain).rows, "a", "b", ERROR)
    healthy = compare(grid.of("a", better).of("b", plain).rows, "a", "b", ERROR)
    cost = math.log(0.5 / better("T1", 1.5, 0)) / (2 * 2 * 8)
    assert found.gmr == pytest.approx(healthy.gmr * math.exp(cost))
    assert found.failures == (1, 0)
    assert found.win_rate == pytest.approx(31.0 / 32.0)


def test_many_failures_take_the_headline_from_the_ratio(grid):
    """Beyond 5 % the ratio is a statement about the fail value."""
    gone = {("T1", 1.5, 0): "failed", ("T2", 1.5, 0): "failed"}
    found = compare(grid.of("a", except_where(better, gone)).of("b", plain).rows, "a", "b", ERROR)
    assert found.headline == "prob_improvement"
    assert any("probability of improvement" in remark for remark in found.remarks)


def test_a_value_with_a_sample_not_finite_is_a_failure(grid):
    """A run that reported ok and logged NaN did not track."""
    table = grid.of("a", better).of("b", plain)
    spoilt = table.row("a", "T1", 1.5, 0, float("nan"), status="failed")
    rows = [spoilt if (row.controller, row.key) == ("a", spoilt.key) else row for row in table.rows]
    assert compare(rows, "a", "b", ERROR).failures == (1, 0)


def test_without_a_fail_value_failures_leave_the_ratio_and_are_named(grid):
    """No torque chatter stands for a run that never finished."""
    table = replace(grid, metric="torque_rate_rms")
    gone = {("T1", 1.5, 0): "failed"}
    found = compare(table.of("a", except_where(better, gone)).of("b", plain).rows, "a", "b", "torque_rate_rms")
    assert found.without_ratio == (("T1", 1.5, "", 0),)
    assert (found.n_pairs, found.runs, found.failures) == (31, 32, (1, 0))


def test_refused_pairs_are_left_out_and_counted(grid):
    """A refusal is no failure: nothing ran."""
    out = {("T1", 1.5, 0): "refused", ("T3", 2.5, 1): "refused"}
    found = compare(grid.of("a", better).of("b", except_where(plain, out)).rows, "a", "b", ERROR)
    assert (found.refused, found.n_pairs, found.failures) == (2, 30, (0, 0))


def test_a_run_without_a_partner_is_named(grid):
    """A comparison of different runs is none; which ones are missing must be readable."""
    rows = [
        r for r in grid.of("a", better).of("b", plain).rows if (r.controller, r.key) != ("b", ("T2", 2.5, "sand", 1))
    ]
    found = compare(rows, "a", "b", ERROR)
    assert found.unpaired == (("T2", 2.5, "sand", 1),)
    assert found.n_pairs == 31


def test_a_missing_or_undefined_value_has_no_ratio(grid):
    """Neither zero nor the fail value may stand in."""
    table = grid.of("a", better).of("b", plain)
    unknown = table.row("a", "T1", 1.5, 0, float("nan"), status="undefined")
    rows = [unknown if (row.controller, row.key) == ("a", unknown.key) else row for row in table.rows]
    assert compare(rows, "a", "b", ERROR).without_ratio == (unknown.key,)
    with pytest.raises(NothingToCompare, match="no pair of runs"):
        compare(table.rows, "a", "b", ERROR, window="steady")


def test_bounds_enter_and_are_counted(grid):
    """A lag of at least 200 ms is used as 200 ms, with a remark."""
    table = grid.of("a", better).of("b", plain)
    bound = table.row("a", "T1", 1.5, 0, 0.2, status="censored")
    rows = [bound if (row.controller, row.key) == ("a", bound.key) else row for row in table.rows]
    found = compare(rows, "a", "b", ERROR)
    assert found.censored == 1
    assert "1 values are bounds only" in found.remarks


def test_zeros_are_raised_to_a_floor_and_counted(grid):
    """A zero has no logarithm; with noise it cannot happen, so the reader is told."""
    found = compare(grid.of("a", lambda *_: 0.0).of("b", plain).rows, "a", "b", ERROR)
    assert math.isfinite(found.gmr)
    assert found.floored == 32


def test_an_early_tool_is_no_better_than_a_late_one(grid):
    """Signed metrics are compared by magnitude."""
    table = replace(grid, metric="time_lag")
    rows = table.of("a", lambda *run: -plain(*run)).of("b", plain).rows
    assert compare(rows, "a", "b", "time_lag").gmr == 1.0


def test_where_higher_is_better_a_ratio_above_one_wins(grid):
    """A margin to a joint limit is good."""
    table = replace(grid, metric="position_limit_margin_min")
    found = compare(table.of("a", better).of("b", plain).rows, "a", "b", "position_limit_margin_min")
    assert found.gmr < 1.0
    assert found.verdict == "worse"
    assert found.prob_improvement == 0.0


def test_a_metric_without_a_direction_has_no_verdict(grid):
    """The share of lag describes; it praises nobody."""
    table = replace(grid, metric="lag_share")
    found = compare(table.of("a", better).of("b", plain).rows, "a", "b", "lag_share")
    assert found.verdict == "not enough to decide"
    assert "no direction of this metric is better" in found.remarks


@pytest.fixture
def decided(grid):
    """A comparison with a clear word, to bend one number at a time."""
    return compare(grid.of("a", better).of("b", plain).rows, "a", "b", ERROR)


def test_an_interval_that_contains_one_decides_nothing(decided):
    """Not even if it only touches."""
    assert decide(replace(decided, interval_new_motions=Interval(0.7, 1.0, 0.95, "t"))) == "not enough to decide"


def test_a_clear_loss_is_worse(decided):
    """The same rule on the other side."""
    lost = replace(decided, gmr=1.3, ratio_of_means=1.3, interval_new_motions=Interval(1.1, 1.5, 0.95, "t"))
    assert decide(lost) == "worse"


def test_averages_that_disagree_decide_nothing(decided):
    """If the paper's percentage points the other way, the answer depends on the average used."""
    torn = replace(decided, ratio_of_means=1.1)
    assert decide(torn) == "not enough to decide"
    assert "depends on the average used" in torn.remarks


def test_a_small_but_certain_difference_is_practically_equal(decided):
    """Decided and unimportant are two different words."""
    small = replace(decided, gmr=0.98, interval_new_motions=Interval(0.96, 0.99, 0.95, "t"))
    assert decide(small) == "better"
    assert small.remarks == ("practically equal",)


def test_a_large_family_needs_more_trajectories(decided):
    """Eight trajectories decide for at most six opponents."""
    assert decide(replace(decided, family=6)) == "better"
    assert decide(replace(decided, family=7)) == "not enough to decide"


def test_a_recovery_in_no_time_counts_as_one_tick(grid):
    """A zero has no logarithm, and a floor of a nanosecond would make a ratio of a thousand millions out of it."""
    row = grid.row("a", "T1", 1.5, 0, 0.01)
    for stored, counted in ((0.0, 1e-3), (2.5, 2.5)):
        entry = {"value": stored, "unit": "s", "status": "ok"}
        own = replace(row, metrics={"run": {"recovery_time_settled": entry}})
        assert read(own, METRICS["recovery_time_settled"], "run") == Reading(counted, "ok")


def test_what_holm_takes_back_is_undecided_in_its_family(decided):
    """An interval knows nothing of the other opponents; the corrected p value does."""
    assert decide(replace(decided, family=3, p_holm=0.05)) == "better"
    taken_back = replace(decided, family=3, p_holm=0.051)
    assert decide(taken_back) == "not enough to decide"
    assert "not after the correction for all opponents" in taken_back.remarks


def test_a_family_is_corrected_by_holm(grid):
    """All opponents of one reference on one metric; the better one is still found."""
    rows = grid.of("a", better).of("b", plain).of("c", noisy(plain, 0.3)).rows
    family = compare_all(rows, "b", ERROR)
    assert list(family) == ["a", "c"]
    assert family["a"].family == 2
    assert family["a"].p_holm == pytest.approx(2.0 * 0.0078125)
    assert family["a"].verdict == "better"
    assert family["c"].p_holm >= family["c"].p_sign_flip


def test_a_controller_that_shares_nothing_is_left_out_of_the_family(grid):
    """It must not make the others' correction stricter."""
    elsewhere = replace(grid, trajectories=("X1",)).of("d", plain).rows
    assert list(compare_all([*grid.of("a", better).of("b", plain).rows, *elsewhere], "b", ERROR)) == ["a"]


def test_two_runs_for_one_key_are_ambiguous(grid):
    """Rows of two plants or tiers must not be mixed into one table."""
    table = grid.of("a", better).of("b", plain)
    with pytest.raises(AmbiguousRuns, match="more than one run"):
        compare([*table.rows, table.rows[0]], "a", "b", ERROR)


def test_an_unknown_metric_is_named(grid):
    """With its nearest neighbour."""
    with pytest.raises(UnknownMetric, match="tcp_position_error_mean"):
        compare(grid.of("a", better).of("b", plain).rows, "a", "b", "tcp_position_error_men")


def test_the_order_of_rows_changes_nothing(grid):
    """A store returns rows as they were finished."""
    rows = list(grid.of("a", noisy(better, 0.1)).of("b", noisy(plain, 0.1, 1)).rows)
    before = compare(rows, "a", "b", ERROR)
    np.random.default_rng(0).shuffle(rows)
    assert compare(rows, "a", "b", ERROR) == before
