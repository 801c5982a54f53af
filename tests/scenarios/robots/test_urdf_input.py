"""A URDF of one's own: read to the digit, or refused in one line that says what and where."""

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import InvalidInput, TorquebenchError
from torquebench.scenarios.robots import load_robot, parse_urdf

INERTIAL = '<inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>'
LIMIT = '<limit lower="-1" upper="2" velocity="3" effort="50"/>'


def link(name, inertial=INERTIAL):
    """Return a link."""
    return f'<link name="{name}">{inertial}</link>'


def joint(name, parent, child, *, kind="revolute", inside='<axis xyz="0 1 0"/>' + LIMIT):
    """Return a joint."""
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 0.3"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def arm(*parts):
    """Return a robot."""
    return f'<robot name="arm">{"".join(parts)}</robot>'


GOOD = arm(link("base", ""), link("upper"), joint("shoulder", "base", "upper"))


@pytest.fixture
def saved(tmp_path):
    """Writes a text to a URDF file."""

    def save(text, name="arm.urdf"):
        file = tmp_path / name
        file.write_text(text)
        return str(file)

    return save


def test_a_bare_urdf_is_a_robot(saved):
    """Defaults for all it does not say: middle of the limits, tool at the last link, no gripper, every tier."""
    robot = load_robot(saved(GOOD))
    assert (robot.name, robot.n, robot.flange_frame, robot.tool_offset) == ("arm", 1, "upper", 0.0)
    assert robot.home.tolist() == [0.5]
    assert robot.gripper is None
    assert set(robot.tiers) == {"ideal", "actuated", "tight_rate", "elastic", "paper_bullet"}
    assert not robot.rotor_inertia.any()


def test_a_urdf_read_and_written_has_the_same_dynamics(saved, urdf_of, rng):
    """Tensors are turned into principal axes; torque and inertia do not change by that."""
    original = pin.buildModelFromXML(urdf_of("zyyzyz"))
    written = load_robot(saved(urdf_of("zyyzyz"))).model().model
    one, two = original.createData(), written.createData()
    for _ in range(20):
        q, dq, ddq = rng.uniform(-2, 2, 6), rng.normal(size=6), rng.normal(size=6)
        expected = pin.rnea(original, one, q, dq, ddq)
        assert np.allclose(pin.rnea(written, two, q, dq, ddq), expected, rtol=0, atol=1e-11)


BRANCHES = {
    "depth first": [("j1", "base", "a"), ("j2", "a", "b"), ("j3", "a", "c"), ("j4", "b", "d")],
    "written backwards": [("j3", "b", "c"), ("j2", "a", "b"), ("j1", "base", "a")],
    "named backwards": [("j9", "base", "a"), ("j5", "a", "b"), ("j1", "b", "c")],
    "siblings by name": [("root", "base", "a"), ("z", "a", "b"), ("y", "a", "c"), ("x", "b", "d")],
    "fixed between": [("j2", "f", "b"), ("fix", "a", "f"), ("j1", "base", "a"), ("j0", "a", "c")],
}


@pytest.mark.parametrize("edges", BRANCHES.values(), ids=BRANCHES)
def test_joints_come_in_the_models_order_however_the_tree_grows(saved, edges):
    """Limits and torques are rows by joint: an order of one's own would put one joint's limit on another."""
    links = [link("base", ""), *(link(child) for _, _, child in edges)]
    efforts = {name: 10.0 + i for i, (name, _, _) in enumerate(edges)}
    joints = [
        joint(name, parent, child, kind="fixed", inside="")
        if name == "fix"
        else joint(name, parent, child, inside=f'<axis xyz="0 1 0"/>{LIMIT.replace("50", str(efforts[name]))}')
        for name, parent, child in edges
    ]
    robot = load_robot(saved(arm(*links, *joints)))
    model = robot.model()
    assert list(robot.joint_names) == list(model.model.names)[1:]
    assert np.array_equal(robot.effort, model.effort)


def test_a_continuous_joint_gets_wide_limits(saved):
    """One coordinate, as every law here counts on; the name of its kind does not survive."""
    inside = '<axis xyz="0 0 1"/><limit velocity="3" effort="50"/>'
    text = arm(link("base"), link("upper"), joint("turn", "base", "upper", kind="continuous", inside=inside))
    robot = load_robot(saved(text))
    assert (robot.lower[0], robot.upper[0], robot.home[0]) == (-1000.0, 1000.0, 0.0)
    assert robot.model().n == 1


def test_a_sliding_joint_stays_one(saved):
    """Gantries are arms too."""
    text = arm(link("base"), link("upper"), joint("rail", "base", "upper", kind="prismatic"))
    assert np.array_equal(load_robot(saved(text)).model().jacobian(np.zeros(1))[:, 0], [0, 1, 0, 0, 0, 0])


def test_an_axis_of_any_length_is_a_direction(saved):
    """Some exporters write (0, 0, 2)."""
    text = GOOD.replace('xyz="0 1 0"', 'xyz="0 3 0"')
    assert load_robot(saved(text)).description.moving[0].axis == (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot><oops", "malformed XML .*; expected a URDF"),
        ("<mujoco/>", "root element <mujoco>; expected <robot>; expand xacro files first"),
        (arm(), "has 0 base links"),
        (arm(link("base")), "has no moving joint; expected joints of type revolute, continuous, prismatic"),
        (arm(link("base"), link("base")), "link 'base' is defined twice"),
        (
            arm(link("base"), link("a"), link("b"), joint("j", "base", "a"), joint("j", "a", "b")),
            "joint 'j' is defined twice",
        ),
        (arm(link("base"), link("loose"), link("a"), joint("j", "base", "a")), r"has 2 base links \(base, loose\)"),
        (
            arm(link("base"), link("a"), link("b"), joint("j", "base", "a"), joint("k", "b", "a")),
            "link 'a' is carried by two joints",
        ),
        (
            arm(
                link("base"),
                link("a"),
                link("b"),
                link("c"),
                joint("j", "base", "a"),
                joint("k", "b", "c"),
                joint("l", "c", "b"),
            ),
            "link 'b' hangs in a loop; expected a tree",
        ),
        (arm(link("base"), joint("j", "base", "ghost")), "joint 'j' names a link 'ghost' that is not there"),
        (
            arm(link("world", ""), link("base"), joint("free", "world", "base", kind="floating", inside="")),
            "joint 'free' is of type 'floating'; expected a fixed base and joints of type",
        ),
        (
            arm(link("base"), link("a"), joint("j", "base", "a", kind="planar")),
            "joint 'j' is of type 'planar'",
        ),
        (arm(link("base"), link("a", ""), joint("j", "base", "a")), "moving link 'a' has no <inertial>"),
        (GOOD.replace('value="2"', 'value="0"'), "joint 'shoulder' carries no mass .*; masses of moving links"),
        (GOOD.replace('value="2"', 'value="-2"'), "link 'upper' has a mass of -2 kg; masses are not negative"),
        (GOOD.replace('value="2"', 'value="nan"'), "mass of link 'upper' is 'nan'; expected 1 finite number"),
        (GOOD.replace('value="2"', 'value="2 kg"'), "mass of link 'upper' is '2 kg'"),
        (GOOD.replace('<mass value="2"/>', ""), "mass of link 'upper' has no value"),
        (GOOD.replace('izz="0.1"', 'izz="-0.1"'), "principal moment of -0.1 kg m.2; moments are not negative"),
        (GOOD.replace('izz="0.1"', 'izz="0.3"'), "principal moments of 0.1, 0.1, 0.3 kg m.2; no body has one above"),
        (GOOD.replace('ixx="0.1"', ""), "inertia of link 'upper' has no ixx"),
        (GOOD.replace('<inertia ixx="0.1" iyy="0.1" izz="0.1"/>', ""), "link 'upper' has no <inertia>"),
        (GOOD.replace(LIMIT, ""), "joint 'shoulder' has no <limit>; give effort and velocity"),
        (GOOD.replace('effort="50"', 'effort="0"'), "joint 'shoulder' has effort 0 and velocity 3; both limits"),
        (GOOD.replace('velocity="3"', ""), "velocity limit of joint 'shoulder' has no velocity"),
        (GOOD.replace('lower="-1"', 'lower="5"'), "joint 'shoulder' has limits 5 and 2; expected lower below upper"),
        (GOOD.replace('xyz="0 1 0"', 'xyz="0 0 0"'), "joint 'shoulder' has an axis of length zero"),
        (GOOD.replace('xyz="0 1 0"', 'xyz="0 1"'), "axis of joint 'shoulder' is '0 1'; expected 3 finite numbers"),
        (GOOD.replace('xyz="0 0 0.3"', 'xyz="0 0 inf"'), "origin of joint 'shoulder' is '0 0 inf'"),
        (GOOD.replace("</joint>", '<mimic joint="other"/></joint>'), "joint 'shoulder' mimics another; make it fixed"),
        (GOOD.replace('<parent link="base"/>', ""), "<parent> of joint 'shoulder' has no link"),
        (GOOD.replace('type="revolute"', ""), "joint 'shoulder' has no type"),
        (GOOD.replace('<joint name="shoulder"', "<joint"), "a joint has no name"),
    ],
)
def test_what_cannot_be_simulated_is_refused_in_one_line(text, message):
    """It names the link or joint, what came, and what would be valid."""
    with pytest.raises(InvalidInput, match=message) as caught:
        parse_urdf(text, where="mine.urdf")
    assert str(caught.value).startswith("mine.urdf: ")
    assert "\n" not in str(caught.value)


def test_a_missing_urdf_is_named_with_its_path(tmp_path):
    """The path that was looked for."""
    with pytest.raises(InvalidInput, match=r"nowhere.urdf: cannot read the URDF .No such file"):
        load_robot(str(tmp_path / "nowhere.urdf"))


def test_a_urdf_that_is_no_text_is_refused(tmp_path):
    """A mesh or an archive under the wrong name."""
    file = tmp_path / "arm.urdf"
    file.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InvalidInput, match=r"cannot read the URDF .not UTF-8 text"):
        load_robot(str(file))


def test_a_folder_is_no_urdf(tmp_path):
    """One line, as for everything."""
    (tmp_path / "arm.urdf").mkdir()
    with pytest.raises(TorquebenchError, match="cannot read the URDF"):
        load_robot(str(tmp_path / "arm.urdf"))
