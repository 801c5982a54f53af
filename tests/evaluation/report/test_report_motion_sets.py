"""Old and new motions apart on the page: a table of their own, an interval of their own."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from torquebench.evaluation import MOTION_SETS

SCALES = {("flexiv_factory", "none"): 17.2e-3, ("computed_torque", "none"): 3.1e-3, ("compliant", "none"): 17.0e-3}


@pytest.fixture(scope="module")
def both(tmp_path_factory, shelf_class):
    """Three controllers on all twenty-four motions with two loads."""
    shelf = shelf_class(tmp_path_factory.mktemp("both") / "store")
    return shelf.grid(SCALES, MOTION_SETS["extended"], (1.5, 3.5)).campaign().report()


def test_each_set_has_means_ratios_and_intervals_of_its_own(both):
    """For programs and on the page: eight, sixteen and twenty-four trajectories."""
    sets = both.summary["worlds"][0]["motion_sets"]
    assert list(sets) == ["extended", "further", "paper"]
    found = {
        name: next(c for c in entries if c["controller"] == "computed_torque / none") for name, entries in sets.items()
    }
    assert {name: entry["n_trajectories"] for name, entry in found.items()} == {
        "paper": 8,
        "further": 16,
        "extended": 24,
    }
    intervals = [entry["interval_new_motions"] for entry in found.values()]
    assert len({(interval["low"], interval["high"]) for interval in intervals}) == 3
    for subject in ("position", "orientation"):
        assert f'id="w1-motion-sets-{subject}"' in both.html
    for title in ("T1 to T8", "M1 to M16", "All 24 motions"):
        assert f'<th colspan="3" scope="colgroup">{title}</th>' in both.html


def test_the_ratio_over_all_lies_between_those_of_the_sets(both):
    """Twenty-four logs average eight and sixteen."""
    sets = both.summary["worlds"][0]["motion_sets"]
    ratio = {
        name: next(c["gmr"] for c in entries if c["controller"] == "computed_torque / none")
        for name, entries in sets.items()
    }
    assert ratio["extended"] == pytest.approx(ratio["paper"] ** (8 / 24) * ratio["further"] ** (16 / 24), rel=1e-9)


def test_a_campaign_on_the_papers_motions_alone_has_no_such_table(quick):
    """Nothing to tell apart."""
    assert quick.summary["worlds"][0]["motion_sets"] == {}
    assert "w1-motion-sets" not in quick.html


def test_new_over_old_is_of_the_loads_that_both_ran_with(tmp_path, shelf_class):
    """The new motions ran empty and heavy, the old ones in between too: the cells in between have no counterpart."""
    shelf = shelf_class(tmp_path / "store")
    shelf.grid(SCALES, MOTION_SETS["paper"], (1.5, 2.5, 3.5)).grid(SCALES, MOTION_SETS["further"], (1.5, 3.5))
    shelf.fail(replace(shelf.specification("compliant", "none", "M11", 1.5), repetition=1))
    page = shelf.campaign().report()
    logs = {name: [] for name in ("T", "M")}
    for row in csv.DictReader(page.files.runs.open(encoding="utf-8")):
        if row["controller"] == "computed_torque" and row["mass [kg]"] != "2.5":
            logs[row["trajectory"][0]].append(np.log(float(row["run.tcp_position_error_mean [m]"])))
    table = (page.files.tables / "w1-motion-sets-position.csv").read_text(encoding="utf-8")
    last = {row[0]: row[-1] for row in csv.reader(table.splitlines()) if row}
    assert float(last["computed_torque / none"]) == pytest.approx(np.exp(np.mean(logs["M"]) - np.mean(logs["T"])), 5e-3)
    assert last["compliant / none"] == "\N{EMPTY SET} a run failed"
