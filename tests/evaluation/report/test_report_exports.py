"""The report for programs: every run is a row that can be found again, and every word in it has one meaning."""

import csv
import io
import json
import math
from dataclasses import replace

import pytest
from torquebench.evaluation.metrics import METRICS
from torquebench.evaluation.report.exports import SPECIFICATION, comparisons_csv, runs_csv, summary_json
from torquebench.evaluation.report.findings import COMPARED, find_all
from torquebench.evaluation.report.panels import Panels
from torquebench.evaluation.report.worlds import worlds_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.store import Store

STEP = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (6.0, Payload(mass=3.5, material="sand"))))


def found_in(shelf):
    """Return the findings of a shelf as the report takes them."""
    shelf.store.close()
    with Store.read(shelf.folder) as store:
        return find_all(worlds_of(store.runs(), store.campaigns()))


def rows_of(text):
    """Return the rows of a CSV text."""
    return list(csv.DictReader(io.StringIO(text)))


@pytest.fixture
def small(shelf):
    """Two controllers on two motions with one load; one run of one of them failed, and a law with a comma in it."""
    shelf.grid({("flexiv_factory", "none"): 17e-3, ("computed_torque", "oracle"): 1e-3}, ("T1", "T2"), (1.5,))
    shelf.fail(shelf.specification("computed_torque", "oracle", "T3"))
    odd = shelf.specification("law, the second", "none", "T1", settings={"gain": 2.0, "note": 'a "b"'})
    shelf.put(odd, shelf.result(odd, 5e-3, "slow"))
    return shelf.campaign()


def test_every_row_of_the_store_is_a_row_of_the_file(small):
    """Failed ones too: a file without them would be a table of survivors."""
    addresses = [run.address for run in small.store.runs()]
    rows = rows_of(runs_csv(found_in(small)))
    assert sorted(row["address"] for row in rows) == sorted(addresses)
    assert [row["status"] for row in rows].count("failed") == 1


def test_a_row_says_what_was_run_and_can_be_run_again(small):
    """The fields of the specification as they are, settings as JSON, commas and quotes survived."""
    row = next(row for row in rows_of(runs_csv(found_in(small))) if row["controller"] == "law, the second")
    assert json.loads(row["settings"]) == {"gain": 2.0, "note": 'a "b"'}
    assert (row["trajectory"], row["plant"], row["tier"], row["mass [kg]"]) == ("T1", "pybullet", "actuated", "1.5")
    assert set(SPECIFICATION) <= set(row)
    assert row["load"] == "1.5 kg"


def test_a_failed_run_has_its_reason_and_its_time_instead_of_values(small):
    """Empty cells for metrics, never a zero."""
    row = next(row for row in rows_of(runs_csv(found_in(small))) if row["status"] == "failed")
    assert (row["cause"], row["failed_at [s]"]) == ("divergence", "2.125")
    assert row["reason"] == "joint 4 is 1.02 rad from its plan"
    assert {row[name] for name in row if name.startswith("run.")} == {""}


def test_metric_columns_carry_their_unit_and_stand_in_the_registrys_order(small):
    """Whoever reads the file with other columns next year finds the old ones where they were."""
    header = next(csv.reader(io.StringIO(runs_csv(found_in(small)))))
    columns = [name for name in header if name.startswith("run.")]
    ids = [name.partition(".")[2].partition(" ")[0] for name in columns]
    assert ids == [name for name in METRICS if name in ids]
    assert all(name.endswith(f"[{METRICS[metric].unit}]") for name, metric in zip(columns, ids, strict=True))


def test_a_metric_of_a_plug_in_comes_after_those_that_ship(small):
    """Its column is there with its own unit; nothing that ships moved for it."""
    run = small.specification("flexiv_factory", "none", "T4")
    result = small.result(run, 1e-2, "slow")
    own = {"value": 3.25, "unit": "dB", "status": "ok", "n": 5}
    small.put(run, replace(result, metrics={"run": {"a_loudness": own, **result.metrics["run"]}}))
    rows = rows_of(runs_csv(found_in(small)))
    columns = [name for name in rows[0] if name.startswith("run.")]
    assert columns[-1] == "run.a_loudness [dB]"
    assert sorted(row[columns[-1]] for row in rows) == ["", "", "", "", "", "", "3.25"]


@pytest.mark.parametrize(
    ("value", "status", "word"),
    [
        (math.inf, "censored", "censored"),
        (math.nan, "failed", "failed"),
        (None, "undefined", "undefined"),
        (0.25, "ok", "0.25"),
    ],
)
def test_where_there_is_no_number_there_is_its_word(small, value, status, word):
    """A program that averages the column stumbles over it, as it should."""
    run = small.specification("flexiv_factory", "none", "T5")
    result = small.result(run, 1e-2, "slow")
    lag = {"value": value, "unit": "s", "status": status, "n": 5}
    small.put(run, replace(result, metrics={"run": {**result.metrics["run"], "time_lag": lag}}))
    rows = {row["trajectory"]: row for row in rows_of(runs_csv(found_in(small))) if row["label"].startswith("flexiv")}
    assert rows["T5"]["run.time_lag [s]"] == word


def test_twins_are_rows_with_their_role(shelf):
    """They are in no comparison; who computes one from the file leaves them out by their role."""
    run = replace(shelf.specification("flexiv_factory", "none"), schedule=STEP, twins=True)
    result = shelf.result(run, 1e-2, "slow")
    roles = ("run", "constant 1.5 kg", "constant 3.5 kg sand")
    shelf.put(run, *(replace(result, role=role) for role in roles))
    rows = rows_of(runs_csv(found_in(shelf.campaign())))
    assert sorted(row["role"] for row in rows) == sorted(roles)
    assert {row["load"] for row in rows} == {"1.5 kg, from 6 s 3.5 kg sand"}


def test_wall_times_stand_apart_by_their_prefix(small):
    """They belong to a machine, not to a result: two machines' files differ in these columns only."""
    found = found_in(small)
    header = next(csv.reader(io.StringIO(runs_csv(found))))
    timings = [name for name in header if name.startswith("timing.")]
    assert timings == sorted(timings) and header[-len(timings) :] == timings
    assert "timing.call_us_median" in timings


def test_a_comparison_is_one_row_of_plain_values(small):
    """Intervals as two columns, counts instead of lists: nothing has to be parsed twice."""
    rows = rows_of(comparisons_csv(found_in(small)))
    assert {row["reference"] for row in rows} == {"flexiv_factory / none"}
    assert {row["metric"] for row in rows} <= set(COMPARED)
    for row in rows:
        assert not set("{}[]") & set("".join(row[name] or "" for name in row if name not in ("remarks", "controller")))
        low, gmr, high = (row["interval_new_motions.low"], row["gmr"], row["interval_new_motions.high"])
        assert low == "" or float(low) <= float(gmr) <= float(high)


def test_a_store_without_a_comparison_has_a_header(shelf):
    """An empty file would look like one that was cut off."""
    shelf.grid({("flexiv_factory", "none"): 17e-3}, ("T1",), (1.5,))
    assert comparisons_csv(found_in(shelf.campaign())) == "world,controller,reference,metric,window\n"


def test_a_summary_is_the_same_text_each_time_and_holds_every_world(small):
    """Sorted keys: two summaries can be compared line by line."""
    found = found_in(small)
    panels = [Panels() for _ in found]
    text = summary_json(found, panels, [{"seed": 1}], None)
    assert text == summary_json(found, panels, [{"seed": 1}], None)
    content = json.loads(text)
    assert len(content["worlds"]) == len(found) == 1
    assert content["campaigns"] == [{"seed": 1}]
    assert text == json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def test_a_summary_has_no_word_that_json_does_not_know(small):
    """Infinity and NaN are null: half of all parsers refuse the file otherwise."""
    text = summary_json(
        found_in(small), [Panels()], [{"a": math.nan, "b": [math.inf, {"c": (-math.inf,)}], 3: 1}], None
    )
    assert json.loads(text)["campaigns"] == [{"a": None, "b": [None, {"c": [None]}], "3": 1}]


def test_a_setting_that_differed_from_run_to_run_keeps_all_its_values(small):
    """A gain that was computed for each motion is a list of texts, not that of the first run."""
    for trajectory, value in (("T4", 10.0), ("T5", 30.0)):
        run = small.specification("tuned_law", "none", trajectory)
        entry = {"setting": "gain", "value": value, "source": "rule", "note": "", "trials": 0, "learnt_before": ""}
        small.put(run, replace(small.result(run, 1e-3, "slow"), ledger=[entry]))
    (world,) = json.loads(summary_json(found_in(small), [Panels()], [], None))["worlds"]
    (gain,) = world["controllers"]["tuned_law / none"]["ledger"]
    assert [json.loads(value) for value in gain["value"]] == [10.0, 30.0]
