"""Two materials under one controller: what pairs, what the empty container does, and what cannot be compared."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from torquebench.evaluation import NothingToCompare, UnknownMetric, compare, contrast_all, contrast_materials
from torquebench.evaluation.intervals import t_interval

ERROR = "tcp_position_error_mean"
EFFECT = {f"T{i}": effect for i, effect in enumerate([-2e-4, 1e-4, 3e-4, -1e-4, 5e-5, 2e-4, 4e-4, -5e-5], start=1)}
"""What water adds on each trajectory [m]."""


def sandy(trajectory, mass, repetition):
    """An error that grows with the mass, the same on every trajectory."""
    return 0.01 * mass


def watery(trajectory, mass, repetition):
    """The same with the effect of water, where there is any."""
    return sandy(trajectory, mass, repetition) + (EFFECT[trajectory] if mass > 1.5 else 0.0)


def poured(grid, with_sand=sandy, with_water=watery, controller="law"):
    """The runs of one controller with both materials; the empty container runs once."""
    sand, water = (grid.of(controller, error).rows for error in (with_sand, with_water))
    return [*sand, *(replace(row, material="water") for row in water if row.material)]


def test_the_difference_is_that_of_the_means_the_empty_container_on_both_sides(grid):
    """Of two masses one is empty: half the effect, with the trajectory as unit."""
    found = contrast_materials(poured(grid), "law", ("water", "sand"), ERROR)
    halves = 0.5 * np.array(list(EFFECT.values()))
    assert found.difference == pytest.approx(halves.mean(), abs=1e-15)
    assert found.means == pytest.approx((0.02 + halves.mean(), 0.02))
    interval = t_interval(halves)
    assert (found.interval.low, found.interval.high) == pytest.approx((interval.low, interval.high), abs=1e-12)
    assert (found.material, found.baseline, found.ratio.n_pairs) == ("water", "sand", 32)


def test_the_ratio_is_a_comparison_of_two_controllers(grid):
    """The material takes the controller's place, nothing else is different."""
    found = contrast_materials(poured(grid), "law", ("water", "sand"), ERROR).ratio
    direct = compare(grid.of("water", watery).of("sand", sandy).rows, "water", "sand", ERROR)
    assert found == direct


@settings(max_examples=20, deadline=None)
@given(factor=st.floats(0.2, 5.0))
def test_swapping_the_materials_turns_the_sign_and_the_ratio(grid, factor):
    """Whatever the unit of length."""
    rows = poured(grid, lambda *run: factor * sandy(*run), lambda *run: factor * watery(*run))
    there, back = (contrast_materials(rows, "law", pair, ERROR) for pair in (("water", "sand"), ("sand", "water")))
    assert back.difference == pytest.approx(-there.difference, abs=1e-12)
    assert back.ratio.gmr == pytest.approx(1 / there.ratio.gmr, rel=1e-12)
    assert back.means == pytest.approx(there.means[::-1])


def test_only_masses_that_both_have_count(grid):
    """Water at one mass more says nothing about water against sand."""
    more = [replace(row, mass=3.5, material="water") for row in poured(grid) if row.material == "water"]
    rows = poured(grid)
    assert contrast_materials([*rows, *more], "law", ("water", "sand"), ERROR).means == pytest.approx(
        contrast_materials(rows, "law", ("water", "sand"), ERROR).means
    )


def test_a_failed_run_counts_as_in_any_comparison(grid):
    """As the metric's fail value, on its side only."""

    def spilled(trajectory, mass, repetition):
        return "failed" if (trajectory, mass) == ("T6", 2.5) else watery(trajectory, mass, repetition)

    found = contrast_materials(poured(grid, with_water=spilled), "law", ("water", "sand"), ERROR)
    assert found.ratio.failures == (2, 0)
    assert found.means[0] > 0.03


def test_one_trajectory_has_a_difference_and_no_interval(grid):
    """There is nothing that it could be an interval over."""
    few = replace(grid, trajectories=("T6",))
    found = contrast_materials(poured(few), "law", ("water", "sand"), ERROR)
    assert found.difference == pytest.approx(0.5 * EFFECT["T6"])
    assert found.interval is None


def test_without_both_materials_there_is_nothing_to_compare(grid):
    """The empty container alone would make a ratio of exactly 1."""
    rows = grid.of("law", sandy).rows
    with pytest.raises(NothingToCompare, match="law ran with one of them at most"):
        contrast_materials(rows, "law", ("water", "sand"), ERROR)
    assert contrast_all(rows, ERROR) == []
    with pytest.raises(UnknownMetric):
        contrast_materials(rows, "law", ("water", "sand"), "tcp_position_error_meen")


def test_every_controller_with_both_has_a_contrast(grid):
    """The baseline is the first by name; who ran with sand only is left out."""
    rows = [*poured(grid, controller="b"), *poured(grid, controller="a"), *grid.of("c", sandy).rows]
    found = contrast_all(rows, ERROR)
    assert [(one.controller, one.material, one.baseline) for one in found] == [
        ("b", "water", "sand"),
        ("a", "water", "sand"),
    ]
    assert found[0].ratio.gmr == found[1].ratio.gmr
