"""The page on other worlds: which controllers change places, and which no longer run."""

import re
from html import unescape

import pytest

FEW = {"trajectories": ("T1", "T2", "T3", "T6", "T7", "T8"), "masses": (1.5, 3.5)}
SCALES = {("flexiv_factory", "none"): 17e-3, ("computed_torque", "none"): 3e-3, ("pid", "none"): 1e-3}
STILL = {"tier_constants": {"armature_scale": 0.0}}


def said(page):
    """Return what the page says of each variant."""
    part = page.html.partition('<section id="sensitivity">')[2].partition("</section>")[0]
    pairs = re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", part, re.DOTALL)
    return {unescape(title): unescape(text).strip() for title, text in pairs}


def test_one_world_has_no_such_section(quick):
    """Nothing was varied."""
    assert 'id="sensitivity"' not in quick.html


def test_an_order_that_holds_is_said_to_hold(shelf):
    """Twice as large errors throughout are no change in the order."""
    shelf.grid(SCALES, **FEW).grid({name: 2 * size for name, size in SCALES.items()}, tier="ideal", **FEW)
    shelf.grid(SCALES, **FEW, tier_constants={"substeps": 4})
    assert said(shelf.campaign().report()) == {
        "substeps=4": "The order is the same.",
        "tier ideal": "The order is the same.",
    }


def test_every_change_of_places_is_named_with_both_ratios(shelf):
    """The reader must see who passed whom, and by how much in either world."""
    swapped = {**SCALES, ("computed_torque", "none"): 0.5e-3}
    shelf.grid(SCALES, **FEW).grid(swapped, **FEW, **STILL)
    text = said(shelf.campaign().report())["armature_scale=0.0"]
    found = re.fullmatch(r"Change places: pid / none and computed_torque / none \(ratio (.*), here (.*)\)\.", text)
    before, after = (float(number) for number in found.groups())
    assert (before, after) == pytest.approx((1 / 3, 2.0), rel=0.15)


def test_who_no_longer_runs_is_named_with_what_became_of_it(shelf):
    """A controller that is refused elsewhere has no place there, and that is a result."""
    shelf.grid(SCALES, **FEW)
    shelf.grid({name: size for name, size in SCALES.items() if name[0] != "pid"}, **FEW, **STILL)
    for trajectory in FEW["trajectories"]:
        for mass in FEW["masses"]:
            shelf.fail(shelf.specification("pid", "none", trajectory, mass, **STILL), status="refused")
    text = said(shelf.campaign().report())["armature_scale=0.0"]
    assert text == "Without a place here: pid / none (12 refused of 12)."


def test_worlds_that_differ_in_more_than_the_plant_are_no_variants(shelf):
    """Five laps against three is another question."""
    shelf.grid(SCALES, **FEW).grid(SCALES, **FEW, laps=5)
    assert 'id="sensitivity"' not in shelf.campaign().report().html


def test_the_usual_world_is_the_one_that_the_others_vary(shelf):
    """Whichever ran first: each variant has one thing of its own, the usual world none."""
    shelf.grid(SCALES, **FEW, plant="pinocchio").grid(SCALES, **FEW, tier="ideal").grid(SCALES, **FEW)
    page = shelf.campaign().report()
    assert "As usual: pybullet, tier actuated." in page.html
    assert set(said(page)) == {"plant pinocchio", "tier ideal"}
    assert "<h2>As usual</h2>" in page.html
