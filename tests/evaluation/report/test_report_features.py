"""Tables of features: what they average, what they leave out, and who is in them."""

import csv
from dataclasses import replace

import pytest
from torquebench.evaluation.metrics import METRICS
from torquebench.evaluation.report.feature_tables import FEATURES
from torquebench.evaluation.report.numbers import capitalised

SIGNED, OWN = "along_track_error_mean", "jerk_of_my_own"


def put(shelf, mass, values, repetition=0, controller="computed_torque"):
    run = shelf.specification(controller, "none", "T1", mass, repetition=repetition)
    result = shelf.result(run, 1e-3, "slow")
    entries = {name: {"value": value, "unit": "m", "status": "ok"} for name, value in values.items()}
    shelf.put(run, replace(result, metrics={"run": {**result.metrics["run"], **entries}}))


def column(page, table, title):
    """Return a column of a table's CSV by controller."""
    with (page.files.tables / f"{table}.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    name = next(key for key in rows[0] if key.startswith(title))
    return {row["Controller / knowledge"]: row[name] for row in rows}


def test_every_metric_of_a_feature_is_registered_and_stands_in_one_table():
    """A column that nobody computes would be empty for ever; two of one metric would say the same twice."""
    names = [name for feature in FEATURES for name in feature.metrics]
    assert len(names) == len(set(names))
    assert all(METRICS[name].kind == "log" for name in names)


def test_a_mean_is_over_cells_and_keeps_its_sign(shelf):
    """Three repetitions of one load weigh as much as one of the other; behind the plan is negative."""
    for repetition in range(3):
        put(shelf, 1.5, {SIGNED: -0.004}, repetition)
    put(shelf, 2.5, {SIGNED: 0.001})
    found = column(shelf.report(), "w1-tracking", capitalised(METRICS[SIGNED].label))
    assert float(found["computed_torque / none"]) == pytest.approx(-1.5)


def test_a_failed_run_is_in_no_mean_of_a_feature(shelf):
    """It has no value, and the note says that the means are of those that finished."""
    put(shelf, 1.5, {SIGNED: -0.004})
    shelf.fail(shelf.specification("computed_torque", "none", "T2", 1.5))
    page = shelf.report()
    assert float(
        column(page, "w1-tracking", capitalised(METRICS[SIGNED].label))["computed_torque / none"]
    ) == pytest.approx(-4.0)
    assert "means of runs that finished" in page.html


def test_metrics_of_plug_ins_have_a_table_of_their_own(shelf):
    """Who wrote a metric wants to see it beside the others, whoever has no value for it."""
    put(shelf, 1.5, {OWN: 0.25})
    put(shelf, 1.5, {}, controller="pid")
    page = shelf.report()
    assert float(column(page, "w1-plug-ins", OWN)["computed_torque / none"]) == pytest.approx(250.0)
    assert column(page, "w1-plug-ins", OWN)["pid / none"].endswith("undefined")


def test_a_feature_without_a_value_has_no_table(quick):
    """Old rows know nothing of the tool's velocity."""
    assert "Velocity tracking" not in quick.html
    assert not (quick.files.tables / "w1-velocity.csv").exists()
