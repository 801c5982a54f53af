"""The paper's claims on the page: every one with a verdict, none without what it was judged against."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from torquebench.controllers.operations import OperationCosts, OperationCounts
from torquebench.evaluation.report import write_report

STAND_IN = "against our approximation of the factory controller"
SCALES = {("flexiv_factory", "none"): 17.2e-3, ("cbmc_v3", "none"): 12.0e-3}


def claims_by_id(page):
    return {claim["id"]: claim for claim in page.summary["claims"]}


def test_every_claim_stands_on_the_page_with_its_verdict(precise):
    """55 rows, whatever ran."""
    found = claims_by_id(precise)
    assert len(found) == 55
    for name, claim in found.items():
        assert f'<th scope="row">{name}</th>' in precise.html
        assert claim["verdict"] and (claim["reason"] or claim["verdict"].startswith("reproduced"))
    assert '<a href="#claims">Claims</a>' in precise.html


def test_what_ran_is_judged_and_what_did_not_is_open(precise):
    """30 % less position error on sand; water and the other experiments are named as missing."""
    found = claims_by_id(precise)
    assert found["C3"]["verdict"] == f"reproduced, {STAND_IN}"
    assert found["C3"]["interval"][0] < found["C3"]["measured"] < found["C3"]["interval"][1] < 1.0
    assert (found["C3"]["n"], found["C3"]["of"]) == (8, "trajectories")
    assert "water" in found["C5"]["reason"] and found["C5"]["measured"] is None
    assert "paper and paper-resilience run it" in found["C35"]["reason"]
    assert found["C54"]["verdict"] == "cannot be tested here"
    assert "paper and compute run it" in found["C49"]["reason"]


def test_a_proxy_never_stands_without_what_it_is(precise):
    """In the table, in its CSV link, and for programs."""
    for claim in precise.summary["claims"]:
        assert (STAND_IN in claim["verdict"]) == (claim["testable"] == "proxy")
        assert (STAND_IN in claim["sentence"]) == (claim["testable"] == "proxy")
    assert precise.html.count(STAND_IN) >= sum(c["testable"] == "proxy" for c in precise.summary["claims"])


def test_the_contradictions_of_the_paper_are_listed(precise):
    """All 23, and the one percentage that its own means do not give."""
    for number in range(1, 24):
        assert f"<b>I{number}</b>" in precise.html
    assert precise.html.count('class="n bad" data-v="42.517"') == 1


def test_the_page_is_the_same_text_each_time(precise, tmp_path):
    """Verdicts come from the runs alone."""
    from torquebench.evaluation.report import write_report

    again = write_report(precise.files.index.parent.parent, tmp_path / "again")
    assert again.index.read_text(encoding="utf-8") == precise.html
    assert json.loads(again.summary.read_text(encoding="utf-8"))["claims"] == precise.summary["claims"]


def test_a_store_without_the_paper_s_controller_has_no_claims(quick):
    """55 open rows would tell nobody anything."""
    assert 'id="claims"' not in quick.html
    assert quick.summary["claims"] == []


def test_runs_of_another_world_are_of_no_set(shelf):
    """Two laps, another tier or a late command is another experiment."""
    for changes in ({"laps": 2}, {"tier": "ideal"}, {"latency": 3}):
        shelf.grid(SCALES, masses=(1.5,), **changes)
    assert shelf.report().summary["claims"] == []


def test_a_slow_motion_beyond_the_set_is_left_out(shelf):
    """A world may hold more motions than the paper's eight; claims are about those."""
    shelf.grid(SCALES, masses=(1.5, 2.5, 3.5))
    other = shelf.specification("cbmc_v3", "none", "S1", 1.5)
    shelf.put(other, shelf.result(other, 1.0, "slow"))
    found = claims_by_id(shelf.report())
    assert found["C19"]["n"] == 8


def test_weights_and_gains_become_readings(shelf):
    """What the modules showed stands behind the claims about them: a third of the load on the heavy pattern."""
    for trajectory in ("S1", "S2", "S3"):
        for mass in (1.5, 2.5, 3.5):
            run = shelf.specification("cbmc_v3", "none", trajectory, mass, tier="ideal", laps=4)
            result = shelf.result(run, 0.01, "")
            weights = {"run_mean": [1.0 - (mass - 1.2) / 3.0, (mass - 1.2) / 3.0], "last_lap_mean": [0.5, 0.5]}
            shelf.put(run, replace(result, diagnostics={"weights": weights}))
    found = claims_by_id(shelf.report())
    assert found["C28"]["measured"] == pytest.approx(1.0 / 3.0)
    assert found["C28"]["verdict"] == "reproduced"


def test_a_rate_of_improvement_comes_from_the_first_repeated_change(shelf):
    """Each addition of 2 kg costs a tenth less: a rate of ln 0.9, and what taking off costs is another matter."""
    from torquebench.scenarios.loads import LoadSchedule, Payload

    light, heavy = Payload(mass=1.5), Payload(mass=3.5, material="sand")
    times = (12.0, 18.0, 24.0, 30.0, 36.0, 42.0)
    schedule = LoadSchedule(entries=((0.0, light), *((t, heavy if i % 2 == 0 else light) for i, t in enumerate(times))))
    for trajectory in ("S1", "S2", "S3"):
        run = shelf.specification("cbmc_v3", "none", trajectory, laps=16, schedule=schedule)
        result = shelf.result(run, 0.01, "")
        costs = {f"event@{t:g}": 0.02 * (0.9 ** (i / 2) if i % 2 == 0 else 1.0) for i, t in enumerate(times)}
        events = {w: {"excess_integral": {"value": c, "unit": "rad s", "status": "ok"}} for w, c in costs.items()}
        shelf.put(run, replace(result, metrics={**result.metrics, **events}))
    found = claims_by_id(shelf.report())["C41"]
    assert found["measured"] == pytest.approx(np.log(0.9))
    assert found["unit"] == "per event"


def test_patterns_are_judged_on_the_motions_that_training_did_not_see(shelf):
    """A pattern that fails beside the training circles is not one that knows gravity; the circles do not count."""
    run = shelf.specification("cbmc_v3", "none", "S1", tier="ideal", laps=4)
    weights = {"weights": {"run_mean": [0.5, 0.5], "last_lap_mean": [0.5, 0.5]}}
    shelf.put(run, replace(shelf.result(run, 0.01, ""), diagnostics=weights))
    shelf.store.close()
    for error, verdict in ((0.03, "reproduced"), (0.3, "not reproduced")):
        known = {"S1": {0.0: 5.0, 3.0: 5.0}, **{f"T{i}": {0.0: error, 3.0: error} for i in range(1, 9)}}
        files = write_report(shelf.folder, gravity_of=lambda run, known=known: known)
        summary = json.loads(files.summary.read_text(encoding="utf-8"))
        found = next(claim for claim in summary["claims"] if claim["id"] == "C33")
        assert (found["verdict"], found["measured"]) == (verdict, pytest.approx(error))
        assert "of the gravity torque of its load" in files.index.read_text(encoding="utf-8")
        with (files.tables / "w1-gravity.csv").open(encoding="utf-8", newline="") as stream:
            table = {row["Motion"]: row for row in csv.DictReader(stream)}
        assert float(table["T1"]["3 kg beyond the gripper [%]"]) == pytest.approx(100.0 * error)


def test_a_number_of_a_claim_keeps_its_unit_in_a_file(precise):
    """Rows have units of their own: 0.018 below a header without any is no figure."""
    with (precise.files.tables / "claims-precision.csv").open(encoding="utf-8", newline="") as stream:
        (level,) = [row for row in csv.DictReader(stream) if row["No."] == "C7"]
    assert level["Paper"] == "18.0 mm" and level["Measured"].endswith(" mm")
    with (precise.files.tables / "claims-arithmetic.csv").open(encoding="utf-8", newline="") as stream:
        assert {row["Factory"].split()[-1] for row in csv.DictReader(stream)} == {"m", "rad"}


def test_energy_is_judged_by_each_run_s_own_counts(shelf):
    """What a spiking controller computes depends on its spikes; a law that computes half is cheaper in every cell."""
    prices = {"cbmc_v3": 100.0, "computed_torque": 50.0, "computed_torque_pid": 50.0, "flexiv_factory": 50.0}
    shelf.grid({(name, "none"): 0.01 for name in prices}, masses=(1.5, 2.5))
    shelf.store.close()

    def counted(run):
        multiplications = prices[run.specification.controller]
        return OperationCosts(
            by_event={"ticks": OperationCounts(multiplications=multiplications)}, parameters=1, state=1, how="by hand"
        )

    files = write_report(shelf.folder, costs_of=counted)
    summary = json.loads(files.summary.read_text(encoding="utf-8"))
    found = next(claim for claim in summary["claims"] if claim["id"] == "C50")
    assert found["measured"] == pytest.approx(2.0)
    assert found["verdict"] == "opposite"


def test_patterns_alone_are_no_reason_for_a_table_of_claims(shelf):
    """A first look at two laps would show 54 open rows below one that was judged."""
    run = shelf.specification("cbmc_v3", "none", "S1", laps=2)
    weights = {"weights": {"run_mean": [0.5, 0.5], "last_lap_mean": [0.5, 0.5]}}
    shelf.put(run, replace(shelf.result(run, 0.01, ""), diagnostics=weights))
    shelf.store.close()
    known = {f"T{i}": {0.0: 0.01, 3.0: 0.01} for i in range(1, 9)}
    files = write_report(shelf.folder, gravity_of=lambda run: known)
    html = files.index.read_text(encoding="utf-8")
    assert 'id="claims"' not in html and "of the gravity torque of its load" in html
