"""Training sets: where they lie, and that they never see what they are judged on."""

import numpy as np
import pytest
from torquebench.cbmc.training.postures import closest_postures
from torquebench.cbmc.training.sets import TOOL_DOWN, arm_length, training_set, workspace_postures
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.training import load_centre, workspace_of


@pytest.fixture(scope="module")
def arm(rizon):
    return workspace_of(rizon)


@pytest.fixture(scope="module")
def postures(arm):
    return workspace_postures(arm, np.random.default_rng(3), draws=600)


def test_workspace_postures_hold_the_tool_down_within_the_limits(arm, postures):
    """Axis down and the benchmark's one yaw, everywhere."""
    poses = np.array([arm.model.flange_pose(q) for q in postures])
    np.testing.assert_allclose(poses[:, :3, :3], np.broadcast_to(TOOL_DOWN, (len(poses), 3, 3)), atol=1e-4)
    assert np.all((postures >= arm.model.lower) & (postures <= arm.model.upper))
    assert len(postures) > 300


def test_every_path_runs_through_the_workspace(arm, postures):
    """Each joint of each path stays within the range that training covers."""
    for path in arm.paths.values():
        assert np.all(path.min(axis=0) > postures.min(axis=0) - 0.1)
        assert np.all(path.max(axis=0) < postures.max(axis=0) + 0.1)


def test_the_postures_are_those_that_the_paths_take(arm):
    """Same pose, same posture: what is learnt lies on the branch that the arm will be on."""
    q = arm.paths["T1"][::200]
    poses = np.array([arm.model.flange_pose(row) for row in q])
    wish = np.broadcast_to(arm.facing(np.array([0.54, 0.0, 0.45])), q.shape)
    found, reached = closest_postures(arm.model, poses, wish)
    assert np.all(reached)
    np.testing.assert_allclose(found, q, atol=2e-3)


def test_a_pose_out_of_reach_is_left_out_and_spoils_no_other(arm):
    """All poses are solved together."""
    q = arm.paths["T1"][:2]
    poses = np.array([arm.model.flange_pose(row) for row in q])
    poses[0, :3, 3] = (3.0, 0.0, 0.0)
    _, reached = closest_postures(arm.model, poses, q.copy())
    assert reached.tolist() == [False, True]


def test_held_out_postures_are_none_that_training_sees(arm):
    """Not other noise around the same posture: another posture, drawn apart."""
    small = training_set("workspace", arm, samples=2000, rng=np.random.default_rng(1))
    assert small.q.shape == (2000, 7) and small.held_out.shape == (2000, 7)
    again = training_set("workspace", arm, samples=2000, rng=np.random.default_rng(1))
    np.testing.assert_array_equal(small.q, again.q)


def test_the_paper_trains_on_its_circles_and_tube_around_all_paths(arm):
    """The names say what was seen."""
    rng = np.random.default_rng(1)
    paper = training_set("paper", arm, samples=500, rng=rng)
    assert [len(part) for part in paper.parts] == [3000, 3000]
    tube, workspace = training_set("tube", arm, samples=500, rng=rng).parts
    assert len(tube) == len(workspace) == 250
    seen = np.concatenate(list(arm.paths.values()))[::20]
    nearest = [np.abs(seen - q).max(axis=1).min() for q in tube[:50]]
    assert max(nearest) < 0.25


def test_an_arm_that_cannot_hold_its_tool_down_learns_around_home(planar_robot):
    """Two joints have no orientation to give; its box stays within its limits."""
    arm = workspace_of(planar_robot)
    q = workspace_postures(arm, np.random.default_rng(1), draws=100)
    assert q.shape == (100, 2)
    assert np.all(np.abs(q - arm.home) <= 1.0)
    with pytest.raises(InvalidInput, match="can follow none"):
        training_set("tube", arm, samples=100, rng=np.random.default_rng(1))


def test_an_unknown_set_is_named(arm):
    """With the nearest known one."""
    with pytest.raises(UnknownName, match="did you mean 'tube'"):
        training_set("tubes", arm, samples=10, rng=np.random.default_rng(1))


def test_length_and_load_centre_of_the_rizon(rizon):
    """Shoulder at 0.155 + 0.21 m; the links' offsets add up to 1.05 m; the content's centre is the design's."""
    shoulder, length = arm_length(rizon.model())
    assert shoulder == pytest.approx(0.365)
    assert length == pytest.approx(1.048, abs=1e-3)
    assert load_centre(rizon) == pytest.approx(0.2646, abs=5e-5)
