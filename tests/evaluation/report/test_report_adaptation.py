"""Adaptation: metrics of whole grids, from the cells that all of them need, and no number from less."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from torquebench.evaluation.metrics import METRICS
from torquebench.evaluation.report.adaptation import adaptation_values, compared_rows, grids_of
from torquebench.evaluation.report.numbers import capitalised
from torquebench.evaluation.rows import RunRow

BASE = "tcp_position_error_mean"
MOTIONS = {**{f"T{i}": "slow" for i in range(1, 6)}, **{f"T{i}": "fast" for i in range(6, 9)}}


def row(error, motion="T1", mass=1.5, material="", repetition=0, controller="a / none", group=None, status="ok"):
    entry = {"value": error, "unit": "m", "status": "ok"}
    return RunRow(
        controller=controller, trajectory=motion, group=group or MOTIONS[motion], mass=mass, material=material,
        repetition=repetition, status=status, metrics={"run": {BASE: entry}} if status == "ok" else {},
    )  # fmt: skip


def whole(error, controller="a / none", materials=("sand",), repetitions=1):
    """A grid: ``error(motion, mass)``, two loads of each content beside the empty container."""
    cells = [(1.5, ""), *((mass, material) for material in materials for mass in (2.5, 3.5))]
    return [
        row(error(motion, mass) * (1.0 + 0.1 * repetition), motion, mass, material, repetition, controller)
        for motion in MOTIONS
        for mass, material in cells
        for repetition in range(repetitions)
    ]


def test_a_grid_of_known_slopes_and_speeds_gives_them_back():
    """2 mm a kilogram, twice the error at twice the speed: what was put in comes out."""
    errors = {"T3": 0.010, "T6": 0.020, "T4": 0.009, "T5": 0.012}
    rows = whole(lambda motion, mass: errors.get(motion, 0.01) + 0.002 * (mass - 2.5))
    found = adaptation_values(grids_of(rows, ["a / none"], BASE)["a / none"], BASE)
    assert found["mass_slope_position"] == pytest.approx(0.002)
    assert found["speed_exponent"] == pytest.approx(1.0)
    assert found["shape_range_position"] == pytest.approx(0.5 * (0.003 + 0.010))
    assert found["mass_argmin"] == 1.5
    assert found["worst_case_position"] == pytest.approx(0.022)
    assert "repeat_range_position" not in found


def test_repetitions_enter_the_means_and_have_a_range_of_their_own():
    """A repetition a tenth larger: cells are means over both, and the range is a tenth of the first."""
    grid = grids_of(whole(lambda motion, mass: 0.01, repetitions=2), ["a / none"], BASE)["a / none"]
    assert np.allclose(grid.errors, 0.0105)
    assert adaptation_values(grid, BASE)["repeat_range_position"] == pytest.approx(0.001)


def test_a_grid_with_a_hole_or_a_failure_has_no_numbers():
    """A range over part of a grid is smaller than one over all of it: the lazy would adapt best."""
    rows = whole(lambda motion, mass: 0.01)
    other = [replace(found, controller="b / none") for found in rows]
    assert grids_of([*rows, *other[1:]], ["b / none"], BASE)["b / none"] == "grid with gaps"
    failed = [row(0.0, "T1", 1.5, controller="b / none", status="failed"), *other[1:]]
    assert grids_of([*rows, *failed], ["b / none"], BASE)["b / none"] == "a run failed"


def test_one_content_and_the_paper_s_motions_are_compared():
    """Sand and water are two grids of one arm, and new motions are judged apart: mixed, a range means nothing."""
    rows = whole(lambda motion, mass: 0.01, materials=("sand", "water"))
    rows += [row(0.5, "M1", group="fast")]
    kept = compared_rows(rows)
    assert {found.material for found in kept} == {"", "sand"}
    assert {found.trajectory for found in kept} == set(MOTIONS)
    assert compared_rows([found for found in rows if found.mass == 1.5]) == []
    assert compared_rows([found for found in rows if found.group == "slow"]) == []


def test_the_page_has_a_table_for_position_and_one_for_orientation(quick):
    """In the page's units, with the reason where there is no number, and for programs in stored units."""
    with (quick.files.tables / "w1-adaptation-position.csv").open(encoding="utf-8", newline="") as stream:
        rows = {found["Controller / knowledge"]: found for found in csv.DictReader(stream)}
    title = f"{capitalised(METRICS['mass_slope_position'].label)} [mm/kg]"
    stored = quick.summary["worlds"][0]["adaptation"][BASE]
    value = stored["flexiv_factory / none"]["mass_slope_position"]
    assert float(rows["flexiv_factory / none"][title]) == pytest.approx(1e3 * value, rel=1e-3)
    assert rows["flexiv_full_ff / none"][title].endswith("a run failed")
    assert stored["flexiv_full_ff / none"] == "a run failed"
    assert "How the mean orientation error depends on" in quick.html


def test_who_was_not_repeated_has_words_where_others_have_a_range_over_repetitions(shelf):
    """One law of many was run twice: the rest of the column must say so, in words for people."""
    sizes = {("flexiv_factory", "none"): 1e-2, ("pid", "none"): 1e-3}
    shelf.grid(sizes).grid({("pid", "none"): 1e-3}, repetition=1).campaign()
    page = shelf.report()
    table = page.html.partition('id="w1-adaptation-position"')[2].partition("</table>")[0]
    assert table.count("\N{EMPTY SET} one repetition<") == 1
    assert "Grid(" not in page.html
