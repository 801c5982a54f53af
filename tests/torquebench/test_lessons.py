"""What training is told of robots, loads and paths: each figure recomputed from the arm itself."""

import hashlib

import numpy as np
import pytest
from torquebench.cbmc.training import PRESETS
from torquebench.scenarios.loads import Payload
from torquebench.scenarios.trajectories import Plan, load_path, suite
from torquebench.training import CIRCLES, joint_paths, lesson_for, load_centre, workspace_of


@pytest.fixture(scope="module")
def paths(rizon):
    """The joint paths of every motion of the suite."""
    return joint_paths(rizon)


def test_every_motion_of_the_suite_is_a_path_of_the_arm_that_it_was_made_for(rizon, paths):
    """A motion that training could not follow would be judged without ever being named."""
    assert set(paths) == set(suite())
    for path in paths.values():
        assert path.shape[1] == rizon.n
        assert np.all((path >= rizon.lower) & (path <= rizon.upper))


def test_a_path_is_the_plan_of_a_run_on_that_motion(rizon, paths):
    """What is learnt lies where the arm will be: the very joint positions of the benchmark."""
    plan = Plan.build(rizon, load_path("T6"), lead_in=1.0)
    assert np.array_equal(paths["T6"], plan.q)


def test_an_arm_that_cannot_follow_a_motion_is_judged_on_what_it_can(planar_robot):
    """Two joints have no orientation to give; that is no reason to train nothing."""
    assert joint_paths(planar_robot) == {}
    assert workspace_of(planar_robot).circles == {}


def test_the_circles_of_the_paper_are_among_the_paths(rizon, paths):
    """Horizontal and inclined, by their names in the suite."""
    arm = workspace_of(rizon)
    assert tuple(arm.circles) == CIRCLES
    for name in CIRCLES:
        assert np.array_equal(arm.circles[name], paths[name])


def test_a_workspace_holds_arm_and_gripper_without_any_load(rizon):
    """The load is what is to be learnt; a model that has it already would be taught it twice."""
    arm = workspace_of(rizon)
    assert np.all(arm.model.payload == 0.0)
    assert np.array_equal(arm.home, rizon.home)


def test_an_arm_faces_a_point_on_the_side_of_the_point(rizon):
    """The first joint turns towards it; left and right of the arm mirror each other."""
    facing = workspace_of(rizon).facing
    left, right = facing(np.array([0.4, 0.3, 0.4])), facing(np.array([0.4, -0.3, 0.4]))
    assert left[0] == pytest.approx(-right[0], abs=1e-6)
    assert left[0] != pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("mass", [2.5, 3.5])
def test_the_load_centre_lies_between_those_of_the_loads(rizon, mass):
    """One centre stands for all contents: never outside container and sand by more than two centimetres."""
    bodies = Payload(mass=mass, material="sand").bodies(rizon)
    total = sum(body.mass for body in bodies)
    centre = sum(body.mass * body.com[2] for body in bodies) / total
    assert load_centre(rizon) == pytest.approx(centre, abs=0.02)


def test_the_load_centre_is_that_of_two_kilograms_of_sand(rizon):
    """A cylinder on the bottom of the container, which hangs away from the flange: half its height nearer to it."""
    from torquebench.scenarios.materials import SAND_DENSITY

    container = rizon.container
    height = 2.0 / (SAND_DENSITY * np.pi * container.inner_radius**2)
    assert load_centre(rizon) == pytest.approx(container.bottom_z - height / 2.0, abs=5e-5)


@pytest.mark.parametrize(("preset", "own"), [("smoke", "workspace"), ("default", "workspace"), ("paper", "paper")])
def test_a_preset_without_a_set_takes_its_own(rizon, preset, own):
    """The paper's recipe on another set would not be the paper's."""
    lesson = lesson_for(rizon, loads=(0.0, 3.0), training_set="", preset=preset, seed=1)
    assert lesson.training_set == own
    assert (PRESETS[preset].optimiser == "sgd") == (own == "paper")


def test_a_set_that_was_asked_for_is_kept(rizon):
    """Whoever names both means both."""
    lesson = lesson_for(rizon, loads=(0.0,), training_set="tube", preset="paper", seed=4)
    assert (lesson.training_set, lesson.preset, lesson.seed, lesson.loads) == ("tube", "paper", 4, (0.0,))


def test_a_lesson_knows_the_arm_by_the_hash_of_its_description(rizon, planar_robot):
    """Patterns of another arm are refused by it: the name alone can be anybody's."""
    for robot in (rizon, planar_robot):
        lesson = lesson_for(robot, loads=(0.0,), training_set="", preset="smoke", seed=1)
        assert lesson.robot == robot.name
        assert lesson.urdf_digest == hashlib.sha256(robot.urdf.encode()).hexdigest()
        assert lesson.load_centre == load_centre(robot)
