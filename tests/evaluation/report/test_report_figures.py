"""Figures of the page: equal to what runs.csv gives anyone who computes them again."""

import csv
import json
import math
from collections import defaultdict
from statistics import fmean

import pytest

REFERENCE = "flexiv_factory / none"
POSITION = "run.tcp_position_error_mean"


@pytest.fixture(scope="module")
def rows(quick):
    with quick.files.runs.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def means_of(rows, label, column, fail_value=None):
    """Mean over cells of the mean over repetitions, a failed run counted as the metric's cost."""
    cells = defaultdict(list)
    for row in rows:
        if row["label"] == label and row["status"] != "refused":
            value = fail_value if row["status"] == "failed" else float(row[column])
            if value is not None:
                cells[row["trajectory"], row["mass [kg]"], row["material"]].append(abs(value))
    return {cell: fmean(values) for cell, values in cells.items()}


@pytest.mark.parametrize(
    ("metric", "unit", "fail_value"),
    [
        ("tcp_position_error_mean", "m", 0.5),
        ("tcp_orientation_error_mean", "rad", math.pi),
        ("joint_error_mean", "rad", 3.0),
        ("tcp_position_error_last_lap", "m", 0.5),
        ("time_lag", "s", None),
        ("contour_error_mean", "m", 0.5),
        ("torque_rate_rms", "N m/s", None),
        ("clip_fraction", "1", None),
        ("torque_rate_clip_fraction", "1", None),
    ],
)
def test_every_mean_is_that_of_the_rows(quick, rows, metric, unit, fail_value):
    for label, controller in quick.summary["worlds"][0]["controllers"].items():
        stated = controller["metrics"][f"run.{metric}"]
        cells = means_of(rows, label, f"run.{metric} [{unit}]", fail_value)
        assert stated["unit"] == unit
        if label == "mpc / none":
            assert stated["mean"] is None
        else:
            assert stated["mean"] == pytest.approx(fmean(cells.values()), rel=1e-12)


@pytest.mark.parametrize(
    ("metric", "unit", "fail_value"),
    [("tcp_position_error_mean", "m", 0.5), ("tcp_orientation_error_mean", "rad", math.pi)],
)
def test_every_ratio_and_its_interval_is_that_of_the_rows(quick, rows, metric, unit, fail_value):
    column = f"run.{metric} [{unit}]"
    reference = means_of(rows, REFERENCE, column, fail_value)
    stated = [found for found in quick.summary["worlds"][0]["comparisons"] if found["metric"] == metric]
    assert len(stated) == 4
    for comparison in stated:
        ours = means_of(rows, comparison["controller"], column, fail_value)
        logs = defaultdict(list)
        for cell in ours:
            logs[cell[0]].append(math.log(ours[cell] / reference[cell]))
        paths = [fmean(values) for values in logs.values()]
        mean = fmean(paths)
        error = math.sqrt(sum((path - mean) ** 2 for path in paths) / (len(paths) - 1) / len(paths))
        # Student's 97.5 % point with seven degrees of freedom, from a table.
        limits = [math.exp(mean + sign * 2.364624 * error) for sign in (-1, 1)]
        assert comparison["gmr"] == pytest.approx(math.exp(mean), rel=1e-12)
        interval = comparison["interval_new_motions"]
        assert [interval["low"], interval["high"]] == pytest.approx(limits, rel=1e-5)
        assert comparison["n_trajectories"] == 8


def test_failures_are_counted_as_in_the_rows(quick, rows):
    for label, controller in quick.summary["worlds"][0]["controllers"].items():
        stated = controller["metrics"][POSITION]
        statuses = [row["status"] for row in rows if row["label"] == label]
        assert (stated["failures"], stated["refused"]) == (statuses.count("failed"), statuses.count("refused"))
    assert len(quick.summary["worlds"][0]["failed"]) == 3


def test_a_run_without_a_value_says_why_in_the_csv(rows):
    assert {row["run.lag_share [1]"] for row in rows if row["status"] == "ok"} == {"undefined"}


def test_the_comparisons_file_holds_the_comparisons_of_the_summary(quick):
    with quick.files.comparisons.open(encoding="utf-8", newline="") as stream:
        table = list(csv.DictReader(stream))
    stated = quick.summary["worlds"][0]["comparisons"]
    assert [(row["controller"], row["metric"]) for row in table] == [(c["controller"], c["metric"]) for c in stated]
    assert [float(row["gmr"]) for row in table] == [c["gmr"] for c in stated]


def test_the_best_is_not_declared_best_when_the_second_is_as_good(quick):
    """Two controllers 4 % apart with 12 % scatter: nobody can say which tracks better."""
    first, second = quick.summary["worlds"][0]["sentences"]["tcp_position_error_mean"]
    assert "tracked best" not in first
    assert "not enough to decide" in second


def test_a_clear_winner_is_named_with_ratio_and_interval(shelf):
    scales = {
        ("flexiv_factory", "none"): 17e-3,
        ("computed_torque", "none"): 3e-3,
        ("computed_torque_pid", "none"): 0.4e-3,
    }
    page = shelf.grid(scales).campaign().report()
    first = page.summary["worlds"][0]["sentences"]["tcp_position_error_mean"][0]
    assert first.startswith("computed_torque_pid / none tracked best in position: mean error 0.")
    assert "times lower than flexiv_factory / none (ratio 0.0" in first
    assert "95 % interval over 8 trajectories" in first


def test_a_figure_of_ratios_says_that_not_all_are_over_as_many_motions(shelf):
    """The count of the first controller is not that of all."""
    shelf.grid({("flexiv_factory", "none"): 17e-3, ("computed_torque", "none"): 1e-3})
    html = shelf.grid({("mpc", "none"): 1e-3}, trajectories=("T1", "T2", "T3")).campaign().report().html
    assert "95 % interval over the 3 to 8 trajectories that both ran" in html


def test_the_summary_is_plain_json(quick):
    def refuse(word):
        raise AssertionError(word)

    json.loads(quick.files.summary.read_text(encoding="utf-8"), parse_constant=refuse)
