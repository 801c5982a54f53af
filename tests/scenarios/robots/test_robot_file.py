"""Robots from TOML: beside a URDF or complete in itself, checked key by key."""

import numpy as np
import pytest
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.scenarios.robots import load_robot
from torquebench.scenarios.tiers import build_tier

ARM = """
name = "lever"
home = [0.1]
[[joints]]
name = "hinge"
parent = "base"
child = "bar"
xyz = [0, 0, 0.2]
kind = "revolute"
axis = [0, 1, 0]
lower = -1
upper = 1
velocity = 2
effort = 30
[[links]]
name = "base"
[[links]]
name = "bar"
mass = 2
com = [0, 0, 0.25]
principal = [0.04, 0.04, 0.001]
"""


@pytest.fixture
def robot(tmp_path):
    """Reads a robot from the text of a TOML file."""

    def read(text, **options):
        file = tmp_path / "lever.toml"
        file.write_text(text)
        return load_robot(str(file), **options)

    return read


def test_a_lever_of_one_joint_is_a_robot(robot):
    """m g l sin q at the hinge: nothing else is in it."""
    lever = robot(ARM)
    assert (lever.n, lever.flange_frame, lever.home.tolist()) == (1, "bar", [0.1])
    angle = np.array([0.3])
    assert lever.model().gravity(angle)[0] == pytest.approx(-2 * 9.81 * 0.25 * np.sin(0.3), abs=1e-13)


def test_the_order_of_the_tables_does_not_matter(robot):
    """Joints are rows from the base on, wherever they stand in the file."""
    second = ARM.replace('name = "hinge"', 'name = "elbow"').split("[[links]]")[0].split("[[joints]]")[1]
    elbow = second.replace('"base"', '"bar"', 1).replace('child = "bar"', 'child = "tip"').replace("30", "20")
    tip = '[[links]]\nname = "tip"\nmass = 1\nprincipal = [0.01, 0.01, 0.01]\n'
    text = ARM.replace("home = [0.1]\n", "home = [0.1, 0.2]\n[[joints]]" + elbow) + tip
    arm = robot(text)
    assert arm.joint_names == ("hinge", "elbow")
    assert arm.effort.tolist() == arm.model().effort.tolist() == [30.0, 20.0]


def test_a_toml_beside_a_urdf_adds_what_a_urdf_cannot_say(robot, tmp_path, urdf_of):
    """Home, flange, tools, gripper, rotors, tiers."""
    (tmp_path / "arm.urdf").write_text(urdf_of("yy"))
    text = """
name = "mine"
urdf = "arm.urdf"
flange_frame = "flange"
home = [0.3, -0.5]
rotor_inertia = [0.2, 0.1]
tools = {tip = 0.1, far = 0.25}
gripper = {mass = 0.5, com = [0, 0, 0.05], inertia_diag = [0.001, 0.001, 0.001]}
tiers.soft = {torque_loop_time_constant = 0.01, coulomb = [0.1, 0.2], armature_scale = 0.5}
"""
    arm = robot(text)
    assert (arm.flange_frame, arm.tool_offset, arm.gripper_mass) == ("flange", 0.1, 0.5)
    assert robot(text, tool="far").tool_offset == 0.25
    soft = build_tier("soft", arm.tiers, arm.rotor_inertia)
    assert (soft.torque_lag, soft.rotor_inertia.tolist(), soft.coulomb.tolist()) == (0.01, [0.1, 0.05], [0.1, 0.2])
    assert "actuated" in arm.tiers


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("home = [0.1]", "home = [0.1, 0.2]"), "home has 2 numbers; the arm has 1 joints"),
        (("home = [0.1]", "home = [2.0]"), "home of joint 1 is 2 rad; inside its limits"),
        (("home = [0.1]", "hom = [0.1]"), "unknown key 'hom'; did you mean 'home'"),
        (("home = [0.1]", "home = [nan]"), "home.0 = nan; .*finite number"),
        (("home = [0.1]", 'home = "up"'), "home = 'up'"),
        (("mass = 2", "mass = -2"), "links.1.mass = -2; Input should be greater than or equal to 0"),
        (("mass = 2", "mass = 0"), r"joint 'hinge' carries no mass \(link 'bar'\)"),
        (("mass = 2", "mass = true"), "links.1.mass = True"),
        (("mass = 2", 'mass = "2 kg"'), "links.1.mass = '2 kg'"),
        (("mass = 2", "mas = 2"), "unknown key 'links.1.mas'; did you mean 'mass'"),
        (("[0.04, 0.04, 0.001]", "[0.04, 0.04, 0.1]"), "link 'bar' has principal moments of 0.04, 0.04, 0.1"),
        (("[0.04, 0.04, 0.001]", "[0.04, 0.04]"), "links.1.principal"),
        (("[0.04, 0.04, 0.001]", "[0.04, 0.04, -0.001]"), "links.1.principal.2 = -0.001"),
        (('kind = "revolute"', 'kind = "revolut"'), "joints.0.kind = 'revolut'; .*'fixed', 'revolute' or 'prismatic'"),
        (("axis = [0, 1, 0]", "axis = [0, 2, 0]"), "joint 'hinge' has an axis of length 2; expected length 1"),
        (("effort = 30", "effort = 0"), "joint 'hinge' has effort 0 and velocity 2; both limits are positive"),
        (("lower = -1", "lower = 1"), "joint 'hinge' has limits 1 and 1; expected lower below upper"),
        (('child = "bar"', 'child = "rod"'), "joint 'hinge' names a link 'rod' that is not there"),
        (('child = "bar"\n', ""), "key 'joints.0.child' is missing"),
        (("[[links]]\n", "[[links]]\nquat_wxyz = [0, 0, 0, 0]\n"), "link 'base' has a quaternion of length zero"),
        (("[[links]]\n", "[[links]]\nquat_wxyz = [1, 0, 0]\n"), "links.0.quat_wxyz"),
        (('name = "lever"', 'name = "lever'), "malformed TOML"),
        (('name = "lever"', 'name = "lever"\nurdf = "arm.urdf"'), "needs either 'urdf' or 'links' and 'joints'"),
        (('name = "lever"', 'name = "lever"\ntools = {}'), "tools = {}"),
        (('name = "lever"', 'name = "lever"\ncontainer = {mass = 0}'), "container.mass = 0; "),
        (('name = "lever"', 'name = "lever"\nrotor_inertia = [1, 2]'), "rotor_inertia has 2 numbers"),
        (('name = "lever"', 'name = "lever"\ntiers.mine = {coulomb = [1, 2]}'), "tiers.mine.coulomb has 2 numbers"),
        (('name = "lever"', 'name = "lever"\ntiers.mine = {ft_noise_sigma = [1]}'), "ft_noise_sigma has 1 numbers.*6"),
        (('name = "lever"', 'name = "lever"\ntiers.mine = {delay_ticks = -1}'), "tiers.mine.delay_ticks = -1"),
        (('name = "lever"', 'name = "lever"\ntiers.mine = {delay_tick = 1}'), "did you mean 'delay_ticks'"),
        (('name = "lever"', 'name = "lever"\ntiers.mine = {coulomb_velocity_scale = 0}'), "greater than 0"),
    ],
)
def test_a_wrong_line_is_named_with_what_would_be_right(robot, change, message):
    """The key, the value, the nearest valid choice; always one line with the file's name in front."""
    assert change[0] in ARM
    with pytest.raises(InvalidInput, match=message) as caught:
        robot(ARM.replace(*change, 1))
    assert "\n" not in str(caught.value)
    assert "lever.toml: " in str(caught.value)


def test_an_unknown_flange_names_the_nearest_link(robot):
    """Typed by hand."""
    with pytest.raises(UnknownName, match=r"unknown flange_frame in lever.toml 'ba'; did you mean 'bar'"):
        robot(ARM.replace('name = "lever"', 'name = "lever"\nflange_frame = "ba"', 1))


def test_an_empty_file_describes_no_arm(robot):
    """Its first missing key."""
    with pytest.raises(InvalidInput, match="key 'name' is missing"):
        robot("")


def test_a_door_that_leads_to_no_robot_is_refused():
    """A function of the right name that returns something else."""
    with pytest.raises(InvalidInput, match="is a dict, no robot"):
        load_robot("builtins:dict")
