"""ISO-style path and velocity criteria: known offsets, known scatter, and blindness to lag."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics import (
    iso_corner_overshoot,
    iso_path_accuracy,
    iso_path_accuracy_orientation,
    iso_path_repeatability,
    iso_path_repeatability_orientation,
    iso_velocity_accuracy,
    iso_velocity_fluctuation,
    iso_velocity_repeatability,
)
from torquebench.evaluation.metrics.geometry import rotation_angles, rotation_vectors

DT = 1e-2
TICKS = 400
LAP = TICKS * DT
RADIUS = 0.14


def circle(*, laps=3, delay=0.0, heights=(0.0,), scale=1.0):
    """A tool on a circle, each lap at a height of its own, and its reference."""
    row = np.arange(laps * TICKS)
    angle = 2.0 * np.pi * row / TICKS
    plan = RADIUS * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    late = angle - 2.0 * np.pi * delay / LAP
    height = np.repeat(np.resize(heights, laps), TICKS)
    tool = scale * RADIUS * np.stack([np.cos(late), np.sin(late), 0.0 * late], axis=1)
    tool[:, 2] = height
    return tool, plan


def about(axis, angle):
    """Quaternions xyzw of rotations about an axis."""
    angle = np.atleast_1d(angle)
    quat = np.zeros((len(angle), 4))
    quat[:, axis], quat[:, 3] = np.sin(angle / 2.0), np.cos(angle / 2.0)
    return quat


def test_three_laps_at_heights_of_0_0_and_3_mm_have_the_textbook_accuracy_and_repeatability():
    """The mean is 1 mm off; distances from it are 1, 1, 2 mm: mean 4/3, spread 0.57735, so 3.065384 mm."""
    tool, plan = circle(heights=(0.0, 0.0, 3e-3))
    assert iso_path_accuracy(tool, plan, DT, LAP) == pytest.approx(1e-3, rel=1e-6)
    assert iso_path_repeatability(tool, plan, DT, LAP) == pytest.approx(3.065384e-3, rel=1e-6)


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.3])
def test_the_criteria_are_blind_to_lag_along_the_path(delay):
    """A tool that is late on the right path is accurate: lag has metrics of its own."""
    tool, plan = circle(delay=delay)
    assert iso_path_accuracy(tool, plan, DT, LAP) < 1e-5
    assert iso_path_repeatability(tool, plan, DT, LAP) < 1e-5


@given(st.floats(0.9, 1.1))
def test_a_circle_too_large_is_off_by_the_difference_of_radii(scale):
    """Whichever way it errs; between ticks path and plan are chords, 4 um inside the arc."""
    tool, plan = circle(laps=2, scale=scale)
    assert iso_path_accuracy(tool, plan, DT, LAP) == pytest.approx(abs(scale - 1.0) * RADIUS, abs=1e-5)
    assert iso_path_repeatability(tool, plan, DT, LAP) < 1e-9


def test_a_turned_frame_changes_nothing():
    """Geometry does not know the base's axes."""
    tool, plan = circle(heights=(0.0, 1e-3, 3e-3), delay=0.03, scale=1.01)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    for criterion in (iso_path_accuracy, iso_path_repeatability):
        assert criterion(tool @ turn.T, plan @ turn.T, DT, LAP) == pytest.approx(criterion(tool, plan, DT, LAP))


def test_stations_are_crossed_forwards_on_a_figure_that_crosses_itself():
    """At its middle an eight passes every plane twice, once on the other branch."""
    angle = 2.0 * np.pi * np.arange(2 * TICKS) / TICKS
    plan = np.stack([0.14 * np.sin(angle), 0.07 * np.sin(2.0 * angle), 0.0 * angle], axis=1)
    late = angle - 2.0 * np.pi * 0.06 / LAP
    tool = np.stack([0.14 * np.sin(late), 0.07 * np.sin(2.0 * late), 0.002 + 0.0 * late], axis=1)
    assert iso_path_accuracy(tool, plan, DT, LAP) == pytest.approx(2e-3, abs=1e-5)


def test_less_than_two_laps_have_no_repeatability_and_less_than_one_no_accuracy():
    tool, plan = circle(laps=1)
    assert iso_path_accuracy(tool, plan, DT, LAP) < 1e-9
    assert math.isnan(iso_path_repeatability(tool, plan, DT, LAP))
    assert math.isnan(iso_path_accuracy(tool[:-50], plan[:-50], DT, LAP))


def test_a_tool_that_stays_behind_or_a_plan_that_rests_has_no_criteria():
    """No crossing is no zero: the best score for never moving would be absurd."""
    tool, plan = circle()
    assert math.isnan(iso_path_accuracy(np.zeros_like(tool), plan, DT, LAP))
    assert math.isnan(iso_path_accuracy(tool, np.zeros_like(plan), DT, LAP))


def test_a_turn_of_the_tool_is_measured_about_the_commanded_tools_axes():
    """0.02 rad about x in one lap, none in the other: 0.01 rad on average, spread 0.01 sqrt(2), three times that."""
    tool, plan = circle(laps=2)
    command = about(1, np.full(len(tool), 0.7))
    turn = about(0, np.repeat([0.0, 0.02], TICKS))
    x, y, z, w = command.T
    tx, _, _, tw = turn.T
    turned = np.stack([w * tx + x * tw, y * tw + z * tx, z * tw - y * tx, w * tw - x * tx], axis=1)
    fields = (tool, plan, turned, command, DT, LAP)
    assert iso_path_accuracy_orientation(*fields) == pytest.approx(0.01, rel=1e-6)
    assert iso_path_repeatability_orientation(*fields) == pytest.approx(0.03 * math.sqrt(2.0), rel=1e-6)
    flipped = turned * np.where(np.arange(len(tool)) % 3, 1.0, -1.0)[:, None]
    assert iso_path_accuracy_orientation(tool, plan, flipped, command, DT, LAP) == pytest.approx(0.01, rel=1e-6)


def test_rotation_vectors_agree_with_scipy_and_with_the_angles():
    """An implementation of its own must be another's, too; the library's axes are those of the reference."""
    from scipy.spatial.transform import Rotation

    quat, ref = (Rotation.random(200, rng=np.random.default_rng(seed)) for seed in (2, 3))
    ours = rotation_vectors(quat.as_quat(), ref.as_quat())
    assert ours == pytest.approx((ref.inv() * quat).as_rotvec(), abs=1e-12)
    assert np.linalg.norm(ours, axis=1) == pytest.approx(rotation_angles(quat.as_quat(), ref.as_quat()), abs=1e-12)
    assert not rotation_vectors(ref.as_quat(), ref.as_quat()).any()


def flown_at(*speeds):
    """Twists of a tool that flies each lap at a speed of its own, sideways and turning."""
    twist = np.zeros((len(speeds) * TICKS, 6))
    twist[:, 1], twist[:, 5] = np.repeat(speeds, TICKS), 3.0
    return twist


def test_a_tool_at_24_of_25_cm_a_second_is_four_per_cent_too_slow():
    assert iso_velocity_accuracy(flown_at(0.24, 0.24), flown_at(0.25, 0.25), DT, LAP) == pytest.approx(-4.0)


def test_repeatability_of_the_velocity_is_three_standard_deviations_of_the_laps():
    """0.24 and 0.26 spread by 0.01 sqrt(2): 12 sqrt(2) per cent of 0.25."""
    tool, plan = flown_at(0.24, 0.26), flown_at(0.25, 0.25)
    assert iso_velocity_repeatability(tool, plan, DT, LAP) == pytest.approx(12.0 * math.sqrt(2.0))
    assert math.isnan(iso_velocity_repeatability(tool[:TICKS], plan[:TICKS], DT, LAP))


def test_fluctuation_is_the_worst_laps_own_and_not_the_difference_between_laps():
    tool = flown_at(0.2, 0.3)
    tool[10, 1] = 0.24
    assert iso_velocity_fluctuation(tool, flown_at(0.25, 0.25), DT, LAP) == pytest.approx(0.04)


@pytest.mark.parametrize("criterion", [iso_velocity_accuracy, iso_velocity_repeatability, iso_velocity_fluctuation])
def test_a_plan_whose_speed_varies_has_no_velocity_criteria(criterion):
    """There is no commanded speed to be compared with."""
    assert math.isnan(criterion(flown_at(0.25, 0.25), flown_at(0.24, 0.26), DT, LAP))


def square_corner(*, overshoot, rest=0):
    """A right angle at (1, 0): the tool runs on along the first edge, then flies above the second."""
    edge = np.linspace(0.0, 1.0, 101)
    first, second = np.stack([edge, 0 * edge, 0 * edge], axis=1), np.stack([1 + 0 * edge, edge, 0 * edge], axis=1)
    plan = np.vstack([first, np.repeat(first[-1:], rest, axis=0), second[1:]])
    tool = plan.copy()
    tool[103:110, 0] += overshoot
    return tool, plan


@pytest.mark.parametrize("rest", [0, 20])
def test_overshoot_is_what_the_tool_runs_on_beyond_a_corner(rest):
    """Also where the plan waits in the corner, as polygons usually do."""
    assert iso_corner_overshoot(*square_corner(overshoot=0.004, rest=rest)) == pytest.approx(0.004)


def test_a_corner_that_is_cut_is_not_overshot_and_a_circle_has_none():
    assert iso_corner_overshoot(*square_corner(overshoot=-0.004)) == 0.0
    assert math.isnan(iso_corner_overshoot(*circle()))
    line = np.linspace(0.0, 1.0, 50)[:, None] * np.ones(3)
    assert math.isnan(iso_corner_overshoot(line, line))


@pytest.mark.parametrize("delay", [0.0, 0.05])
def test_a_late_tool_is_judged_on_the_same_laps_everywhere(delay):
    """Laps at 0 and 10 mm: 5 mm on average, also where the last lap crosses after the log's end and cannot count."""
    tool, plan = circle(laps=2, delay=delay)
    row = np.arange(len(tool)) - round(delay / DT)
    tool[:, 2] += np.where(row >= TICKS, 0.010, 0.0)
    assert iso_path_accuracy(tool, plan, DT, LAP) == pytest.approx(5e-3, abs=1e-5)
