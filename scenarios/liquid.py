r"""A liquid in an upright cylinder: its first lateral slosh mode as a pendulum with two axes.

With the first zero :math:`\xi = 1.84118` of :math:`J_1'`, content mass m, depth h, radius R and
:math:`s = \xi h / R`, the mode is a point mass on a pendulum, and what does not slosh is a rigid body:

.. math:: \omega^2 = \frac{g \xi}{R} \tanh s, \quad L = \frac{g}{\omega^2}, \quad
          m_1 = m \frac{2 R \tanh s}{\xi h (\xi^2 - 1)}, \quad m_0 = m - m_1, \quad
          z_1 = \frac h2 - \frac{2R}{\xi} \tanh \frac s2, \quad z_0 = -\frac{m_1 z_1}{m_0}

Heights count from the liquid's centre, away from the bottom; the bob rests at :math:`z_1`, its hinge is L above. The
rigid part's inertia is what the frozen liquid's lacks, so that a pendulum at rest *is* the frozen liquid.
Source: Dodge, The New Dynamic Behavior of Liquids in Moving Containers (2000), after NASA SP-106.
"""

import math
from dataclasses import dataclass

import numpy as np

from .axes import parallel_axis
from .body import Body

GRAVITY = 9.81
"""The plants' gravity [m/s^2]."""

MODE = 1.8411837813406593
"""First zero of the derivative of the Bessel function J1."""

LEAST_DAMPING = 0.01
"""Damping ratio below which no vessel is: the viscous formula holds for clean liquids in polished tanks."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Liquid(Body):
    """A liquid at rest as the rigid body it would be if it froze, and the pendulum that it is.

    Attributes:
        core: What does not slosh, in the flange frame.
        bob_mass: Mass of the pendulum's bob [kg].
        length: Length of the pendulum [m].
        hinge_z: Its hinge on the flange's z axis [m].
        damping_ratio: Share of critical damping.
    """

    core: Body
    bob_mass: float
    length: float
    hinge_z: float
    damping_ratio: float

    @property
    def rigid(self) -> Body:
        """What moves with the flange whatever happens: the core."""
        return self.core

    @property
    def frequency(self) -> float:
        """Angular frequency of the undamped mode [rad/s]."""
        return math.sqrt(GRAVITY / self.length)

    @property
    def damping(self) -> float:
        """Torque of each of the pendulum's axes against its own rate [N m s/rad]."""
        return 2.0 * self.damping_ratio * self.frequency * self.bob_mass * self.length**2

    def displaced(self, factor: float, shift: np.ndarray) -> "Liquid":
        """Return the liquid in a container that hangs elsewhere, with another density.

        The pendulum stays on the flange's axis: what the shift moves sideways is the core, so that the frozen liquid
        is where a rigid content would be.

        Args:
            factor: Of mass and inertia.
            shift: Of the centre of mass, shape (3,) [m].
        """
        frozen, rest_z = super().displaced(factor, shift), self.hinge_z + self.length + float(shift[2])
        return _split(frozen, factor * self.bob_mass, rest_z, length=self.length, damping_ratio=self.damping_ratio)

    def _key(self) -> tuple[object, ...]:
        pendulum = (self.bob_mass, self.length, self.hinge_z, self.damping_ratio)
        return *super()._key(), *self.core._key(), pendulum


def sloshing(frozen: Body, *, depth: float, radius: float, viscosity: float) -> Liquid:
    """Return a liquid that stands in an upright cylinder.

    Args:
        frozen: The liquid at rest as a rigid body in the flange frame, on the flange's z axis.
        depth: Depth of the liquid [m].
        radius: Inner radius of the cylinder [m].
        viscosity: Kinematic viscosity [m^2/s].
    """
    tangent = math.tanh(MODE * depth / radius)
    length = radius / (MODE * tangent)
    bob_mass = frozen.mass * 2.0 * radius * tangent / (MODE * depth * (MODE**2 - 1.0))
    bob_height = depth / 2.0 - 2.0 * radius / MODE * math.tanh(MODE * depth / (2.0 * radius))
    # The flange's z axis points at the bottom.
    damping_ratio = max(LEAST_DAMPING, viscous_damping(depth=depth, radius=radius, viscosity=viscosity))
    return _split(frozen, bob_mass, float(frozen.com[2]) - bob_height, length=length, damping_ratio=damping_ratio)


def _split(frozen: Body, bob_mass: float, rest_z: float, *, length: float, damping_ratio: float) -> Liquid:
    """Return a liquid whose bob rests on the flange's axis, its core what is left of the frozen liquid."""
    bob, core_mass = np.array([0.0, 0.0, rest_z]), frozen.mass - bob_mass
    core = (frozen.mass * frozen.com - bob_mass * bob) / core_mass
    lost = parallel_axis(bob_mass, bob - frozen.com) + parallel_axis(core_mass, core - frozen.com)
    return Liquid(
        mass=frozen.mass,
        com=frozen.com,
        inertia=frozen.inertia,
        core=Body(mass=core_mass, com=core, inertia=frozen.inertia - lost),
        bob_mass=bob_mass,
        length=length,
        hinge_z=rest_z - length,
        damping_ratio=damping_ratio,
    )


def viscous_damping(*, depth: float, radius: float, viscosity: float) -> float:
    r"""Return the damping ratio of a clean liquid in a smooth upright cylinder.

    .. math:: \zeta = \frac{0.79}{\sqrt{Re}} \Bigl[1 + \frac{0.318}{\sinh s}
        \Bigl(1 + \frac{1 - h/R}{\cosh s}\Bigr)\Bigr], \quad Re = \frac{\sqrt{g R^3}}{\nu}

    Args:
        depth: Depth of the liquid [m].
        radius: Inner radius of the cylinder [m].
        viscosity: Kinematic viscosity [m^2/s].
    """
    reynolds = math.sqrt(GRAVITY * radius**3) / viscosity
    # Beyond 20 radii the hyperbolic terms are below a float64's resolution, and cosh would overflow at 385.
    s = min(MODE * depth / radius, 36.0)
    walls = 1.0 + 0.318 / math.sinh(s) * (1.0 + (1.0 - depth / radius) / math.cosh(s))
    return 0.79 / math.sqrt(reynolds) * walls
