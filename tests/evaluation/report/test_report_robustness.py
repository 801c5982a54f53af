"""Robustness on the page: bounds and flags visible, the worst joint in front, and every run behind a margin."""

import csv
import math
import re
from dataclasses import replace

import pytest
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.perturbation import Perturbation
from torquebench.scenarios.result import RunResult

SAND = LoadSchedule.constant(Payload(mass=2.5, material="sand"))
PROBE = {"perturbation": {"payload": 1.2}, "passed": False, "status": "failed", "cause": "divergence", "reason": "lost"}


def study_of(shelf, controller, study, trajectory="T1"):
    """Return the specification of a study."""
    return replace(shelf.specification(controller, "none", trajectory), schedule=SAND, study=study)


def put_margin(shelf, controller, study, value, unit, status="ok", trajectory="T1", monotone=True, reason=""):
    """Store a margin."""
    entry = {"value": value, "unit": unit, "status": status, "n": 9} | ({"reason": reason} if reason else {})
    provenance = {"monotone": monotone, "resolution": "0.1 kg", "probes": [{**PROBE, "failed_at": 0.5}]}
    result = RunResult(role="run", status="ok", metrics={"margin": {study: entry}}, provenance=provenance)
    shelf.put(study_of(shelf, controller, study, trajectory), result)


def loop(phase, gain, alpha, spread):
    """Return the stored margins of one joint's loop."""
    values = {
        "phase_margin": (phase, "deg"), "gain_margin": (gain, "times"), "loop_delay_margin": (phase * 1e-4, "s"),
        "modulus_margin": (0.9, "times"), "crossover": (40.0, "rad/s"), "disk_margin": (alpha, "times"),
        "disk_gain_margin": (4.0, "times"), "disk_phase_margin": (60.0, "deg"), "scatter": (spread, "1"),
    }  # fmt: skip
    return {
        name: {"value": value, "unit": unit, "status": "ok" if math.isfinite(value) else "undefined", "n": 45}
        for name, (value, unit) in values.items()
    }


def put_loops(shelf, controller, spread=0.01):
    """Store loops whose worst joint is the second in phase and the first in gain."""
    together = {"multiloop_disk_margin": {"value": 1.04, "unit": "times", "status": "ok", "n": 45}}
    metrics = {
        "loop 1": loop(75.0, 0.5, 1.4, 0.0),
        "loop 2": loop(45.0, 12.0, 1.3, spread),
        "loop 10": loop(80.0, math.inf, 1.5, 0.0),
        "loops": together,
    }
    shelf.put(study_of(shelf, controller, "loop_response", "hold"), RunResult(role="run", status="ok", metrics=metrics))


def text_of(page):
    """Return the words of a page."""
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", re.sub(r"<(style|script)>.*?</\1>", "", page.html, flags=re.S)))


def table_of(page, name):
    """Return the cells of a table by row."""
    body = re.search(rf'<table id="{name}">.*?<tbody>(.*?)</tbody>', page.html, re.S).group(1)
    rows = [re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row, re.S) for row in re.findall(r"<tr.*?>(.*?)</tr>", body, re.S)]
    return [[re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", cell)).strip() for cell in row] for row in rows]


@pytest.fixture
def measured(shelf):
    """Two controllers with runs, margins and loops."""
    shelf.grid({("flexiv_factory", "none"): 17e-3, ("computed_torque", "none"): 3e-3}, ("T1", "T6"), (2.5,))
    for controller in ("flexiv_factory", "computed_torque"):
        put_margin(shelf, controller, "load_margin", 4.8, "kg")
        put_margin(shelf, controller, "delay_margin", 0.001, "s", monotone=controller != "flexiv_factory")
        put_margin(shelf, controller, "friction_margin", 40.0, "times", status="censored")
    put_margin(shelf, "computed_torque", "load_margin", 6.2, "kg", trajectory="T6")
    put_loops(shelf, "computed_torque")
    put_loops(shelf, "flexiv_factory", spread=0.4)
    return shelf.campaign()


def test_margins_stand_by_controller_and_motion(measured):
    """In the order of the headline table, in the page's units, with what was not measured in words."""
    rows = table_of(measured.report(), "w1-margins")
    assert [row[:2] for row in rows] == [
        ["computed_ torque / none", "T1"], ["computed_ torque / none", "T6"], ["flexiv_ factory / none", "T1"],
    ]  # fmt: skip
    assert rows[0][2] == "4.8"
    assert rows[1][2] == "6.2"
    assert rows[1][3] == "∅ not computed"


def test_a_bound_is_marked_and_a_response_that_recovers_is_flagged(measured):
    """Nobody may read the end of a grid, or the first of two failures, as a plain figure."""
    rows = table_of(measured.report(), "w1-margins")
    assert rows[0][4] == "≥ 40.0"
    assert rows[2][3] == "1 ⚑ recovers further out"


def test_a_margin_that_has_no_meaning_says_why(measured):
    """Nominal failures and drives without friction are no margins of 0."""
    why = "the tier has no friction to scale"
    put_margin(measured, "computed_torque", "friction_margin", math.nan, "times", "undefined", "T6", reason=why)
    assert table_of(measured.report(), "w1-margins")[1][4] == f"∅ undefined {why}"


def test_the_worst_joint_stands_in_front(measured):
    """Each figure with its own joint; a gain margin is worst nearest to 1, above or below."""
    page = measured.report()
    row = table_of(page, "w1-loops")[0]
    assert row[1:3] == ["45.0 joint 2", "0.50 joint 1"]
    assert "1.04" in row
    joints = table_of(page, "w1-loops-by-joint")
    assert [line[1] for line in joints[:3]] == ["1", "2", "10"]
    assert joints[2][3] == "∞"


def test_a_noisy_loop_is_marked(measured):
    """40 % of the margin is noise: the figure says little."""
    page = measured.report()
    assert table_of(page, "w1-loops")[1][-1] == "⚑ 40.0 joint 2"
    assert "⚑" not in table_of(page, "w1-loops")[0][-1]


def test_studies_enter_no_comparison(measured):
    """A margin's row has no position error, and is neither a run nor a twin."""
    page = measured.report()
    (world,) = page.summary["worlds"]
    assert (world["runs"], world["twins"], world["studies"]) == (4, 0, 9)


def test_every_run_behind_a_margin_is_exported(measured):
    """With the perturbation to run it again, and the address of its study."""
    files = measured.report().files
    rows = list(csv.DictReader((files.index.parent / "probes.csv").open()))
    assert len(rows) == 7
    assert rows[0]["perturbation"] == '{"payload": 1.2}'
    assert (rows[0]["passed"], rows[0]["failed_at [s]"]) == ("False", "0.5")


def test_programs_find_every_margin(measured):
    """In stored units, with status and flag."""
    (world,) = measured.report().summary["worlds"]
    found = {(entry["controller"], entry["trajectory"]): entry["margins"] for entry in world["robustness"]["margins"]}
    assert found["flexiv_factory / none", "T1"]["delay_margin"]["value"] == 0.001
    assert found["flexiv_factory / none", "T1"]["delay_margin"]["monotone"] is False
    assert world["robustness"]["loops"]["computed_torque / none"]["loop 10"]["gain_margin"]["value"] is None


def test_what_could_not_be_measured_says_why(measured):
    """A controller that fails in the nominal world has no margin, and a row that tells of it."""
    specification = study_of(measured, "computed_torque", "gain_margin_up")
    failed = RunResult(role="run", status="failed", cause="divergence", reason="joint 4 moves at 21 rad/s")
    measured.put(specification, failed)
    rows = table_of(measured.report(), "w1-unmeasured")
    assert rows == [["computed_ torque / none", "T1", "gain_margin_up", "failed", "joint 4 moves at 21 rad/s"]]


def test_a_store_of_studies_alone_has_a_page(shelf):
    """Whoever runs only margins still gets them."""
    put_margin(shelf, "computed_torque", "load_margin", 4.8, "kg")
    put_loops(shelf, "computed_torque")
    page = shelf.campaign().report()
    assert table_of(page, "w1-margins")[0][2] == "4.8"
    assert "Robustness" in text_of(page)


def test_a_store_without_studies_has_no_such_section(shelf):
    """Nor a file of their runs."""
    shelf.grid({("flexiv_factory", "none"): 17e-3}, ("T1", "T6"), (2.5,))
    page = shelf.campaign().report()
    assert "Robustness" not in text_of(page)
    assert not (page.files.index.parent / "probes.csv").exists()


def test_runs_of_a_perturbed_world_are_a_world_of_their_own(shelf):
    """They are compared with each other, never with nominal ones."""
    shelf.grid({("flexiv_factory", "none"): 17e-3}, ("T1", "T6"), (2.5,))
    shelf.grid({("flexiv_factory", "none"): 19e-3}, ("T1",), (2.5,), perturbation=Perturbation(delay=2))
    worlds = shelf.campaign().report().summary["worlds"]
    assert [world["facts"]["Perturbation"] for world in worlds] == ["none", "delay 2"]
