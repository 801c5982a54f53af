"""Tables of mean errors over motions and loads: worked examples, and what levels and units may not change."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from torquebench.evaluation import UnequalLengths
from torquebench.evaluation.metrics import (
    METRICS,
    heldout_gap,
    mass_argmin,
    mass_range_position,
    mass_slope_log,
    mass_slope_orientation,
    mass_slope_position,
    mass_worst_position,
    material_ratio,
    repeat_range_position,
    shape_cv,
    shape_range_orientation,
    shape_range_position,
    shape_range_rel,
    speed_exponent,
    speed_group_ratio,
    verdict_agreement,
    worst_case_orientation,
    worst_case_position,
    worst_to_mean,
)

ERRORS = np.array([[1.0, 2.0, 4.0], [2.0, 2.0, 5.0]])
MASSES = np.array([1.0, 2.0])
tables = arrays(float, (3, 4), elements=st.floats(0.01, 10.0))


def test_the_worked_example_of_three_motions_and_two_loads():
    """Ranges 3 and 3; slopes 1, 0, 1; means 7/3 and 3; worst 5."""
    assert shape_range_position(ERRORS, ERRORS) == pytest.approx(3.0)
    assert shape_range_rel(ERRORS, ERRORS) == pytest.approx(3.0 / (16.0 / 6.0))
    assert mass_slope_position(ERRORS, MASSES) == pytest.approx(2.0 / 3.0)
    assert mass_range_position(ERRORS) == pytest.approx(2.0 / 3.0)
    assert mass_worst_position(ERRORS) == pytest.approx(3.0)
    assert mass_argmin(ERRORS, MASSES) == 1.0
    assert worst_case_position(ERRORS) == 5.0
    assert worst_to_mean(ERRORS) == pytest.approx(5.0 / (16.0 / 6.0))


def test_groups_are_averaged_and_not_pooled():
    """A fast group that is uniformly worse has no range of its own."""
    assert shape_range_position(ERRORS, np.full((2, 2), 99.0)) == pytest.approx(1.5)
    assert speed_group_ratio(np.full((2, 5), 2.0), np.full((2, 3), 3.0)) == pytest.approx(1.5)


@pytest.mark.parametrize(("power", "grown"), [(0.0, 0.010), (1.0, 0.020), (2.0, 0.040)])
def test_an_error_that_grows_with_a_power_of_the_speed_shows_that_power(power, grown):
    """Friction 0, lag 1, inertia 2."""
    slower, faster = np.array([0.010, 0.010]), np.array([grown, 0.010 * (4.0 / 3.0) ** power])
    assert speed_exponent(slower, faster, np.array([2.0, 4.0 / 3.0])) == pytest.approx(power)


def test_one_speed_or_one_load_has_no_slope():
    assert math.isnan(speed_exponent(np.ones(1), np.ones(1), np.ones(1)))
    assert math.isnan(mass_slope_position(ERRORS[:1], MASSES[:1]))
    assert math.isnan(shape_cv(ERRORS[:, :1]))


def test_an_error_that_grows_by_a_share_with_each_kilogram_has_that_logarithmic_slope():
    masses = np.array([1.5, 2.5, 3.5])
    errors = 0.01 * np.exp(0.3 * masses)[:, None] * np.array([1.0, 5.0])
    assert mass_slope_log(errors, masses) == pytest.approx(0.3)


@given(tables, st.floats(0.1, 10.0))
def test_relative_figures_do_not_see_the_level_and_absolute_ones_scale_with_it(errors, level):
    """What lets controllers of different precision be compared for adaptation."""
    masses = np.array([1.5, 2.5, 3.5])
    for relative in (shape_cv, worst_to_mean, lambda e: shape_range_rel(e, e), lambda e: mass_slope_log(e, masses)):
        assert relative(level * errors) == pytest.approx(relative(errors), abs=1e-9)
    for absolute in (worst_case_position, mass_range_position, lambda e: mass_slope_position(e, masses)):
        assert absolute(level * errors) == pytest.approx(level * absolute(errors), rel=1e-6, abs=1e-9)


@given(tables)
def test_slopes_are_those_of_numpys_fit(errors):
    """An independent implementation, motion by motion."""
    masses = np.array([1.5, 2.5, 3.5])
    assert mass_slope_position(errors, masses) == pytest.approx(np.polyfit(masses, errors, 1)[0].mean(), abs=1e-9)


@given(tables, tables)
def test_a_ratio_of_geometric_means_is_the_others_inverse(a, b):
    assert material_ratio(a, b) * material_ratio(b, a) == pytest.approx(1.0)
    assert heldout_gap(a, b) == pytest.approx(material_ratio(a, b))
    assert heldout_gap(a, a) == pytest.approx(1.0)


def test_an_error_of_zero_has_no_logarithm():
    zero = np.array([[0.0, 1.0]])
    assert math.isnan(shape_cv(zero))
    assert math.isnan(material_ratio(zero, zero + 1.0))
    assert math.isnan(speed_group_ratio(zero, zero + 1.0))


def test_a_cell_that_failed_makes_the_table_failed():
    """Complete grids only: leaving the hard cells out would reward failing in them."""
    holed = np.where(ERRORS == 5.0, math.nan, ERRORS)
    assert METRICS["worst_case_position"].value_of({"errors": holed}).status == "failed"
    with pytest.raises(UnequalLengths):
        mass_slope_position(ERRORS, np.arange(3.0))


def test_repetitions_are_ranged_within_their_cell():
    """Two cells far apart, each repeated almost exactly."""
    assert repeat_range_position(np.array([[1.0, 1.1], [9.0, 9.3]])) == pytest.approx(0.2)


def test_verdicts_agree_as_often_as_they_are_equal():
    assert verdict_agreement(np.array([1, 0, -1, 1]), np.array([1, 0, 1, 1])) == 0.75


def test_attitudes_have_the_formulas_of_positions_and_units_of_their_own():
    assert shape_range_orientation(ERRORS, ERRORS) == shape_range_position(ERRORS, ERRORS)
    assert (shape_range_orientation.unit, worst_case_orientation.unit) == ("rad", "rad")
    assert mass_slope_orientation.unit == "rad/kg"
