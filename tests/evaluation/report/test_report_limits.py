"""Known limitations and conformance: what the page says of itself and of the controllers that it compares."""

import csv

import pytest
from torquebench.controllers import Finding
from torquebench.evaluation.report import write_report
from torquebench.evaluation.report.limitations import SENTENCES

SCALES = {("flexiv_factory", "none"): 17e-3, ("cbmc_v3", "none"): 12e-3, ("computed_torque", "oracle"): 1e-3}


def page_of(shelf, **hooks):
    shelf.store.close()
    files = write_report(shelf.folder, **hooks)
    return files, files.index.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("scales", "changes", "there", "absent"),
    [
        (SCALES, {}, ("stand-in", "readings", "told", "nominal"), ("water", "energy", "conventions")),
        ({("pid", "none"): 1e-3}, {"draws": True}, ("simulated", "tier"), ("stand-in", "readings", "told", "nominal")),
    ],
)
def test_a_limit_is_named_where_it_limits_and_nowhere_else(shelf, scales, changes, there, absent):
    """A reader who is warned of everything reads nothing."""
    shelf.grid(scales, masses=(1.5,), **changes)
    _, html = page_of(shelf)
    found = {name for name, text in SENTENCES.items() if text.partition("{")[0].replace("'", "&#39;") in html}
    assert set(there) <= found
    assert not set(absent) & found


def test_each_controller_is_checked_once_and_a_broken_law_is_seen(shelf):
    """One run of each controller and settings is enough; who is not there to be checked says so."""
    shelf.grid(SCALES, masses=(1.5, 2.5))
    asked = []

    def check(run):
        name = run.specification.controller
        asked.append(name)
        if name == "computed_torque":
            return []
        return [
            Finding(check="runs", passed=True),
            Finding(check="keeps no input", passed=name != "cbmc_v3", detail="differs from tick 3"),
        ]

    files, html = page_of(shelf, conformance_of=check)
    assert sorted(asked) == ["cbmc_v3", "computed_torque", "flexiv_factory"]
    with (files.tables / "conformance-table.csv").open(encoding="utf-8", newline="") as stream:
        rows = {row["Controller"]: row for row in csv.DictReader(stream)}
    assert rows["cbmc_v3"]["keeps no input"].endswith("broken") and rows["cbmc_v3"]["runs"].endswith("holds")
    assert rows["computed_torque"]["runs"] == "not checked"
    assert "differs from tick 3" in html


@pytest.mark.parametrize("laps", [(3, 3), (3, 2)], ids=["one world", "two worlds"])
def test_each_setting_of_a_controller_has_its_row_of_checks(shelf, laps):
    """One that keeps the contract must not hide another of the same name that breaks it."""
    for bandwidth, count in zip((20.0, 40.0), laps, strict=True):
        shelf.grid({("computed_torque", "none"): 1e-3}, settings={"bandwidth": bandwidth}, laps=count)

    def check(run):
        return [Finding(check="runs", passed=run.specification.settings["bandwidth"] > 30.0)]

    files, _ = page_of(shelf, conformance_of=check)
    with (files.tables / "conformance-table.csv").open(encoding="utf-8", newline="") as stream:
        rows = {row["Controller"]: row["runs"].split()[-1] for row in csv.DictReader(stream)}
    assert rows == {"computed_torque (bandwidth=20.0)": "broken", "computed_torque (bandwidth=40.0)": "holds"}


def test_without_checks_the_page_says_that_nobody_was_checked(quick):
    """A page that is written elsewhere may know no controller."""
    assert "No controller was there to be checked" in quick.html
