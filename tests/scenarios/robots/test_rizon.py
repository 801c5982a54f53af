"""The Rizon 4s: kinematics, limits and masses of its published data, written so that every engine reads them."""

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import UnknownName
from torquebench.scenarios.axes import rotation_from_quaternion
from torquebench.scenarios.loads import Payload
from torquebench.scenarios.robots import load_robot, rizon4s

LIMITS = [
    (-2.8798, 2.8798, 2.0944, 123.0, 3.17),
    (-2.3562, 2.3562, 2.0944, 123.0, 3.17),
    (-3.0543, 3.0543, 2.4435, 64.0, 1.38),
    (-1.9548, 2.7751, 2.4435, 64.0, 1.38),
    (-3.0543, 3.0543, 4.8869, 39.0, 0.13),
    (-1.4835, 4.6251, 4.8869, 39.0, 0.13),
    (-3.0543, 3.0543, 4.8869, 39.0, 0.13),
]


def test_limits_and_rotor_inertias_are_the_published_ones(rizon):
    """Row by row: position, velocity, effort, reflected rotor inertia."""
    found = np.stack([rizon.lower, rizon.upper, rizon.velocity, rizon.effort, rizon.rotor_inertia], axis=1)
    assert np.array_equal(found, LIMITS)


def test_the_model_has_the_same_limits(rizon):
    """The text for models carries the true ones."""
    model = rizon.model()
    for name in ("lower", "upper", "velocity", "effort"):
        assert np.array_equal(getattr(model, name), getattr(rizon, name))


def test_at_home_the_flange_points_down_beside_the_base(rizon):
    """(0.687005, -0.113, 0.283579) m: the arm has a lateral offset, in which the paper's paths lie."""
    model = rizon.model()
    pose = model.flange_pose(rizon.home)
    assert np.allclose(pose[:3, 3], [0.687005, -0.113, 0.283579], rtol=0, atol=1e-6)
    assert np.allclose(pose[:3, :3], np.diag([-1.0, 1.0, -1.0]), rtol=0, atol=1e-6)
    assert np.allclose(np.rad2deg(rizon.home), [0, -40, 0, 90, 0, 40, 0], rtol=0, atol=1e-5)


def test_the_tool_is_fifteen_centimetres_beyond_the_flange(rizon):
    """Open fingers of the gripper; the flange itself is an option."""
    for tool, distance in ((rizon, 0.15), (rizon4s(tool="flange"), 0.0), (rizon4s(tool="gripper"), 0.15)):
        model = tool.model()
        between = np.linalg.inv(model.flange_pose(tool.home)) @ model.forward_kinematics(tool.home)
        assert np.allclose(between[:3, 3], [0.0, 0.0, distance], rtol=0, atol=1e-15)


def test_an_unknown_tool_names_the_known(rizon):
    """Of this robot."""
    with pytest.raises(UnknownName, match="unknown tool of robot rizon4s 'griper'; did you mean 'gripper'"):
        rizon4s(tool="griper")


@pytest.mark.parametrize(("mass", "about_axis"), [(1.186, 0.001), (3.5, 0.008254)])
def test_the_last_joint_turns_its_link_and_the_load_about_their_axis(rizon, rng, mass, about_axis):
    """The one diagonal entry that no pose changes: 0.0018 kg m^2 of the link and what hangs on the axis."""
    load = Payload(mass=mass, material="sand" if mass > 1.5 else "none")
    model = rizon.model()
    model.set_payload(sum((body.parameters for body in load.bodies(rizon)), np.zeros(10)))
    own = 1.403 * 0.0001**2
    for q in rng.uniform(rizon.lower, rizon.upper, (5, 7)):
        assert model.mass_matrix(q)[6, 6] == pytest.approx(0.0018 + own + about_axis, abs=1e-6)


def test_the_arm_weighs_what_its_links_weigh(rizon):
    """20.7 kg of arm and 1.186 kg of gripper; the base stands."""
    model = rizon.model().model
    assert sum(inertia.mass for inertia in model.inertias[1:]) == pytest.approx(16.93 + 1.186, abs=1e-9)


def test_principal_axes_stand_in_the_origin_and_the_tensor_is_diagonal(rizon):
    """A full tensor costs five digits in Bullet, which stops its diagonalisation early."""
    for inertial in ET.fromstring(rizon.urdf).iter("inertial"):
        tensor = inertial.find("inertia").attrib
        assert [float(tensor[key]) for key in ("ixy", "ixz", "iyz")] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("text", ["urdf", "simulator"])
def test_every_link_has_an_inertial_frames_a_zero_one(rizon, text):
    """A bare link weighs 1 kg in Bullet."""
    robot = ET.fromstring(rizon.urdf if text == "urdf" else rizon.simulator_urdf())
    masses = {link.get("name"): link.find("inertial/mass") for link in robot.findall("link")}
    assert all(mass is not None for mass in masses.values())
    assert float(masses["flange"].get("value")) == 0.0
    assert float(masses[rizon.tool_frame].get("value")) == 0.0


def test_the_simulators_limits_are_wide_and_its_shapes_absent(rizon):
    """The harness judges the true limits; nothing may bounce, nothing may collide."""
    robot = ET.fromstring(rizon.simulator_urdf())
    for limit in robot.iter("limit"):
        assert (float(limit.get("lower")), float(limit.get("upper"))) == (-1000.0, 1000.0)
    assert not list(robot.iter("collision"))
    assert not list(robot.iter("visual"))


def test_link_inertias_are_the_published_quaternions(rizon):
    """Axes from roll, pitch, yaw against axes from the data's quaternion, link 4's the most turned."""
    link = next(link for link in rizon.description.links if link.name == "link4")
    axes = rotation_from_quaternion(np.array([0.850968, -0.00510153, 0.0639413, 0.521285]))
    expected = axes @ np.diag([0.0186051, 0.0180531, 0.00274185]) @ axes.T
    assert np.allclose(link.body.inertia, expected, rtol=0, atol=1e-16)
    assert np.array_equal(link.body.com, [-0.0129, 0.0313, 0.1034])


def test_numbers_in_the_text_read_back_to_the_bit(rizon):
    """Models and simulators read text; what is written must be what was meant."""
    joints = {joint.get("name"): joint for joint in ET.fromstring(rizon.urdf).findall("joint")}
    for joint in rizon.description.joints:
        origin = joints[joint.name].find("origin")
        assert tuple(float(word) for word in origin.get("xyz").split()) == joint.xyz
        assert tuple(float(word) for word in origin.get("rpy").split()) == joint.rpy


def test_a_slot_hangs_on_the_flange_with_its_true_inertia(rizon, brick):
    """Written in principal axes, read back by Pinocchio as the body it was."""
    model = pin.buildModelFromXML(rizon.simulator_urdf([brick]))
    bare = pin.buildModelFromXML(rizon.simulator_urdf())
    flange = bare.frames[bare.getFrameId(rizon.flange_frame)]
    bare.appendBodyToJoint(
        flange.parentJoint, pin.Inertia(brick.mass, np.array(brick.com), np.array(brick.inertia)), flange.placement
    )
    last = flange.parentJoint
    assert np.allclose(
        model.inertias[last].toDynamicParameters(), bare.inertias[last].toDynamicParameters(), rtol=0, atol=1e-14
    )


def test_capsules_join_the_joints_and_carry_no_mass(rizon):
    """For the eye and the replay only: two spheres and a cylinder for each."""
    robot = ET.fromstring(rizon.urdf)
    capsules = rizon.description.capsules
    assert len(capsules) == 8
    assert len(list(robot.iter("visual"))) == 3 * len(capsules)
    for capsule, joint in zip(capsules, rizon.description.joints, strict=True):
        assert (capsule.link, capsule.start, capsule.end) == (joint.parent, (0.0, 0.0, 0.0), joint.xyz)


def test_a_capsules_cylinder_lies_between_its_ends(rizon):
    """Its own z axis, turned by the written angles, is the direction from end to end."""
    from torquebench.scenarios.axes import rotation_from_rpy
    from torquebench.scenarios.robots.capsules import Capsule, capsule_visuals

    capsule = Capsule(link="a", start=(0.1, 0.0, 0.0), end=(-0.2, 0.3, 0.5), radius=0.04)
    cylinder = capsule_visuals(capsule)[0]
    origin, size = cylinder.find("origin"), cylinder.find("geometry/cylinder")
    along = np.array(capsule.end) - capsule.start
    axis = rotation_from_rpy(np.array([float(word) for word in origin.get("rpy").split()]))[:, 2]
    assert np.allclose(axis, along / np.linalg.norm(along), rtol=0, atol=1e-14)
    assert float(size.get("length")) == pytest.approx(np.linalg.norm(along), abs=1e-14)
    assert np.allclose([float(w) for w in origin.get("xyz").split()], [-0.05, 0.15, 0.25], rtol=0, atol=1e-14)


def test_the_registered_arm_and_the_function_are_the_same(rizon):
    """Name, door and object."""
    assert rizon.urdf == rizon4s().urdf
    assert load_robot("torquebench.scenarios.robots:rizon4s").urdf == rizon.urdf
    assert load_robot(rizon) is rizon


def test_an_unknown_robot_names_the_nearest():
    """Before any file is looked for."""
    with pytest.raises(UnknownName, match="unknown robot 'rizon4'; did you mean 'rizon4s'"):
        load_robot("rizon4")
