"""Jerk, log dimensionless jerk and spectral arc length: published values and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics import jerk_ratio, ldlj, log_dimensionless_jerk, sparc, spectral_arc_length
from torquebench.evaluation.rows import Reading, RunRow, read

DT = 1e-3
T = np.arange(4000) * DT
BELL = np.exp(-5.0 * np.arange(-1.0, 1.0, 0.01) ** 2)
"""The speed profile of the reference implementation's own example, at 100 Hz."""


def circle(frequency=0.25, ripple=0.0):
    """A path around a circle of 0.14 m, with a vertical ripple at 5 Hz."""
    angle = 2.0 * np.pi * frequency * T
    return np.stack([0.14 * np.cos(angle), 0.14 * np.sin(angle), ripple * np.sin(2.0 * np.pi * 5.0 * T)], axis=1)


def twist_of(speed):
    """A tool that flies sideways at a speed and turns meanwhile."""
    return np.column_stack([0 * speed, speed, 0 * speed, 0 * speed, np.ones_like(speed), 0 * speed])


def test_a_tool_on_its_path_is_as_smooth_as_it_and_late_is_not_rough():
    path = circle()
    assert jerk_ratio(path, path, DT) == 1.0
    assert jerk_ratio(np.roll(path, 30, axis=0), path, DT) == pytest.approx(1.0, rel=1e-6)
    assert jerk_ratio(2.0 * path, path, DT) == pytest.approx(2.0)


def test_the_ratio_of_a_ripple_is_that_of_the_cubes_of_the_frequencies():
    """Jerk is amplitude times frequency cubed; the filter takes a little of the 5 Hz, nothing of 0.25 Hz."""
    ripple, plan = 1e-3 * (2.0 * np.pi * 5.0) ** 3 / math.sqrt(2.0), 0.14 * (2.0 * np.pi * 0.25) ** 3
    assert jerk_ratio(circle(ripple=1e-3), circle(), DT) == pytest.approx(math.hypot(1.0, ripple / plan), rel=0.05)


def test_a_straight_line_has_no_jerk_to_divide_by_and_a_short_log_no_filter():
    line = T[:, None] * np.array([0.1, 0.0, 0.0])
    assert math.isnan(jerk_ratio(circle(), line, DT))
    assert math.isnan(jerk_ratio(circle()[:50], circle()[:50], DT))


def test_the_bell_of_the_reference_implementation_has_its_values():
    """siva82kb/SPARC prints -1.41403 and -5.81636 for it."""
    assert spectral_arc_length(BELL, 0.01) == pytest.approx(-1.41403, abs=1e-5)
    assert log_dimensionless_jerk(BELL, 0.01) == pytest.approx(-5.81636, abs=1e-5)


def test_the_smoothest_movement_comes_near_its_closed_form():
    """-ln(720 / (15/8)^2) = -5.32203 for minimum jerk; 1 kHz samples of it give -5.31205."""
    s = np.arange(0.0, 1.0, 1e-3)
    value = log_dimensionless_jerk(30.0 * s**2 * (1.0 - s) ** 2, 1e-3)
    assert value == pytest.approx(-5.31205, abs=1e-5)
    assert value == pytest.approx(-math.log(720.0 / (15.0 / 8.0) ** 2), abs=0.02)


@given(st.floats(0.01, 100.0))
def test_both_are_free_of_the_size_of_a_movement(size):
    """Dimensionless: twice as fast everywhere is as smooth."""
    assert spectral_arc_length(size * BELL, 0.01) == pytest.approx(spectral_arc_length(BELL, 0.01))
    assert log_dimensionless_jerk(size * BELL, 0.01) == pytest.approx(log_dimensionless_jerk(BELL, 0.01))


def test_the_arc_length_does_not_see_a_ripple_of_five_per_cent_on_a_circle():
    """Why it is exploratory on cyclic paths: the ripple is below its amplitude threshold; one of 12 % is not."""
    plain, small, large = (
        sparc(twist_of(0.2 * (1.0 + share * np.sin(2.0 * np.pi * 5.0 * T))), DT) for share in (0.0, 0.05, 0.12)
    )
    assert small == pytest.approx(plain, abs=0.02)
    assert large < plain - 0.3


def test_the_tools_speed_is_that_of_its_linear_velocity():
    """Turning on the spot is no movement here, and rest has no smoothness."""
    assert ldlj(twist_of(BELL), 0.01) == pytest.approx(log_dimensionless_jerk(BELL, 0.01))
    assert sparc(twist_of(BELL), 0.01) == pytest.approx(spectral_arc_length(BELL, 0.01))
    for metric in (ldlj, sparc):
        assert math.isnan(metric(twist_of(0.0 * BELL), 0.01))


@pytest.mark.parametrize("metric", [ldlj, sparc], ids=lambda metric: metric.id)
def test_negative_scores_are_compared_by_nobody(metric):
    """Comparisons take magnitudes and ratios: of two negative scores they would call the rougher tool the better."""
    stored = metric.value_of({"twist": twist_of(BELL), "dt": 0.01}).as_dict()
    row = RunRow(
        controller="a / none", trajectory="T1", group="", mass=1.5, material="", repetition=0, status="ok",
        metrics={"run": {metric.id: stored}},
    )  # fmt: skip
    assert stored["value"] < 0.0
    assert read(row, metric, "run") == Reading(None, "undefined")
