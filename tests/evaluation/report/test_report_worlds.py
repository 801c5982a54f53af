"""Stores that are not a full grid: the page says what is missing and mixes nothing."""

import csv
import re
from dataclasses import replace

import pytest
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import RunResult

POSITION = "tcp_position_error_mean"


def sentences(page, world=0):
    return page.summary["worlds"][world]["sentences"][POSITION]


def test_a_missing_reference_costs_the_ratios_not_the_page(shelf):
    page = shelf.grid().campaign(shelf.record("mpc / none")).report()
    world = page.summary["worlds"][0]
    assert not world["reference_present"]
    assert world["comparisons"] == []
    assert "the declared reference mpc / none did not run here" in sentences(page)[0]
    assert "There is no ratio to draw" in page.html


def test_no_declared_reference_is_said(shelf):
    page = shelf.grid(trajectories=("T1", "T2"), masses=(1.5,)).report()
    assert "no reference was declared" in sentences(page)[0]
    assert "No campaign is on record" in page.html


def test_a_reference_that_failed_throughout_leaves_ranks_only(shelf):
    scales = {("computed_torque", "none"): 3e-3, ("computed_torque", "oracle"): 0.4e-3}
    shelf.grid(scales)
    for trajectory in ("T1", "T2", "T3", "T4", "T5", "T6", "T7", "T8"):
        for mass in (1.5, 2.5, 3.5):
            shelf.fail(shelf.specification("flexiv_factory", "none", trajectory, mass))
    page = shelf.campaign().report()
    assert "24 runs of 72 failed: flexiv_factory / none (24)." in page.html
    assert "the reference failed too often for a ratio" in sentences(page)[0]


def test_one_trajectory_has_no_interval(shelf):
    page = shelf.grid(trajectories=("T1",)).campaign().report()
    assert "one trajectory: no interval" in sentences(page)[0]
    assert "not enough to decide" in sentences(page)[0]
    assert all(found["interval_new_motions"] is None for found in page.summary["worlds"][0]["comparisons"])


def test_one_controller_is_not_compared(shelf):
    page = shelf.grid({("flexiv_factory", "none"): 17e-3}, ("T1", "T2")).campaign().report()
    assert "ran alone" in sentences(page)[0]


@pytest.mark.parametrize("status", ["failed", "refused"])
def test_a_store_of_nothing_but_failures_is_reported(shelf, status):
    for trajectory in ("T1", "T2"):
        shelf.fail(shelf.specification("flexiv_factory", "none", trajectory), status)
        shelf.fail(shelf.specification("computed_torque", "none", trajectory), status)
    page = shelf.campaign().report()
    assert "Nothing to rank in position" in sentences(page)[0]
    assert len(page.summary["worlds"][0]["failed"]) == 4


def test_an_empty_store_is_reported(shelf):
    assert "This store holds no runs yet" in shelf.campaign().report().html


def test_nothing_failed_is_said_in_one_line(shelf):
    page = shelf.grid(trajectories=("T1",), masses=(1.5,)).campaign().report()
    assert "No run of 5 failed." in page.html
    assert "Nothing failed and nothing was refused." in page.html


@pytest.mark.parametrize(
    "change",
    [
        {"tier": "ideal"},
        {"plant": "pinocchio"},
        {"laps": 5},
        {"lead_in": 2.0},
        {"latency": 1},
        {"tare": True},
        {"campaign": 2},
    ],
)
def test_two_worlds_do_not_mix(shelf, change):
    """A mean over two plants is a mean of nothing."""
    few = {"trajectories": ("T1", "T2", "T3"), "masses": (1.5,)}
    shelf.grid(**few)
    shelf.grid({("computed_torque", "none"): 30e-3, ("flexiv_factory", "none"): 3e-3}, **few, **change)
    page = shelf.campaign().report()
    first, second = page.summary["worlds"]
    assert (first["runs"], second["runs"]) == (15, 6)
    assert [found["gmr"] < 1 for found in second["comparisons"] if found["metric"] == POSITION] == [False]
    assert all(found["gmr"] < 1 for found in first["comparisons"] if found["metric"] == POSITION)
    assert len(re.findall('<section id="w[0-9]" class="world">', page.html)) == 2
    assert "This store holds runs of 2 worlds" in page.html


def test_measured_latency_is_said_and_two_machines_do_not_mix(shelf):
    """A merged store: the same specification on two machines is two results, in two worlds, with a sentence each."""
    few = {"trajectories": ("T1", "T2"), "masses": (1.5,)}
    shelf.grid(**few)
    for number, machine in enumerate(("a fast one", "a slow one")):
        for trajectory in few["trajectories"]:
            run = shelf.specification("computed_torque", "none", trajectory, latency="measured")
            result = shelf.result(run, 1e-3, "slow")
            owned = replace(result, provenance={**result.provenance, "machine": machine})
            shelf.store.put(run.address(f"digest {number}"), run, [owned])
    page = shelf.campaign().report()
    plain, *measured = page.summary["worlds"]
    assert plain["facts"]["Latency"] == "none" and plain["sentences"]["machine"] == ""
    assert [world["facts"]["Latency"] for world in measured] == ["measured on a fast one", "measured on a slow one"]
    assert [(world["runs"], world["left_out"]) for world in measured] == [(2, 0), (2, 0)]
    assert "belong to one machine (a slow one)" in measured[1]["sentences"]["machine"]
    assert measured[1]["sentences"]["machine"] in page.html


def test_runs_with_a_load_change_are_a_world_of_their_own_and_twins_are_apart(shelf):
    shelf.grid(trajectories=("T1", "T2"), masses=(1.5,))
    heavier = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (12.0, Payload(mass=3.5, material="sand"))))
    for controller in ("flexiv_factory", "computed_torque"):
        run = replace(shelf.specification(controller, "none"), schedule=heavier, twins=True)
        result = shelf.result(run, 1e-2, "slow")
        shelf.put(run, result, replace(result, role="constant 1.5 kg"), replace(result, role="constant 3.5 kg sand"))
    page = shelf.campaign().report()
    world = page.summary["worlds"][1]
    assert (world["runs"], world["twins"]) == (2, 4)
    assert world["facts"]["Load history"] == "1.5 kg, from 12 s 3.5 kg sand"
    assert "4 twins, in no comparison" in page.html


def test_one_controller_with_two_settings_has_two_rows(shelf):
    shelf.grid(trajectories=("T1", "T2"), masses=(1.5,))
    shelf.grid({("computed_torque", "none"): 1e-3}, ("T1", "T2"), (1.5,), settings={"bandwidth": 40.0})
    page = shelf.campaign().report()
    assert {"computed_torque / none", "computed_torque / none (bandwidth=40.0)"} <= set(
        page.summary["worlds"][0]["controllers"]
    )


def test_results_of_other_code_are_left_out_and_counted(shelf):
    shelf.grid(trajectories=("T1", "T2"), masses=(1.5,))
    run = shelf.specification("computed_torque", "none", "T1")
    shelf.store.put(run.address("other code"), run, [shelf.result(run, 1.0, "slow")])
    page = shelf.campaign().report()
    assert page.summary["worlds"][0]["left_out"] == 1
    assert "1 rows are left out" in page.html


def test_an_unsteady_metric_is_a_word(shelf):
    """Censored, undefined and missing values are words with a symbol, never a number that looks measured."""
    shelf.grid({("flexiv_factory", "none"): 17e-3}, ("T1", "T2"), (1.5,))
    run = shelf.specification("computed_torque", "none", "T1")
    result = shelf.result(run, 1e-3, "slow")
    undefined = {"value": float("nan"), "unit": "m", "status": "undefined", "n": 10}
    shelf.put(run, replace(result, metrics={"run": {**result.metrics["run"], POSITION: undefined}}))
    page = shelf.campaign().report()
    assert "\N{EMPTY SET} undefined" in page.html


def test_repetitions_give_the_interval_of_this_suite(shelf):
    for repetition in range(2):
        shelf.grid(trajectories=("T1", "T2", "T3"), masses=(1.5,), repetition=repetition)
    page = shelf.campaign().report()
    assert all(found["interval_suite"] for found in page.summary["worlds"][0]["comparisons"])


def test_a_campaign_record_may_have_gaps(shelf):
    page = (
        shelf.grid(trajectories=("T1",), masses=(1.5,))
        .campaign({"benchmark": None, "gate": None, "notes": None})
        .report()
    )
    assert "No gate is on record" in page.html


def test_a_saturated_row_is_flagged(shelf):
    shelf.grid(trajectories=("T1", "T2"), masses=(1.5,))
    run = shelf.specification("w_integrator", "none", "T1")
    result = shelf.result(run, 1e-2, "slow")
    clipped = {"value": 0.04, "unit": "1", "status": "ok", "n": 10}
    shelf.put(run, replace(result, metrics={"run": {**result.metrics["run"], "clip_fraction": clipped}}))
    page = shelf.campaign().report()
    assert "1 run > 1 %" in page.html.replace("&gt;", ">")


def test_who_ran_more_than_others_is_ranked_where_they_ran_too(shelf):
    """Ten repetitions and a second material must not leave one controller alone at the top."""
    few = {"trajectories": ("T1", "T2", "T3"), "masses": (1.5, 2.5)}
    shelf.grid(**few)
    shelf.grid({("cbmc_v3", "none"): 20e-3}, **few)
    for repetition in (1, 2):
        shelf.grid({("cbmc_v3", "none"): 20e-3}, **few, repetition=repetition)
    shelf.grid({("cbmc_v3", "none"): 0.1e-3}, trajectories=("T1", "T2", "T3"), masses=(3.5,))
    page = shelf.campaign().report()
    (world,) = page.summary["worlds"]
    ranking = world["ranking"][POSITION]
    assert len(ranking) == 6
    assert ranking[-1] == "cbmc_v3 / none"


def test_a_world_is_told_by_what_most_others_have_not(shelf):
    """A title of everything that differs anywhere is as long for each world as the list of all of them."""
    for changes in ({}, {"laps": 5}, {"tier": "ideal"}, {"tier": "ideal", "laps": 5, "lead_in": 0.0}, {"draws": True}):
        shelf.grid({("pid", "none"): 1e-3}, trajectories=("T1",), masses=(1.5,), **changes)
    html = shelf.report().html
    titles = re.findall(r"<section id=\"w\d\" class=\"world\">\s*<h2>([^<]*)</h2>", html)
    assert len(set(titles)) == 5
    assert {"Laps 5", "Tier ideal", "Tier ideal, laps 5, lead-in 0 s"} <= set(titles)
    assert any(title.startswith("Repetitions draw friction") for title in titles)


def test_a_run_whose_process_was_lost_did_not_fail_before_its_start(shelf):
    """Its time is unknown; only a refused run never began."""
    shelf.grid({("pid", "none"): 1e-3}, trajectories=("T1",))
    run = shelf.specification("mpc", "none", "T1", 2.5)
    shelf.put(run, RunResult(role="run", status="failed", cause="time-out", reason="its process was ended"))
    shelf.fail(shelf.specification("mpc", "none", "T1", 3.5), status="refused")
    rows = re.findall(r"<tr>.*?</tr>", shelf.report().html.partition('id="w1-failed"')[2], re.DOTALL)
    lost, refused = (next(row for row in rows if word in row) for word in ("time-out", "refused"))
    assert "no tick on record" in lost and "before the start" not in lost
    assert "before the start" in refused


def test_means_in_sentences_are_of_the_cells_that_most_ran(shelf):
    """Who ran harder motions besides must not look worse in the words, nor better than the ratio beside them."""
    shelf.grid({("pid", "none"): 1e-3, ("computed_torque", "none"): 5e-3, ("mpc", "none"): 9e-3}, masses=(1.5,))
    for trajectory in ("M1", "M2"):
        run = shelf.specification("pid", "none", trajectory, 1.5)
        shelf.put(run, shelf.result(run, 0.4, "further"))
    page = shelf.report()
    world = page.summary["worlds"][0]
    assert "ranked over the 8 cells" in world["sentences"]["common"]
    stored = world["controllers"]["pid / none"]["metrics"][f"run.{POSITION}"]
    paper = [error for name, error in stored["by_trajectory"].items() if name.startswith("T")]
    assert f"{1e3 * sum(paper) / len(paper):.2f} mm" in sentences(page)[0]
    assert stored["mean"] > 10.0 * sum(paper) / len(paper)
    laps = world["controllers"]["pid / none"]["by_lap"][POSITION]
    assert sum(laps) / 3.0 == pytest.approx(sum(paper) / len(paper))


def test_motions_stand_as_people_count(shelf):
    """M2 before M10, in the file of all runs too."""
    for trajectory in ("M10", "M2", "M1"):
        run = shelf.specification("flexiv_factory", "none", trajectory)
        shelf.put(run, shelf.result(run, 1e-2, "slow"))
    rows = csv.DictReader(shelf.report().files.runs.open(encoding="utf-8"))
    assert [row["trajectory"] for row in rows] == ["M1", "M2", "M10"]
