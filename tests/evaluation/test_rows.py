"""Laws of reading one metric from a run: what a failure, a refusal and a gap count as."""

import math
from dataclasses import FrozenInstanceError

import pytest
from torquebench.evaluation import METRICS, AmbiguousRuns
from torquebench.evaluation.pairing import FLOOR, Ratios
from torquebench.evaluation.rows import Reading, find_metric, read, runs_by_key

POSITION, CHATTER, MARGIN = (
    METRICS[name] for name in ("tcp_position_error_mean", "torque_rate_rms", "position_limit_margin_min")
)


@pytest.fixture
def run(grid):
    """Return a maker of single runs."""
    return lambda outcome, status="ok": grid.row("a", "T1", 2.5, 0, outcome, status=status)


def test_a_run_belongs_to_its_cell_and_repetition(run):
    """The key pairs runs, the cell averages them."""
    assert run(0.01).cell == ("T1", 2.5, "sand")
    assert run(0.01).key == ("T1", 2.5, "sand", 0)


def test_a_run_cannot_be_changed(run):
    """Rows cross from the store to the page as they are."""
    with pytest.raises(FrozenInstanceError):
        run(0.01).mass = 3.0


def test_a_value_is_read_with_its_status(run):
    """The plain case."""
    assert read(run(0.018), POSITION, "run") == Reading(0.018, "ok")


def test_a_failed_run_is_worth_the_fail_value(run):
    """Half a metre, whatever the truncated log says."""
    assert read(run("failed"), POSITION, "run") == Reading(0.5, "failed")


def test_a_failed_run_is_worth_nothing_where_there_is_no_fail_value(run):
    """It stays a failure and ranks last."""
    reading = read(run("failed"), CHATTER, "run")
    assert reading == Reading(None, "failed")
    assert reading.rank(CHATTER) == math.inf


def test_a_refused_run_is_worth_nothing(run):
    """It never ran."""
    assert read(run("refused"), POSITION, "run") == Reading(None, "refused")


def test_a_window_or_metric_that_nobody_computed_is_missing(run):
    """Not zero."""
    assert read(run(0.01), POSITION, "steady").status == "missing"
    assert read(run(0.01), CHATTER, "run").status == "missing"


@pytest.mark.parametrize("stored", [None, math.nan, math.inf])
def test_a_stored_gap_is_undefined(run, stored):
    """JSON has no NaN, so a store may keep null."""
    assert read(run(stored), POSITION, "run") == Reading(None, "undefined")


def test_a_sign_is_dropped(run):
    """Ratios and ranks are of magnitudes."""
    assert read(run(-0.02), POSITION, "run").magnitude == 0.02


def test_ranks_follow_the_metrics_direction():
    """Lower ranks are better for errors and margins alike."""
    small, large = Reading(0.1, "ok"), Reading(0.2, "ok")
    assert small.rank(POSITION) < large.rank(POSITION) < math.inf
    assert large.rank(MARGIN) < small.rank(MARGIN) < math.inf


def test_the_runs_of_one_controller_come_in_the_order_of_their_keys(grid):
    """A store returns them as they finished."""
    rows = grid.of("b", lambda *_: 1.0).of("a", lambda *_: 1.0).rows[::-1]
    found = runs_by_key(rows, "a")
    assert list(found) == sorted(found)
    assert {row.controller for row in found.values()} == {"a"}


def test_the_same_run_twice_is_refused(run):
    """Averaging two plants would be silent."""
    with pytest.raises(AmbiguousRuns):
        runs_by_key([run(0.01), run(0.02)], "a")


def test_a_metric_is_found_by_its_id():
    """In the table that was passed."""
    assert find_metric("torque_rate_rms") is CHATTER
    assert find_metric("own", {"own": POSITION}) is POSITION


def test_a_trajectory_is_a_mean_of_cells_not_of_runs():
    """A cell with more repetitions weighs no more."""
    pairs = {("T1", 1.5, "", r): (2.0, 1.0) for r in range(9)} | {("T1", 2.5, "sand", 0): (0.5, 1.0)}
    assert Ratios(pairs).by_trajectory() == pytest.approx([0.0])


def test_each_side_keeps_its_own_cell_means():
    """The ratio of means is of these."""
    pairs = {("T1", 1.5, "", 0): (1.0, 4.0), ("T1", 1.5, "", 1): (3.0, 6.0), ("T2", 1.5, "", 0): (5.0, 8.0)}
    assert Ratios(pairs).cell_means(0) == [2.0, 5.0]
    assert Ratios(pairs).cell_means(1) == [5.0, 8.0]


def test_two_zeros_are_equal():
    """Both never clipped: ratio 1, at the floor."""
    assert Ratios({("T1", 1.5, "", 0): (0.0, 0.0)}).by_trajectory() == pytest.approx([0.0])
    assert Ratios({("T1", 1.5, "", 0): (1.0, 0.0)}).by_trajectory() == pytest.approx([math.log(1.0 / FLOOR)])


def test_pairs_without_a_magnitude_have_no_ratio():
    """Either side may lack it."""
    there, gone = Reading(1.0, "ok"), Reading(None, "undefined")
    readings = {
        ("T1", 1.5, "", 0): (there, gone),
        ("T1", 1.5, "", 1): (gone, there),
        ("T1", 1.5, "", 2): (there, there),
    }
    assert list(Ratios.of(readings).pairs) == [("T1", 1.5, "", 2)]


def test_the_suite_interval_weighs_trajectories_alike():
    """The same mean as the headline, so the interval lies around it: here two cells against one."""
    logs = {("T1", 1.5, "", 0): 1.0, ("T1", 1.5, "", 1): 1.2, ("T1", 2.5, "", 0): 2.0, ("T1", 2.5, "", 1): 2.2}
    logs |= {("T2", 1.5, "", 0): 5.0, ("T2", 1.5, "", 1): 5.2}
    ratios = Ratios({key: (math.exp(value), 1.0) for key, value in logs.items()})
    interval = ratios.suite_interval()
    assert math.log(interval.low * interval.high) / 2.0 == pytest.approx(ratios.by_trajectory().mean())
