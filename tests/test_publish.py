"""The published result: its pages are made of its summary, by one script, and name no machine."""

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

RESULTS = Path(__file__).parents[1] / "docs" / "results"
SCRIPT = RESULTS / "publish.py"
PAGES = ("claims.md", "precision.md")


def load_script():
    """Return the script as a module; it belongs to no package."""
    specification = importlib.util.spec_from_file_location("publish", SCRIPT)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


publish = load_script()


def claim(**changes):
    content = {"id": "C1", "claim": "The error is smaller.", "printed": None, "printed_unit": "", "measured": None}
    return content | {"interval": None, "unit": "", "verdict": "reproduced", "reason": ""} | changes


def metric(by_trajectory, *, failures=0, runs=4):
    values = list(by_trajectory.values())
    content = {"mean": sum(values) / len(values), "by_trajectory": by_trajectory, "by_mass": {"1.5": values[0]}}
    return content | {"runs": runs, "failures": failures, "survivors_mean": 0.0, "unit": "m"}


def pair(controller, gmr, low, high):
    interval = {"low": low, "high": high, "status": "ok"}
    return {
        "controller": controller,
        "metric": "tcp_position_error_mean",
        "gmr": gmr,
        "interval_new_motions": interval,
    }


def controller(**errors):
    return {"metrics": {"run.tcp_position_error_mean": metric(errors), "run.energy_net": metric({"T1": 1.0})}}


@pytest.fixture
def summary():
    """A report of three controllers: the reference, one that ran both sets, one that ran new motions and failed."""
    third = {"metrics": {"run.tcp_position_error_mean": metric({"M1": 0.5}, failures=1)}}
    world = {
        "facts": {"Tier": "actuated"},
        "runs": 12,
        "reference": "factory / none",
        "ranking": {},
        "sentences": {},
        "comparisons": [],
        "materials": [],
        "studies": 0,
        "controllers": {
            "mine / none": controller(T1=0.001, T2=0.003, M1=0.004),
            "factory / none": controller(T1=0.010, T2=0.030, M1=0.020),
            "third / oracle": third,
        },
        "motion_sets": {
            "paper": [pair("mine / none", 0.1, 0.05, 0.2)],
            "further": [pair("mine / none", 1.25, None, None), pair("third / oracle", 25.0, 20.0, 30.0)],
        },
    }
    campaign = {"command": "torquebench run paper --out /tmp/some/where/paper --workers 2", "gate": [1], "seed": 1}
    claims = [
        claim(),
        claim(id="C2", printed=1.8, printed_unit="cm", measured=0.017, interval=[0.0128, 0.0211], unit="m"),
        claim(id="C3", measured=0.0031, interval=[None, None], unit="rad/kg", claim="a | b"),
        claim(id="C4", measured=1.7, interval=[1.3, 2.2], unit="ratio"),
        claim(id="C5", measured=0.05, unit="s"),
        claim(id="C6", measured=1.5, unit="s"),
    ]
    return {"schema": 1, "campaigns": [campaign], "claims": claims, "worlds": [world], "metrics": {}}


def written(summary, folder):
    """Return what is published of a summary, by file name."""
    report, published = folder / "report", folder / "published"
    report.mkdir(), published.mkdir()
    (report / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    publish.publish(report, published)
    return {file.name: file.read_text(encoding="utf-8") for file in published.iterdir()}


def cells(page, key):
    """Return the cells of the row of a page that holds a word."""
    (row,) = [line for line in page.splitlines() if line.startswith("|") and key in line]
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]]


def test_what_is_published_is_what_the_script_makes_of_it(tmp_path):
    """A page mended by hand, or figures renewed without their pages, would say two things."""
    published = written(json.loads((RESULTS / "summary.json").read_text(encoding="utf-8")), tmp_path)
    for name in ("summary.json", *PAGES):
        assert published[name] == (RESULTS / name).read_text(encoding="utf-8"), name


def test_the_short_table_of_the_readme_has_rows_of_the_whole_one():
    """A table copied by hand drifts."""
    rows = re.findall(r"^\| `.*$", (RESULTS / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert rows and set(rows) <= set((RESULTS / "precision.md").read_text(encoding="utf-8").splitlines())


@pytest.mark.parametrize("name", ["summary.json", *PAGES])
def test_no_published_file_names_a_folder_of_a_machine(name):
    assert not re.search(r"[\s\"'`=(]/(?:tmp|home|root|work|Users)\b", (RESULTS / name).read_text(encoding="utf-8"))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_published_number_is_rounded_once(number):
    """Half a unit of the sixth digit at most, and rounding what is rounded changes nothing: files come out the same."""
    (once,) = publish._rounded([number])
    assert abs(once - number) <= 5.1e-6 * abs(number) + 1e-320
    assert publish._rounded({"a": once}) == {"a": once}
    assert publish._rounded([3, True, None, "3.14159265"]) == [3, True, None, "3.14159265"]


def test_the_command_names_where_the_results_went_by_the_last_folder_only(summary):
    (campaign,) = publish.shortened(summary)["campaigns"]
    assert campaign == {"command": "torquebench run paper --out results/paper --workers 2", "seed": 1}


def test_publishing_twice_changes_nothing(summary):
    """So the published summary can stand for the report it was made of."""
    once = publish.shortened(summary)
    assert publish.shortened(once) == once


def test_a_shortened_summary_keeps_the_figures_and_drops_the_rest(summary):
    world = publish.shortened(summary)["worlds"][0]
    own = world["controllers"]["mine / none"]["metrics"]
    assert set(own) == {"run.tcp_position_error_mean"} and "studies" not in world
    assert own["run.tcp_position_error_mean"]["by_trajectory"] == {"T1": 0.001, "T2": 0.003, "M1": 0.004}
    assert "survivors_mean" not in own["run.tcp_position_error_mean"]


@pytest.mark.parametrize(
    ("key", "printed", "measured"),
    [
        ("C1 ", "", ""),
        ("C2 ", "1.8 cm", "17 (12.8 to 21.1) mm"),
        ("C3 ", "", "3.1 mrad/kg"),
        ("C4 ", "", "1.7 (1.3 to 2.2)"),
        ("C5 ", "", "50 ms"),
        ("C6 ", "", "1.5 s"),
    ],
)
def test_a_claim_is_told_in_units_that_a_reader_expects(summary, tmp_path, key, printed, measured):
    """Without interval none is shown; a ratio has no unit; a bar in a sentence does not end its cell."""
    row = cells(written(summary, tmp_path)["claims.md"], key)
    assert len(row) == 5 and row[1:3] == [printed, measured]


def test_a_mean_of_a_set_is_over_its_own_motions(summary, tmp_path):
    """T: (1 + 3)/2 mm, M: 4 mm; an interval without ends is not shown; who ran no motion of a set has no figure."""
    page = written(summary, tmp_path)["precision.md"]
    assert cells(page, "mine") == ["`mine / none`", "2.00", "0.10 (0.050 to 0.20)", "4.00", "1.25", "0 of 4"]
    assert cells(page, "| `factory")[1:] == ["20.00", "1 (the reference)", "20.00", "1 (the reference)", "0 of 4"]
    assert cells(page, "third")[1:] == ["", "", "500.00", "25.00 (20.00 to 30.00)", "1 of 4"]


def test_a_world_of_one_set_takes_its_ratios_from_its_comparisons(summary, tmp_path):
    """Where nothing was run on new motions the report splits nothing, and the page has no figure for them."""
    (world,) = summary["worlds"]
    world["comparisons"], world["motion_sets"] = [pair("mine / none", 0.1, 0.05, 0.2)], {}
    world["controllers"] = {"mine / none": controller(T1=0.001), "factory / none": controller(T1=0.010)}
    page = written(summary, tmp_path)["precision.md"]
    assert cells(page, "mine")[1:] == ["1.00", "0.10 (0.050 to 0.20)", "", "", "0 of 4"]
    assert cells(page, "| `factory")[1:] == ["10.00", "1 (the reference)", "", "", "0 of 4"]


def test_rows_stand_by_their_error_and_granted_knowledge_apart(summary, tmp_path):
    page = written(summary, tmp_path)["precision.md"]
    assert re.findall(r"^\| `(\w+) / |^## (\w+)", page, re.MULTILINE) == [
        ("", "Arm"),
        ("mine", ""),
        ("factory", ""),
        ("", "With"),
        ("third", ""),
    ]


def test_a_folder_without_a_report_is_one_line(tmp_path):
    run = subprocess.run([sys.executable, SCRIPT, tmp_path], capture_output=True, text=True)
    assert run.returncode == 1 and run.stderr.startswith("usage: ") and run.stderr.count("\n") == 1
