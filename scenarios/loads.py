"""Loads: what hangs on the flange, and when it changes.

Masses count everything beyond the flange: gripper, container, content. Up to gripper and empty container there is no
material; beyond that a material fills the container. Materials are plug-ins of the kind ``loads``, so a new one needs
no change here.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from ..controllers import InvalidInput, UnknownName
from ..controllers.discovery import load, names
from .body import Body, combine
from .container import Container

if TYPE_CHECKING:
    from .robots import Robot

__all__ = ["Body", "LoadSchedule", "Material", "Payload", "combine"]

Material = Callable[[float, Container], Body]
"""Returns the body of a mass of the material in a container; a :class:`~.liquid.Liquid` sloshes."""

NO_MATERIAL = "none"
MASS_RESOLUTION = 1e-9
"""Masses nearer than this are equal: 1.5 kg minus gripper and container is not 0 in floating point [kg]."""


@dataclass(frozen=True, kw_only=True)
class Payload:
    """Everything beyond the flange.

    Attributes:
        mass: Gripper, container and content together [kg]; 0 only for a robot without a gripper.
        material: Name of a registered material, or ``"none"``.
    """

    mass: float
    material: str = NO_MATERIAL

    def __post_init__(self) -> None:
        """Check what can be checked without a robot."""
        object.__setattr__(self, "mass", float(self.mass))
        empty = self.mass == 0 and self.material == NO_MATERIAL
        if not (math.isfinite(self.mass) and self.mass > 0) and not empty:
            raise InvalidInput(f"mass {self.mass:g} kg", "load", "masses are positive, gripper included")
        if self.material != NO_MATERIAL and ":" not in self.material and self.material not in names("loads"):
            raise UnknownName("load", self.material, (NO_MATERIAL, *names("loads")))

    def bodies(self, robot: "Robot") -> tuple[Body, ...]:
        """Return container and content in the flange frame; the gripper is the robot's own.

        Between the gripper and gripper with empty container, the container is scaled to the mass.

        Args:
            robot: Whose gripper and container.

        Raises:
            InvalidInput: If the mass is below the gripper's, needs a material, or is more than the container holds.
        """
        carried = self._carried(robot)
        container = robot.container
        if carried <= MASS_RESOLUTION:
            return ()
        content = carried - container.mass
        if content < -MASS_RESOLUTION:
            return (container.body.scaled(carried / container.mass),)
        if content <= MASS_RESOLUTION:
            return (container.body,)
        if self.material == NO_MATERIAL:
            empty = robot.gripper_mass + container.mass
            choices = ", ".join(names("loads"))
            raise InvalidInput(
                f"{self.mass:g} kg without a material",
                "load",
                f"beyond {empty:g} kg (gripper and empty container) name one of: {choices}",
            )
        material: Material = load("loads", self.material)  # type: ignore[assignment]
        return container.body, material(content, container)

    def canonical(self, robot: "Robot") -> "Payload":
        """Return the load without a material where the container is empty: one spelling, one address."""
        content = self._carried(robot) - robot.container.mass
        return self if content > MASS_RESOLUTION else Payload(mass=self.mass)

    def _carried(self, robot: "Robot") -> float:
        """Return the mass beyond the gripper [kg]."""
        carried = self.mass - robot.gripper_mass
        if carried < -MASS_RESOLUTION:
            raise InvalidInput(
                f"{self.mass:g} kg is below the gripper's own mass", "load", f"at least {robot.gripper_mass:g} kg"
            )
        return carried


@dataclass(frozen=True, kw_only=True)
class LoadSchedule:
    """Which load hangs on the flange when.

    Attributes:
        entries: Times [s] and loads, times increasing. The first load acts from the first tick, lead-in included,
            whatever its time; later ones from the tick at their time.
    """

    entries: tuple[tuple[float, Payload], ...]

    def __post_init__(self) -> None:
        """Make the entries tuples and check that they can be followed."""
        entries = tuple((float(time), payload) for time, payload in self.entries)
        object.__setattr__(self, "entries", entries)
        times = [time for time, _ in entries]
        if not entries:
            raise InvalidInput("a load schedule without entries", "load schedule", "expected at least one (time, load)")
        ordered = all(earlier < later for earlier, later in pairwise(times))
        if not ordered or not all(math.isfinite(time) for time in times):
            listed = ", ".join(f"{time:g}" for time in times)
            raise InvalidInput(f"times {listed} s", "load schedule", "expected finite, increasing times")

    @classmethod
    def constant(cls, payload: Payload) -> "LoadSchedule":
        """Return one load for the whole episode."""
        return cls(entries=((0.0, payload),))

    @property
    def events(self) -> tuple[float, ...]:
        """Times at which the load changes [s]; the first entry is no event."""
        return tuple(time for time, _ in self.entries[1:])

    def at(self, time: float) -> Payload:
        """Return the load at a time [s]."""
        current = self.entries[0][1]
        for start, payload in self.entries[1:]:
            current = payload if start <= time else current
        return current

    def slots(self, robot: "Robot") -> tuple[tuple[Body, ...], tuple[tuple[float, tuple[bool, ...]], ...]]:
        """Return the distinct bodies of all loads and which of them hang on the flange when.

        A simulator cannot move a centre of mass while it runs, but it can switch a mass on and off: every distinct
        body gets a slot of its own below the flange.

        Args:
            robot: Whose gripper and container.

        Returns:
            The bodies in order of first use, and for each entry its time [s] and one truth value per body.

        Raises:
            InvalidInput: If the robot cannot carry one of the loads.
        """
        stages = [(time, payload.bodies(robot)) for time, payload in self.entries]
        distinct = tuple(dict.fromkeys(body for _, bodies in stages for body in bodies))
        return distinct, tuple((time, tuple(slot in bodies for slot in distinct)) for time, bodies in stages)
