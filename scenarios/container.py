"""The container that hangs on the gripper and holds the content."""

import math
from dataclasses import dataclass

import numpy as np

from ..controllers import InvalidInput
from .body import Body


@dataclass(frozen=True, kw_only=True)
class Container:
    """A thin upright cylinder, open towards the flange, on the flange's z axis.

    Attributes:
        mass: Mass of the empty container [kg].
        com_z: Its centre of mass along z of the flange [m].
        inertia_diag: Its principal moments about that centre, x, y, z [kg m^2].
        inner_radius: Inner radius [m].
        inner_height: Inner height [m].
        bottom_z: Where the content stands, along z of the flange [m].
    """

    mass: float
    com_z: float
    inertia_diag: tuple[float, float, float]
    inner_radius: float
    inner_height: float
    bottom_z: float

    def __post_init__(self) -> None:
        """Check that it is a body and has room."""
        sizes = {"mass": self.mass, "inner radius": self.inner_radius, "inner height": self.inner_height}
        for name, size in sizes.items():
            if not (math.isfinite(size) and size > 0):
                raise InvalidInput(f"{name} {size:g}", "container", "mass, inner radius and height are positive")
        moments = self.inertia_diag
        if not 0 <= 2.0 * max(moments) <= sum(moments) * (1.0 + 1e-9) < math.inf:
            listed = ", ".join(f"{moment:g}" for moment in moments)
            came = f"principal moments of {listed} kg m^2"
            raise InvalidInput(came, "container", "no body has one above the sum of the other two")

    @property
    def volume(self) -> float:
        """What it holds when full to the rim [m^3]."""
        return math.pi * self.inner_radius**2 * self.inner_height

    @property
    def body(self) -> Body:
        """The empty container as a rigid body."""
        return Body(mass=self.mass, com=np.array([0.0, 0.0, self.com_z]), inertia=np.diag(self.inertia_diag))

    def moved(self, distance: float) -> "Container":
        """Return the same container further along z of the flange by a distance [m]."""
        return Container(
            mass=self.mass,
            com_z=self.com_z + distance,
            inertia_diag=self.inertia_diag,
            inner_radius=self.inner_radius,
            inner_height=self.inner_height,
            bottom_z=self.bottom_z + distance,
        )
