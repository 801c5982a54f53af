"""Materials in the container. A material is a function of its mass and the container that returns a body."""

import math

import numpy as np

from ..controllers import InvalidInput
from .body import Body
from .container import Container
from .liquid import Liquid, sloshing

SAND_DENSITY = 1600.0
"""Bulk density of loose dry sand [kg/m^3]."""

WATER_DENSITY = 1000.0
"""Density of water [kg/m^3]."""

WATER_VISCOSITY = 1e-6
"""Kinematic viscosity of water at 20 degrees Celsius [m^2/s]."""


def sand(content_mass: float, container: Container) -> Body:
    r"""Return sand as a solid cylinder that stands on the container's bottom.

    .. math:: h = \frac{m}{\rho \pi R^2}, \quad z = z_b - \frac{h}{2}, \quad
        I_{xx} = \frac{m (3 R^2 + h^2)}{12}, \quad I_{zz} = \frac{m R^2}{2}

    Args:
        content_mass: Mass of the sand [kg].
        container: What it fills.

    Returns:
        The sand in the flange frame.

    Raises:
        InvalidInput: If the mass is not positive or the container does not hold it.
    """
    return solid_cylinder("sand", content_mass, container, density=SAND_DENSITY)


def water(content_mass: float, container: Container) -> Liquid:
    """Return water that stands on the container's bottom and sloshes, see :mod:`~torquebench.scenarios.liquid`.

    Args:
        content_mass: Mass of the water [kg].
        container: What it fills.

    Returns:
        The water in the flange frame; as a rigid body it is the frozen cylinder.

    Raises:
        InvalidInput: If the mass is not positive or the container does not hold it.
    """
    frozen = solid_cylinder("water", content_mass, container, density=WATER_DENSITY)
    depth = 2.0 * (container.bottom_z - float(frozen.com[2]))
    return sloshing(frozen, depth=depth, radius=container.inner_radius, viscosity=WATER_VISCOSITY)


def solid_cylinder(name: str, content_mass: float, container: Container, *, density: float) -> Body:
    """Return a rigid content of the container's inner radius that stands on its bottom.

    Args:
        name: Name of the material, for messages.
        content_mass: Mass [kg].
        container: What it fills.
        density: Density [kg/m^3].

    Returns:
        The content in the flange frame.

    Raises:
        InvalidInput: If the mass is not positive or the container does not hold it.
    """
    capacity = density * container.volume
    if not 0 < content_mass <= capacity:
        raise InvalidInput(
            f"{content_mass:g} kg of {name} in the container",
            "load",
            f"it holds more than 0 and up to {capacity:.3f} kg",
        )
    radius = container.inner_radius
    height = content_mass / (density * math.pi * radius**2)
    across = content_mass * (3 * radius**2 + height**2) / 12
    along = content_mass * radius**2 / 2
    return Body(
        mass=content_mass,
        com=np.array([0.0, 0.0, container.bottom_z - height / 2]),
        inertia=np.diag([across, across, along]),
    )
