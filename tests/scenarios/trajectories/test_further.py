"""The sixteen further motions: drawn again they are the same, and they use at most the stated share of the arm."""

import numpy as np
import pytest
from torquebench.controllers import discovery
from torquebench.scenarios.trajectories import Plan, further_suite, load_path, suite
from torquebench.scenarios.trajectories.feasibility import check_motion
from torquebench.scenarios.trajectories.further import (
    ALLOWED,
    COUNT,
    EXTENT,
    HEIGHT,
    REACH,
    TURN,
    candidate,
    draw_further,
    inside,
    motion_of,
)
from torquebench.scenarios.trajectories.kinematics import Lap
from torquebench.training import joint_paths

NAMES = [f"M{i}" for i in range(1, 17)]


def test_drawn_again_they_are_the_same(rizon):
    """Anyone can run the rule: not one of the sixteen was picked by hand, and none was left out."""
    assert draw_further(rizon) == tuple(further_suite().values())


def test_there_are_sixteen_and_they_are_registered():
    """The data file, the functions and the entry points list the same names."""
    assert list(further_suite()) == NAMES
    assert len(NAMES) == COUNT
    assert set(NAMES) <= set(discovery.names("trajectories"))
    assert {load_path(name).group for name in NAMES} == {"further"}


@pytest.mark.parametrize("name", NAMES)
def test_each_uses_at_most_the_stated_share_of_the_arm(rizon, name):
    """At every millisecond with 3.5 kg, where the rule looked at every hundredth of a second."""
    plan = Plan.build(rizon, load_path(name), lead_in=1.0)
    check_motion(motion_of(rizon, name, Lap(q=plan.q, dq=plan.dq, ddq=plan.ddq), step=1e-3), ALLOWED)


@pytest.mark.parametrize("name", NAMES)
def test_each_is_a_closed_path_of_three_harmonics_with_the_tool_down(name):
    """Of the size and the periods of T1 to T8."""
    path = load_path(name)
    t = np.linspace(0.0, path.period, 2001)
    poses = path.pose(t)
    assert 2.0 <= path.period <= 4.0
    assert len(path.cosine) == len(path.sine) == 3
    assert np.array_equal(poses[:, :3, :3], np.tile(np.diag([-1.0, 1.0, -1.0]), (2001, 1, 1)))
    extent = np.linalg.norm(poses[:, :3, 3] - path.centre, axis=1).max()
    # Coefficients are rounded to a tenth of a millimetre.
    assert EXTENT[0] - 1e-3 < extent < EXTENT[1] + 1e-3


def test_the_space_is_the_one_that_t1_to_t8_span():
    """Each bound is reached by one of the eight to two centimetres or two degrees, and exceeded by none."""
    points = np.vstack([load_path(f"T{i}").pose(np.linspace(0.0, 4.0, 2001))[:, :3, 3] for i in range(1, 9)])
    x, y, z = points.T
    for values, (low, high), grain in (
        (np.hypot(x, y), REACH, 0.02),
        (np.rad2deg(np.arctan2(y, x)), TURN, 2.0),
        (z, HEIGHT, 0.02),
    ):
        assert low - 1e-9 <= values.min() < low + grain
        assert high - grain < values.max() <= high + 1e-9
    assert all(inside(path) for path in (*further_suite().values(), *map(load_path, ("T1", "T2", "T4", "T8"))))


def test_a_candidate_depends_on_its_own_number_only():
    """More candidates, or fewer, move none."""
    later = candidate(98)
    assert candidate(7) == candidate(7)
    assert candidate(98) == later
    assert candidate(98).cosine != candidate(99).cosine


def test_nothing_is_trained_on_them(rizon):
    """Training may draw from the paper's paths by name; a motion it has seen is no new motion."""
    assert not set(further_suite()) & (set(joint_paths(rizon)) | set(suite()))
