"""Laws of the summary of one metric over a grid of runs."""

from dataclasses import replace

import pytest
from torquebench.evaluation import UnknownMetric, summary

ERROR = "tcp_position_error_mean"
PLACE = {f"T{i}": i for i in range(1, 9)}


def by_place(trajectory, mass, repetition):
    """An error that grows with the trajectory's number and the mass, and scatters by 1 mm between repetitions."""
    return 0.01 * PLACE[trajectory] + 0.001 * mass + 0.001 * repetition


def test_means_are_over_cells(grid):
    """4.5 cm of path, 2 mm of mass, half a millimetre of scatter."""
    found = summary(grid.of("a", by_place).rows, ERROR)["a"]
    assert found.mean == pytest.approx(0.045 + 0.002 + 0.0005)
    assert found.by_trajectory["T3"] == pytest.approx(0.030 + 0.002 + 0.0005)
    assert found.by_mass[2.5] - found.by_mass[1.5] == pytest.approx(0.001)
    assert found.unit == "m"


def test_a_cell_with_more_repetitions_weighs_no_more(grid):
    """Runs that were repeated must not pull the mean to their cell."""
    rows = [r for r in grid.of("a", lambda t, m, r: 0.01 * PLACE[t]).rows if r.trajectory != "T8" or r.repetition == 0]
    assert summary(rows, ERROR)["a"].mean == pytest.approx(0.045)


def test_the_shape_range_is_within_a_group(grid):
    """Slow and fast paths are different questions: T1 to T5, T6 to T8."""
    found = summary(grid.of("a", by_place).rows, ERROR)["a"].by_group
    assert found["slow"].value == pytest.approx(0.04)
    assert (found["slow"].largest, found["slow"].smallest) == ("T5", "T1")
    assert found["fast"].value == pytest.approx(0.02)
    assert found["fast"].interval.contains(0.02)


def test_failures_come_first_and_cost_the_fail_value(grid):
    """The mean without them is shown as biased, beside it."""
    flat = lambda t, m, r: "failed" if (t, r) == ("T1", 0) else 0.01  # noqa: E731
    found = summary(grid.of("a", flat).rows, ERROR)["a"]
    assert (found.runs, found.failures) == (32, 2)
    assert found.failure_rate.contains(2.0 / 32.0)
    assert found.mean == pytest.approx(0.01 + (0.5 - 0.01) * 2.0 / 32.0)
    assert found.survivors_mean == pytest.approx(0.01)


def test_refused_runs_are_no_runs(grid):
    """They enter no rate and no mean."""
    some = lambda t, m, r: "refused" if t == "T1" else 0.01  # noqa: E731
    found = summary(grid.of("a", some).rows, ERROR)["a"]
    assert (found.runs, found.refused, found.failures) == (28, 4, 0)
    assert "T1" not in found.by_trajectory


def test_a_controller_that_never_ran_has_no_mean(grid):
    """Its row stays, without numbers."""
    found = summary(grid.of("a", lambda *_: "refused").rows, ERROR)["a"]
    assert found.mean is None
    assert found.failure_rate is None
    assert found.by_group == {}


def test_a_metric_without_a_fail_value_has_survivors_only(grid):
    """And says how many runs are not in the mean."""
    table = replace(grid, metric="torque_rate_rms")
    found = summary(table.of("a", lambda t, m, r: "failed" if t == "T1" else 30.0).rows, "torque_rate_rms")["a"]
    assert found.mean == found.survivors_mean == pytest.approx(30.0)
    assert found.without_value == found.failures == 4


def test_controllers_keep_the_order_of_the_rows(grid):
    """And none is lost."""
    rows = grid.of("b", by_place).of("a", by_place).rows
    assert list(summary(rows, ERROR)) == ["b", "a"]


def test_a_window_nobody_computed_has_no_mean(grid):
    """One-lap runs have no steady window."""
    found = summary(grid.of("a", by_place).rows, ERROR, window="steady")["a"]
    assert found.mean is None
    assert found.without_value == 32


def test_an_unknown_metric_is_named(grid):
    """Before anything is read."""
    with pytest.raises(UnknownMetric):
        summary(grid.of("a", by_place).rows, "nothing_like_it")
