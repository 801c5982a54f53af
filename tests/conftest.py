"""Physical things that tests of several rooms share: arms, loads, plants."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import settings
from torquebench.controllers import RobotModel
from torquebench.scenarios.loads import Body
from torquebench.scenarios.robots import load_robot, read_robot

# Kernels compile within a first example, so no example has a deadline; the same examples are drawn every time.
settings.register_profile("torquebench", deadline=None, derandomize=True)
settings.load_profile("torquebench")


def revolute(name, parent, child, *, axis, xyz="0 0 0", limits='lower="-3" upper="3" velocity="4" effort="80"'):
    """Return a revolute joint as URDF."""
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="0 0 0"/><axis xyz="{axis}"/><limit {limits}/></joint>'
    )


def fixed(name, parent, child, *, xyz="0 0 0"):
    """Return a fixed joint as URDF."""
    return (
        f'<joint name="{name}" type="fixed"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="0.3 -0.2 0.5"/></joint>'
    )


def rod(name, *, mass, length):
    """Return a slightly crooked rod along z as URDF."""
    across, along = mass * length**2 / 12, mass * 0.03**2 / 2
    return (
        f'<link name="{name}"><inertial><origin xyz="0.01 -0.02 {length / 2}" rpy="0 0 0"/><mass value="{mass}"/>'
        f'<inertia ixx="{across}" ixy="{0.05 * along}" ixz="0" iyy="{0.98 * across}" iyz="0" izz="{along}"/>'
        f"</inertial></link>"
    )


AXIS = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def chain_urdf(axes):
    """Return an arm of rods, one joint for each letter, with a tool turned and set off to the side."""
    names = [f"link{i}" for i in range(len(axes) + 1)]
    parts = [f'<robot name="chain{len(axes)}"><link name="link0"/>']
    for i, (parent, child) in enumerate(pairwise(names)):
        parts.append(rod(child, mass=4.0 / (i + 1), length=0.3))
        parts.append(revolute(f"joint{i + 1}", parent, child, axis=AXIS[axes[i]], xyz="0 0 0.3" if i else "0 0 0.1"))
    parts.append('<link name="flange"/><link name="tool"/>')
    parts.append(fixed("wrist", names[-1], "flange", xyz="0.02 0 0.3"))
    parts.append(fixed("hand", "flange", "tool", xyz="0.05 0.03 0.12"))
    return "".join([*parts, "</robot>"])


def point_masses_urdf():
    """Return two massless rods of 0.5 and 0.4 m in a vertical plane with 3 and 2 kg at their ends.

    At zero both hang down; angles count about -y, so that the arm swings in the plane of x and z.
    """

    def bob(name, mass, length):
        return (
            f'<link name="{name}"><inertial><origin xyz="0 0 -{length}"/><mass value="{mass}"/>'
            f'<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    return (
        '<robot name="pendulums"><link name="base"/>'
        + bob("upper", 3.0, 0.5)
        + bob("lower", 2.0, 0.4)
        + revolute("shoulder", "base", "upper", axis="0 -1 0")
        + revolute("elbow", "upper", "lower", axis="0 -1 0", xyz="0 0 -0.5")
        + '<link name="tip"/><joint name="end" type="fixed"><parent link="lower"/><child link="tip"/>'
        + '<origin xyz="0 0 -0.4"/></joint></robot>'
    )


AXES = {1: "y", 2: "yy", 6: "zyyzyz", 7: "zyzyzyz"}


@pytest.fixture(scope="session")
def urdf_of():
    """Builds the URDF of an arm from its joint axes, for example ``"zyzyzyz"``."""
    return chain_urdf


@pytest.fixture
def arm_of():
    """Builds the model of a chain of n = 1, 2, 6 or 7 rods with rotor inertia."""

    def build(n, *, rotor=0.2):
        inertia = np.full(n, rotor)
        return RobotModel(chain_urdf(AXES[n]), tool_frame="tool", flange_frame="flange", rotor_inertia=inertia)

    return build


@pytest.fixture
def double_pendulum():
    """Two point masses on massless rods, whose equations every textbook prints."""
    return RobotModel(point_masses_urdf(), tool_frame="tip", flange_frame="tip", rotor_inertia=np.zeros(2))


@pytest.fixture(scope="session")
def rizon():
    """The Rizon 4s with its gripper."""
    return load_robot("rizon4s")


@pytest.fixture(scope="session")
def planar_robot(tmp_path_factory):
    """An arm of two joints in a vertical plane, read from a bare URDF, without a gripper."""
    file = tmp_path_factory.mktemp("arms") / "planar.urdf"
    file.write_text(chain_urdf("yy"))
    return read_robot(file)


@pytest.fixture
def brick():
    """A lopsided 2 kg body beyond the flange: no axis of symmetry hides a slip in its parameters."""
    inertia = np.array([[0.02, 0.003, -0.002], [0.003, 0.03, 0.004], [-0.002, 0.004, 0.015]])
    return Body(mass=2.0, com=np.array([0.03, -0.05, 0.2]), inertia=inertia)


@pytest.fixture
def rng():
    """A generator that starts the same for every test."""
    return np.random.default_rng(20260)


@pytest.fixture(scope="session")
def has_pybullet():
    """Skips where PyBullet has no wheel: Python 3.12 and later pass without it."""
    return pytest.importorskip("pybullet")


@pytest.fixture(params=["pinocchio", "pybullet"])
def plant_name(request):
    """Each plant that this Python can run."""
    if request.param == "pybullet":
        request.getfixturevalue("has_pybullet")
    return request.param
