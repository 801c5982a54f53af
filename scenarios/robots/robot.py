"""An arm as the harness needs it: description, gripper, container, tool point, constants of its tiers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...controllers import RobotModel
from ..body import Body
from ..container import Container
from .description import Description, Link

GRIPPER_LINK, TOOL_LINK = "torquebench_gripper", "torquebench_tool"


@dataclass(frozen=True, kw_only=True, eq=False)
class Robot:
    """A fixed-base arm of any number of joints with what hangs on its flange.

    Attributes:
        name: What tables call it.
        title: Its full name.
        description: Links and joints without gripper and tool point.
        flange_frame: Link that carries gripper and load.
        tool: Name of its tool point.
        tool_offset: The tool point on the flange's z axis [m].
        home: Home position, shape (n,) [rad].
        rotor_inertia: Full reflected rotor inertia, shape (n,) [kg m^2]; a tier scales it.
        gripper: The gripper in the flange frame, None if the arm has none or its description holds it.
        container: What holds the content.
        tiers: Tier name to constants, see :func:`~torquebench.scenarios.tiers.build_tier`.
        sources: Where the figures come from.
    """

    name: str
    title: str
    description: Description
    flange_frame: str
    tool: str
    tool_offset: float
    home: np.ndarray
    rotor_inertia: np.ndarray
    gripper: Body | None
    container: Container
    tiers: Mapping[str, Mapping[str, object]]
    sources: tuple[str, ...] = ()

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.description.moving)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the moving joints from the base."""
        return tuple(joint.name for joint in self.description.moving)

    @property
    def gripper_mass(self) -> float:
        """Mass of the gripper, 0 without one [kg]."""
        return self.gripper.mass if self.gripper is not None else 0.0

    @property
    def gripper_bodies(self) -> tuple[Body, ...]:
        """The gripper as a body in the flange frame, empty without one."""
        return (self.gripper,) if self.gripper is not None else ()

    @property
    def tool_frame(self) -> str:
        """Name of the frame whose pose is controlled."""
        return TOOL_LINK

    @cached_property
    def lower(self) -> np.ndarray:
        """Lower position limits, shape (n,) [rad]."""
        return np.array([joint.lower for joint in self.description.moving])

    @cached_property
    def upper(self) -> np.ndarray:
        """Upper position limits, shape (n,) [rad]."""
        return np.array([joint.upper for joint in self.description.moving])

    @cached_property
    def velocity(self) -> np.ndarray:
        """Velocity limits, shape (n,) [rad/s]."""
        return np.array([joint.velocity for joint in self.description.moving])

    @cached_property
    def effort(self) -> np.ndarray:
        """Torque limits, shape (n,) [N m]."""
        return np.array([joint.effort for joint in self.description.moving])

    @cached_property
    def equipped(self) -> Description:
        """The description with gripper and tool point."""
        equipped = self.description
        if self.gripper is not None:
            equipped = equipped.with_fixed(Link.from_body(GRIPPER_LINK, self.gripper), parent=self.flange_frame)
        return equipped.with_fixed(Link(name=TOOL_LINK), parent=self.flange_frame, xyz=(0.0, 0.0, self.tool_offset))

    @cached_property
    def urdf(self) -> str:
        """URDF with true limits, gripper and tool point, for models and viewers."""
        return self.equipped.model_text()

    def simulator_urdf(self, slots: Sequence[Body] = ()) -> str:
        """Return the URDF for a simulator: limits widened, payload slots below the flange.

        Args:
            slots: Bodies in the flange frame.
        """
        return self.equipped.simulator_text(flange=self.flange_frame, slots=slots)

    def model(self, *, rotor_inertia: np.ndarray | None = None) -> RobotModel:
        """Return a new model of arm and gripper.

        Args:
            rotor_inertia: Apparent rotor inertia, shape (n,) [kg m^2]; None for none.
        """
        inertia = np.zeros(self.n) if rotor_inertia is None else rotor_inertia
        return RobotModel(self.urdf, tool_frame=TOOL_LINK, flange_frame=self.flange_frame, rotor_inertia=inertia)
