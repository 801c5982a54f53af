"""An arm as links and joints, and the URDF texts written from it: one for models, one for simulators.

Inertials are written in principal axes, the rotation in their origin: Bullet diagonalises a full tensor with five
digits less. Every link has an inertial, frames a zero one: Bullet gives a link without one a mass of 1 kg.
"""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...controllers import InvalidInput
from ..axes import principal_axes, rotation_from_rpy, rpy_from_rotation
from ..body import Body
from ..liquid import Liquid
from .capsules import Capsule, capsule_visuals

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)
SIMULATOR_LIMIT = 1e3
"""Position limit in the simulator's text [rad]: the harness judges the true limits, no engine may bounce off a stop."""


@dataclass(frozen=True, kw_only=True)
class Link:
    """A rigid link with its inertial in principal axes; the defaults are a frame without mass.

    Attributes:
        name: Name of the link.
        mass: Mass [kg].
        com: Centre of mass in the link frame [m].
        moments: Principal moments [kg m^2].
        rpy: Roll, pitch, yaw of the principal axes in the link frame [rad].
    """

    name: str
    mass: float = 0.0
    com: Vector = ZERO
    moments: Vector = ZERO
    rpy: Vector = ZERO

    @classmethod
    def from_body(cls, name: str, body: Body) -> "Link":
        """Return a link whose frame is the one in which a body is given."""
        moments, axes = principal_axes(body.inertia)
        return cls(
            name=name,
            mass=body.mass,
            com=vector(body.com),
            moments=vector(moments),
            rpy=vector(rpy_from_rotation(axes)),
        )

    @property
    def body(self) -> Body:
        """The link as a rigid body in its own frame."""
        axes = rotation_from_rpy(np.array(self.rpy))
        return Body(mass=self.mass, com=np.array(self.com), inertia=axes @ np.diag(self.moments) @ axes.T)


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A joint between two links; fixed if it has no limits of motion.

    Attributes:
        name: Name of the joint.
        parent: Name of the link nearer to the base.
        child: Name of the link it carries.
        xyz: Origin of the child in the parent's frame [m].
        rpy: Orientation of the child in the parent's frame [rad].
        kind: ``"fixed"``, ``"revolute"`` or ``"prismatic"``.
        axis: Unit axis in the child's frame.
        lower: Lower position limit [rad].
        upper: Upper position limit [rad].
        velocity: Velocity limit [rad/s].
        effort: Torque limit [N m].
    """

    name: str
    parent: str
    child: str
    xyz: Vector = ZERO
    rpy: Vector = ZERO
    kind: str = "fixed"
    axis: Vector = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0

    @property
    def moving(self) -> bool:
        """Whether the joint moves."""
        return self.kind != "fixed"


FREE = Joint(
    name="",
    parent="",
    child="",
    kind="revolute",
    axis=(1.0, 0.0, 0.0),
    lower=-SIMULATOR_LIMIT,
    upper=SIMULATOR_LIMIT,
    velocity=SIMULATOR_LIMIT,
    effort=SIMULATOR_LIMIT,
)
"""A joint about x that nothing limits."""


@dataclass(frozen=True, kw_only=True)
class Description:
    """A fixed-base arm: links, joints, and what the eye sees.

    Attributes:
        name: Name of the robot.
        links: The links; the base is the one that no joint carries.
        joints: The joints; the moving ones in order from the base.
        capsules: What the eye sees; neither engine nor model uses it.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    capsules: tuple[Capsule, ...] = field(default=())

    @property
    def moving(self) -> tuple[Joint, ...]:
        """The moving joints from base to flange."""
        return tuple(joint for joint in self.joints if joint.moving)

    def carrier(self, link: str) -> Joint | None:
        """Return the joint that carries a link, None for the base."""
        return next((joint for joint in self.joints if joint.child == link), None)

    def chain(self, link: str) -> tuple[Joint, ...]:
        """Return all joints from the base to a link."""
        found: list[Joint] = []
        while (joint := self.carrier(link)) is not None:
            found.insert(0, joint)
            link = joint.parent
        return tuple(found)

    def transform(self, link: str, frame: str) -> np.ndarray:
        """Return the pose of a frame link in another link, through fixed joints below it, shape (4, 4) [m].

        Raises:
            InvalidInput: If the frame does not hang rigidly below the link.
        """
        pose = np.eye(4)
        while frame != link:
            joint = self.carrier(frame)
            if joint is None or joint.moving:
                raise InvalidInput(
                    f"frame {frame!r} is not fixed to {link!r}", self.name, "use a frame beyond the flange"
                )
            step = np.eye(4)
            step[:3, :3], step[:3, 3] = rotation_from_rpy(np.array(joint.rpy)), joint.xyz
            pose, frame = step @ pose, joint.parent
        return pose

    def with_fixed(self, link: Link, *, parent: str, xyz: Vector = ZERO) -> "Description":
        """Return the description with one more link, fixed to another.

        Raises:
            InvalidInput: If a link of that name exists.
        """
        if any(link.name == other.name for other in self.links):
            raise InvalidInput(f"has a link named {link.name!r} already", self.name, "rename it")
        joint = Joint(name=f"{parent}_to_{link.name}", parent=parent, child=link.name, xyz=xyz)
        return replace(self, links=(*self.links, link), joints=(*self.joints, joint))

    def model_text(self) -> str:
        """Return the URDF with the true limits and the capsules, for models and viewers."""
        return self._text(self.capsules, widened=False)

    def simulator_text(self, *, flange: str, slots: Sequence[Body] = ()) -> str:
        """Return the URDF for a simulator: limits widened, no geometry, payload slots below the flange.

        Args:
            flange: Link that carries the slots.
            slots: Bodies in the flange frame; slot i is the link :func:`slot_name` of i, with its true mass, and a
                liquid's pendulum hangs on the joints :func:`slosh_names` of i.
        """
        # Bullet's inverse dynamics takes gravity along the base's principal axes; a fixed base needs none.
        base = next(link for link in self.links if self.carrier(link.name) is None)
        loaded = replace(self, links=tuple(replace(link, rpy=ZERO) if link is base else link for link in self.links))
        for index, body in enumerate(slots):
            loaded = loaded.with_fixed(Link.from_body(slot_name(index), body.rigid), parent=flange)
            if isinstance(body, Liquid):
                loaded = loaded._with_pendulum(body, slosh_names(index), flange)
        return loaded._text((), widened=True)

    def _with_pendulum(self, liquid: Liquid, names: tuple[str, str], flange: str) -> "Description":
        """Return the description with a liquid's two joints and its point mass; links are named as their joints."""
        about_x, about_y = names
        across = replace(FREE, name=about_x, parent=flange, child=about_x, xyz=(0.0, 0.0, liquid.hinge_z))
        along = replace(FREE, name=about_y, parent=about_x, child=about_y, axis=(0.0, 1.0, 0.0))
        bob = Link(name=about_y, mass=liquid.bob_mass, com=(0.0, 0.0, liquid.length))
        links = (*self.links, Link(name=about_x), bob)
        return replace(self, links=links, joints=(*self.joints, across, along))

    def _text(self, capsules: Sequence[Capsule], *, widened: bool) -> str:
        """Write all links and joints."""
        robot = ET.Element("robot", name=self.name)
        for link in self.links:
            element = _inertial(ET.SubElement(robot, "link", name=link.name), link)
            element.extend(visual for item in capsules if item.link == link.name for visual in capsule_visuals(item))
        for joint in self.joints:
            _joint(robot, joint, widened=widened)
        ET.indent(robot)
        return ET.tostring(robot, encoding="unicode") + "\n"


def slot_name(index: int) -> str:
    """Return the link name of a payload slot."""
    return f"payload_slot_{index}"


def slosh_names(index: int) -> tuple[str, str]:
    """Return the names of the two joints, about x and y of the flange, of the liquid in a payload slot."""
    return f"payload_slosh_x_{index}", f"payload_slosh_y_{index}"


def vector(values: Sequence[float] | np.ndarray) -> Vector:
    """Return three numbers as plain floats."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def numbers(values: Sequence[float]) -> str:
    """Return numbers as XML text that reads back to the same bits."""
    return " ".join(repr(float(value)) for value in values)


def _inertial(element: ET.Element, link: Link) -> ET.Element:
    """Write the inertial of a link and return its element."""
    inertial = ET.SubElement(element, "inertial")
    ET.SubElement(inertial, "origin", xyz=numbers(link.com), rpy=numbers(link.rpy))
    ET.SubElement(inertial, "mass", value=repr(link.mass))
    ixx, iyy, izz = (repr(moment) for moment in link.moments)
    ET.SubElement(inertial, "inertia", ixx=ixx, ixy="0.0", ixz="0.0", iyy=iyy, iyz="0.0", izz=izz)
    return element


def _joint(robot: ET.Element, joint: Joint, *, widened: bool) -> None:
    """Write one joint."""
    element = ET.SubElement(robot, "joint", name=joint.name, type=joint.kind)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    ET.SubElement(element, "origin", xyz=numbers(joint.xyz), rpy=numbers(joint.rpy))
    if joint.moving:
        lower, upper = (-SIMULATOR_LIMIT, SIMULATOR_LIMIT) if widened else (joint.lower, joint.upper)
        limits = {"lower": lower, "upper": upper, "velocity": joint.velocity, "effort": joint.effort}
        ET.SubElement(element, "axis", xyz=numbers(joint.axis))
        ET.SubElement(element, "limit", {key: repr(value) for key, value in limits.items()})
