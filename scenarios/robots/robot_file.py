"""Robots from files: a TOML table beside a URDF, a TOML table that holds links and joints, or a bare URDF."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import as_file, files
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from ...controllers import InvalidInput, UnknownName
from ...controllers.discovery import load, names
from ..axes import rotation_from_quaternion, rpy_from_rotation
from ..body import Body
from ..container import Container
from ..tiers import NotNegative, TierTable, default_tiers
from ..validation import Names, Number, Numbers, Point3, Record, as_tuple, read_toml, validate
from .capsules import capsules_between
from .description import Description, Joint, Link, vector
from .robot import Robot
from .urdf import check_tree, from_base, read_urdf

CAPSULE_RADIUS = 0.05


class LinkTable(Record):
    """A link with its inertial in principal axes."""

    name: str
    mass: NotNegative = 0.0
    com: Point3 = (0.0, 0.0, 0.0)
    principal: Annotated[tuple[NotNegative, NotNegative, NotNegative], BeforeValidator(as_tuple)] = (0.0, 0.0, 0.0)
    quat_wxyz: Annotated[tuple[Number, Number, Number, Number], BeforeValidator(as_tuple)] = (1.0, 0.0, 0.0, 0.0)


class JointTable(Record):
    """A joint; fixed unless it says otherwise."""

    name: str
    parent: str
    child: str
    xyz: Point3
    rpy: Point3 = (0.0, 0.0, 0.0)
    kind: Literal["fixed", "revolute", "prismatic"] = "fixed"
    axis: Point3 = (0.0, 0.0, 1.0)
    lower: Number = 0.0
    upper: Number = 0.0
    velocity: Number = 0.0
    effort: Number = 0.0


class GripperTable(Record):
    """A gripper in the flange frame."""

    mass: Annotated[Number, Field(gt=0)]
    com: Point3
    inertia_diag: Point3


class ContainerTable(Record):
    """A container; the defaults are the benchmark's own, chosen."""

    mass: Annotated[Number, Field(gt=0)] = 0.314
    com_z: Number = 0.249777
    inertia_diag: Point3 = (0.001389, 0.001389, 0.001629)
    inner_radius: Annotated[Number, Field(gt=0)] = 0.075
    inner_height: Annotated[Number, Field(gt=0)] = 0.13
    bottom_z: Number = 0.3


class RobotTable(Record):
    """A robot file."""

    name: str
    version: int = Field(default=1, alias="schema")
    title: str = ""
    urdf: str = ""
    flange_frame: str = ""
    home: Numbers = ()
    rotor_inertia: Numbers = ()
    capsule_radius: Number = CAPSULE_RADIUS
    tools: dict[str, Number] = Field(default={"flange": 0.0}, min_length=1)
    gripper: GripperTable | None = None
    container: ContainerTable = ContainerTable()
    tiers: dict[str, TierTable] = Field(default={})
    joints: Annotated[tuple[JointTable, ...], BeforeValidator(as_tuple)] = ()
    links: Annotated[tuple[LinkTable, ...], BeforeValidator(as_tuple)] = ()
    sources: Names = ()


def load_robot(name: object, *, tool: str = "") -> Robot:
    """Return a robot by registered name, file, door or object.

    Args:
        name: A registered name, a path that ends in ``.toml`` or ``.urdf``, ``package.module:name``, or a Robot.
        tool: Name of one of its tool points, empty for the first.

    Raises:
        UnknownName: If nobody registered the name, or the robot has no such tool point.
        InvalidInput: If the file is missing, malformed, or describes no fixed-base arm.
    """
    if isinstance(name, Robot):
        return name
    if isinstance(name, str) and name.endswith((".toml", ".urdf")) and ":" not in name:
        return read_robot(Path(name), tool=tool)
    if isinstance(name, str) and ":" not in name and name not in names("robots"):
        raise UnknownName("robot", name, names("robots"))
    factory = load("robots", name)
    found = factory(tool=tool) if callable(factory) else factory
    if not isinstance(found, Robot):
        raise InvalidInput(f"is a {type(found).__name__}, no robot", f"robot {name!r}", "expected a Robot")
    return found


def rizon4s(*, tool: str = "") -> Robot:
    """Return Flexiv's Rizon 4s with GRAV gripper and the benchmark's container.

    Args:
        tool: ``"gripper"`` (0.15 m beyond the flange, the default) or ``"flange"``.
    """
    package = __name__.rsplit(".", 2)[0]
    with as_file(files(package) / "data" / "rizon4s.toml") as file:
        return read_robot(file, tool=tool)


def read_robot(file: Path, *, tool: str = "") -> Robot:
    """Return the robot of a TOML or URDF file; a bare URDF gets defaults for everything that it does not say.

    Args:
        file: The file; a ``urdf`` key in a TOML is relative to it.
        tool: Name of one of its tool points, empty for the first.

    Raises:
        UnknownName: If the robot has no such tool point or frame.
        InvalidInput: If the file is missing, malformed, or describes no fixed-base arm.
    """
    where = file.name
    if file.suffix == ".urdf":
        table, description = RobotTable(name=file.stem), read_urdf(file)
    else:
        table = validate(RobotTable, read_toml(file), where=where)
        described = table.urdf or table.links
        if not described or (table.urdf and table.links):
            raise InvalidInput("needs either 'urdf' or 'links' and 'joints'", where)
        description = read_urdf(file.parent / table.urdf) if table.urdf else _describe(table, where)
    return _assemble(table, description, tool, where)


def _assemble(table: RobotTable, description: Description, tool: str, where: str) -> Robot:
    """Join a table and a description, with defaults for what the table leaves open."""
    n = len(description.moving)
    links = tuple(link.name for link in description.links)
    flange = table.flange_frame or description.joints[-1].child
    if flange not in links:
        raise UnknownName(f"flange_frame in {where}", flange, links)
    tool = tool or next(iter(table.tools))
    if tool not in table.tools:
        raise UnknownName(f"tool of robot {table.name}", tool, tuple(table.tools))
    lower = np.array([joint.lower for joint in description.moving])
    upper = np.array([joint.upper for joint in description.moving])
    effort = np.array([joint.effort for joint in description.moving])
    middle = np.where(np.abs(lower + upper) < np.inf, 0.5 * (lower + upper), 0.0)
    home = _row(table.home, middle, "home", n, where)
    if np.any(home < lower) or np.any(home > upper):
        joint = int(np.argmax((home < lower) | (home > upper)))
        raise InvalidInput(f"home of joint {joint + 1} is {home[joint]:g} rad", where, "inside its limits")
    rotor_inertia = _row(table.rotor_inertia, np.zeros(n), "rotor_inertia", n, where)
    gripper = table.gripper
    return Robot(
        name=table.name,
        title=table.title or table.name,
        description=_with_capsules(description, table.capsule_radius),
        flange_frame=flange,
        tool=tool,
        tool_offset=table.tools[tool],
        home=home,
        rotor_inertia=rotor_inertia,
        gripper=None
        if gripper is None
        else Body(mass=gripper.mass, com=np.array(gripper.com), inertia=np.diag(gripper.inertia_diag)),
        container=Container(**table.container.model_dump()),
        tiers=default_tiers(effort, rotor_inertia) | _tiers(table.tiers, n, where),
        sources=table.sources,
    )


def _tiers(tables: Mapping[str, TierTable], n: int, where: str) -> dict[str, dict[str, object]]:
    """Return the constants that a file gives, rows checked for length."""
    given = {name: table.model_dump(exclude_unset=True) for name, table in tables.items()}
    for name, table in given.items():
        for key, value in table.items():
            wrench = key in ("ft_noise_sigma", "ft_bias_sigma")
            if isinstance(value, tuple) and len(value) != (6 if wrench else n):
                raise InvalidInput(
                    f"tiers.{name}.{key} has {len(value)} numbers", where, f"expected {6 if wrench else n}"
                )
    return given


def _row(values: tuple[float, ...], default: np.ndarray, key: str, n: int, where: str) -> np.ndarray:
    if values and len(values) != n:
        raise InvalidInput(f"{key} has {len(values)} numbers", where, f"the arm has {n} joints")
    return np.array(values) if values else default


def _with_capsules(description: Description, radius: float) -> Description:
    return Description(
        name=description.name,
        links=description.links,
        joints=description.joints,
        capsules=capsules_between(description.joints, radius),
    )


def _describe(table: RobotTable, where: str) -> Description:
    """Build the description that a table spells out."""
    for link in table.links:
        if not any(link.quat_wxyz):
            raise InvalidInput(f"link {link.name!r} has a quaternion of length zero", where, "expected a direction")
    links = tuple(
        Link(
            name=link.name,
            mass=link.mass,
            com=link.com,
            moments=link.principal,
            rpy=vector(rpy_from_rotation(rotation_from_quaternion(np.array(link.quat_wxyz)))),
        )
        for link in table.links
    )
    joints = tuple(Joint(**joint.model_dump()) for joint in table.joints)
    description = Description(name=table.name, links=links, joints=joints)
    check_tree(description, where)
    return replace(description, joints=from_base(description))
