"""Reads a fixed-base URDF of any number of joints and says in one line what is wrong with it.

Meshes, visuals and collision shapes are dropped, tensors are turned into principal axes, continuous joints get wide
limits, and a fixed link without an inertial counts as massless. Joint damping and friction of the URDF are dropped
too: they are constants of a tier.
"""

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...controllers import InvalidInput
from ..axes import principal_axes, rotation_from_rpy, rpy_from_rotation
from .description import SIMULATOR_LIMIT, ZERO, Description, Joint, Link, Vector, vector

MOVING_KINDS = ("revolute", "continuous", "prismatic")


def read_urdf(file: Path) -> Description:
    """Read a URDF file.

    Args:
        file: The URDF.

    Raises:
        InvalidInput: If it is missing, malformed, no fixed-base tree, or a moving link has no inertial.
    """
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as cause:
        reason = getattr(cause, "strerror", None) or "not UTF-8 text"
        raise InvalidInput(f"cannot read the URDF ({reason})", str(file), "expected a URDF file") from cause
    return parse_urdf(text, where=file.name)


def parse_urdf(text: str, *, where: str = "URDF") -> Description:
    """Read the text of a URDF.

    Args:
        text: The XML.
        where: How messages call it.

    Raises:
        InvalidInput: If it is malformed, no fixed-base tree, or a moving link has no inertial.
    """
    try:
        robot = ET.fromstring(text)
    except ET.ParseError as cause:
        raise InvalidInput(f"malformed XML ({cause})", where, "expected a URDF") from cause
    if robot.tag != "robot":
        raise InvalidInput(f"root element <{robot.tag}>", where, "expected <robot>; expand xacro files first")
    joints = tuple(_joint(element, where) for element in robot.findall("joint"))
    moved = {joint.child for joint in joints if joint.moving}
    links = tuple(_link(element, where, moving=element.get("name") in moved) for element in robot.findall("link"))
    description = Description(name=robot.get("name") or where, links=links, joints=joints)
    check_tree(description, where)
    return replace(description, joints=from_base(description))


def check_tree(description: Description, where: str) -> None:
    """Check that links and joints are one tree on a fixed base whose every moving part has mass.

    Args:
        description: The links and joints.
        where: How messages call them.

    Raises:
        InvalidInput: If they are not; the message names the link or joint.
    """
    names = [link.name for link in description.links]
    children = [joint.child for joint in description.joints]
    for what, listed in (("link", names), ("joint", [joint.name for joint in description.joints])):
        if twice := _repeated(listed):
            raise InvalidInput(f"{what} {twice!r} is defined twice", where, "names must be unique")
    if twice := _repeated(children):
        raise InvalidInput(f"link {twice!r} is carried by two joints", where, "expected a tree")
    for joint in description.joints:
        for end in (joint.parent, joint.child):
            if end not in names:
                raise InvalidInput(f"joint {joint.name!r} names a link {end!r} that is not there", where)
    roots = [name for name in names if name not in children]
    if len(roots) != 1:
        bases = ", ".join(roots) or "none"
        raise InvalidInput(f"has {len(roots)} base links ({bases})", where, "expected one tree on one base link")
    reached = {roots[0], *(joint.child for joint in from_base(description))}
    if loose := [name for name in names if name not in reached]:
        raise InvalidInput(f"link {loose[0]!r} hangs in a loop", where, "expected a tree")
    _check_drives(description, where)
    _check_moments(description, where)
    _check_masses(description, where)


def _check_drives(description: Description, where: str) -> None:
    """Check axes and limits of the moving joints."""
    for joint in description.moving:
        what = f"joint {joint.name!r}"
        if abs(np.linalg.norm(joint.axis) - 1.0) > 1e-9:
            raise InvalidInput(
                f"{what} has an axis of length {np.linalg.norm(joint.axis):g}", where, "expected length 1"
            )
        if not (joint.effort > 0 and joint.velocity > 0):
            came = f"{what} has effort {joint.effort:g} and velocity {joint.velocity:g}"
            raise InvalidInput(came, where, "both limits are positive")
        if not joint.lower < joint.upper:
            raise InvalidInput(
                f"{what} has limits {joint.lower:g} and {joint.upper:g}", where, "expected lower below upper"
            )


def _check_moments(description: Description, where: str) -> None:
    """Check that inertias belong to bodies: Bullet sets those that do not to zero, without a word."""
    for link in description.links:
        if 2.0 * max(link.moments) > sum(link.moments) * (1.0 + 1e-9):
            listed = ", ".join(f"{moment:g}" for moment in sorted(link.moments))
            came = f"link {link.name!r} has principal moments of {listed} kg m^2"
            raise InvalidInput(came, where, "no body has one above the sum of the other two")


def _check_masses(description: Description, where: str) -> None:
    """Check that no moving joint carries nothing."""
    if not description.moving:
        raise InvalidInput("has no moving joint", where, f"expected joints of type {', '.join(MOVING_KINDS)}")
    carried = dict.fromkeys((joint.name for joint in description.joints), 0.0)
    for link in description.links:
        for joint in description.chain(link.name):
            carried[joint.name] += link.mass
    for joint in description.moving:
        if carried[joint.name] <= 0:
            raise InvalidInput(
                f"joint {joint.name!r} carries no mass (link {joint.child!r})",
                where,
                "masses of moving links are positive",
            )


def _repeated(names: list[str]) -> str | None:
    return next((name for name, count in Counter(names).items() if count > 1), None)


def from_base(description: Description) -> tuple[Joint, ...]:
    """Return the joints that hang on the base in Pinocchio's order: branch after branch, siblings by name.

    Args:
        description: The links and joints.
    """
    children = {joint.child for joint in description.joints}
    by_name = sorted(description.joints, key=lambda joint: joint.name, reverse=True)
    base = next((link.name for link in description.links if link.name not in children), None)
    ordered: list[Joint] = []
    waiting = [joint for joint in by_name if joint.parent == base]
    while waiting:
        ordered.append(waiting.pop())
        waiting += [joint for joint in by_name if joint.parent == ordered[-1].child]
    return tuple(ordered)


def _link(element: ET.Element, where: str, *, moving: bool) -> Link:
    """Read a link; a fixed one without an inertial is a massless frame."""
    name = _attribute(element, "name", where, "a link")
    inertial, what = element.find("inertial"), f"link {name!r}"
    if inertial is None:
        if moving:
            raise InvalidInput(f"moving {what} has no <inertial>", where, "give its mass and inertia")
        return Link(name=name)
    mass = _number(inertial.find("mass"), "value", where, f"mass of {what}")
    if mass < 0:
        raise InvalidInput(f"{what} has a mass of {mass:g} kg", where, "masses are not negative")
    tensor = inertial.find("inertia")
    if tensor is None:
        raise InvalidInput(f"{what} has no <inertia>", where, "give ixx, ixy, ixz, iyy, iyz, izz")
    xx, yy, zz = (_number(tensor, key, where, f"inertia of {what}") for key in ("ixx", "iyy", "izz"))
    xy, xz, yz = (_number(tensor, key, where, f"inertia of {what}", default=0.0) for key in ("ixy", "ixz", "iyz"))
    moments, axes = principal_axes(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    if np.any(moments < 0):
        raise InvalidInput(
            f"{what} has a principal moment of {moments.min():g} kg m^2", where, "moments are not negative"
        )
    com, rpy = _origin(inertial, where, what)
    if xy or xz or yz:
        rpy = vector(rpy_from_rotation(rotation_from_rpy(np.array(rpy)) @ axes))
    return Link(name=name, mass=mass, com=com, moments=vector(moments), rpy=rpy)


def _joint(element: ET.Element, where: str) -> Joint:
    """Read a joint."""
    name = _attribute(element, "name", where, "a joint")
    what = f"joint {name!r}"
    kind = _attribute(element, "type", where, what)
    parent, child = (_attribute(element.find(end), "link", where, f"<{end}> of {what}") for end in ("parent", "child"))
    xyz, rpy = _origin(element, where, what)
    if kind == "fixed":
        return Joint(name=name, parent=parent, child=child, xyz=xyz, rpy=rpy)
    if kind not in MOVING_KINDS:
        valid = f"expected a fixed base and joints of type {', '.join((*MOVING_KINDS, 'fixed'))}"
        raise InvalidInput(f"{what} is of type {kind!r}", where, valid)
    if element.find("mimic") is not None:
        raise InvalidInput(
            f"{what} mimics another", where, "make it fixed: a joint here is driven by a torque of its own"
        )
    axis_element = element.find("axis")
    axis = (1.0, 0.0, 0.0) if axis_element is None else _vector(axis_element, "xyz", where, f"axis of {what}")
    length = float(np.linalg.norm(axis))
    if length == 0:
        raise InvalidInput(f"{what} has an axis of length zero", where, "expected a direction")
    limit = element.find("limit")
    if limit is None:
        raise InvalidInput(
            f"{what} has no <limit>", where, "give effort and velocity, and lower and upper unless continuous"
        )
    effort, velocity = (_number(limit, key, where, f"{key} limit of {what}") for key in ("effort", "velocity"))
    lower, upper = -SIMULATOR_LIMIT, SIMULATOR_LIMIT
    if kind != "continuous":
        lower, upper = (_number(limit, key, where, f"{key} limit of {what}", default=0.0) for key in ("lower", "upper"))
    return Joint(
        name=name,
        parent=parent,
        child=child,
        xyz=xyz,
        rpy=rpy,
        kind="prismatic" if kind == "prismatic" else "revolute",
        axis=axis if length == 1 else vector(np.array(axis) / length),
        lower=lower,
        upper=upper,
        velocity=velocity,
        effort=effort,
    )


def _origin(element: ET.Element, where: str, what: str) -> tuple[Vector, Vector]:
    """Read position and orientation, zero where absent."""
    origin = element.find("origin")
    if origin is None:
        return ZERO, ZERO
    xyz, rpy = (
        _vector(origin, key, where, f"origin of {what}") if origin.get(key) is not None else ZERO
        for key in ("xyz", "rpy")
    )
    return xyz, rpy


def _attribute(element: ET.Element | None, key: str, where: str, what: str) -> str:
    value = None if element is None else element.get(key)
    if not value:
        raise InvalidInput(f"{what} has no {key}", where)
    return value


def _number(element: ET.Element | None, key: str, where: str, what: str, *, default: float | None = None) -> float:
    if default is not None and element is not None and element.get(key) is None:
        return default
    (value,) = _floats(_attribute(element, key, where, what), 1, where, what)
    return value


def _vector(element: ET.Element, key: str, where: str, what: str) -> Vector:
    return vector(_floats(_attribute(element, key, where, what), 3, where, what))


def _floats(text: str, count: int, where: str, what: str) -> list[float]:
    """Read finite numbers."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not _finite(values):
        raise InvalidInput(f"{what} is {text!r}", where, f"expected {count} finite number{'s' if count > 1 else ''}")
    return values


def _finite(values: Iterable[float]) -> bool:
    return bool(np.all(np.isfinite(list(values))))
