"""Capsules between the joints: the arm as the eye and the replay see it. No engine uses them."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .description import Joint

SHORTEST = 1e-3
"""Segments below this are not drawn [m]."""


@dataclass(frozen=True, kw_only=True)
class Capsule:
    """A cylinder with round ends, fixed to a link.

    Attributes:
        link: Name of the link.
        start: Centre of one end in the link frame [m].
        end: Centre of the other end in the link frame [m].
        radius: Radius [m].
    """

    link: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float


def capsules_between(joints: "Iterable[Joint]", radius: float) -> tuple[Capsule, ...]:
    """Return a capsule from every link's origin to each joint that it carries at a distance.

    Args:
        joints: The joints of the arm.
        radius: Radius of all capsules [m].
    """
    return tuple(
        Capsule(link=joint.parent, start=(0.0, 0.0, 0.0), end=joint.xyz, radius=radius)
        for joint in joints
        if np.linalg.norm(joint.xyz) > SHORTEST
    )


def capsule_visuals(capsule: Capsule) -> tuple[ET.Element, ...]:
    """Return a capsule as URDF visuals, a cylinder and two spheres: URDF has no capsule."""
    start, end = np.array(capsule.start), np.array(capsule.end)
    along = end - start
    length = float(np.linalg.norm(along))
    pitch, yaw = np.arctan2(np.hypot(along[0], along[1]), along[2]), np.arctan2(along[1], along[0])
    radius = repr(capsule.radius)
    return (
        _visual("cylinder", {"radius": radius, "length": repr(length)}, (start + end) / 2, rpy=(0.0, pitch, yaw)),
        _visual("sphere", {"radius": radius}, start),
        _visual("sphere", {"radius": radius}, end),
    )


def _visual(
    shape: str, size: dict[str, str], centre: np.ndarray, *, rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> ET.Element:
    visual = ET.Element("visual")
    xyz, angles = (" ".join(repr(float(value)) for value in values) for values in (centre, rpy))
    ET.SubElement(visual, "origin", xyz=xyz, rpy=angles)
    ET.SubElement(ET.SubElement(visual, "geometry"), shape, size)
    return visual
