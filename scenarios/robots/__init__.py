"""Arms: their description, the URDF texts written from it, and the files that robots come from."""

from .capsules import Capsule
from .description import Description, Joint, Link, slosh_names, slot_name
from .robot import Robot
from .robot_file import load_robot, read_robot, rizon4s
from .skeleton import Skeleton, skeleton
from .urdf import parse_urdf, read_urdf

__all__ = [
    "Capsule",
    "Description",
    "Joint",
    "Link",
    "Robot",
    "Skeleton",
    "load_robot",
    "parse_urdf",
    "read_robot",
    "read_urdf",
    "rizon4s",
    "skeleton",
    "slosh_names",
    "slot_name",
]
