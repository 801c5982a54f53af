"""What was drawn can be reached from the page and the run table; drawn runs are never paired with nominal ones."""

import csv
import json
from dataclasses import replace

import pytest
from torquebench.scenarios.draws import draw

SCALES = {("flexiv_factory", "none"): 17e-3, ("computed_torque", "none"): 3e-3, ("computed_torque", "oracle"): 1e-3}


def put_drawn(shelf, *, of=lambda specification: specification):
    """Put three controllers on two motions, two repetitions each, with what ``of`` makes of a run's draws."""
    for (controller, knowledge), size in SCALES.items():
        for trajectory in ("T1", "T6"):
            for repetition in (0, 1):
                run = shelf.specification(controller, knowledge, trajectory, repetition=repetition, draws=True)
                result = shelf.result(run, size, "slow")
                table = draw(of(run), 7).as_table()
                shelf.put(run, replace(result, provenance={**result.provenance, "draws": table}))
    return shelf.campaign()


def rows_of(page):
    """Return the rows of the run table."""
    with page.files.runs.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_every_run_has_its_draws_in_the_run_table(shelf):
    """To the bit, as JSON; the column of the specification says that there were any."""
    page = put_drawn(shelf).report()
    for row in rows_of(page):
        run = shelf.specification("any", "none", row["trajectory"], repetition=int(row["repetition"]), draws=True)
        for name, value in draw(run, 7).as_table().items():
            assert json.loads(row[f"drawn.{name}"]) == value
        assert row["draws"] == "True"


def test_the_page_shows_one_draw_for_each_motion_and_repetition(shelf):
    """Four rows behind twelve runs, and a sentence that says so."""
    page = put_drawn(shelf).report()
    assert "All controllers met the same draws" in page.html
    assert "What was drawn (4 rows)" in page.html
    assert page.html.count('id="w1-draws"') == 1


def test_runs_that_drew_differently_are_found_out(shelf):
    """A pairing that is none would make every interval too wide or too narrow, and nobody would see it."""
    page = put_drawn(shelf, of=lambda run: replace(run, campaign=2 if "flexiv" in run.controller else 1)).report()
    assert "Some runs of one motion and repetition drew differently" in page.html
    assert "What was drawn (8 rows)" in page.html


def test_drawn_and_nominal_runs_are_worlds_of_their_own(shelf):
    """One store, two campaigns: no run of one is compared with a run of the other."""
    page = put_drawn(shelf.grid(trajectories=("T1", "T6"), masses=(1.5,))).report()
    facts = {world["facts"]["Repetitions draw"]: world["runs"] for world in page.summary["worlds"]}
    assert facts == {"sensor noise": 10, "friction, load, link masses, start and sensor noise": 12}


def test_a_nominal_page_speaks_of_no_draws(quick):
    """Nothing was drawn."""
    assert "What was drawn" not in quick.html
    assert not [name for name in rows_of(quick)[0] if name.startswith("drawn.")]
    assert pytest.approx(0) == sum(row["draws"] == "True" for row in rows_of(quick))
