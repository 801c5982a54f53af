"""What a repetition draws besides its sensor noise: an arm, a load and a start that differ a little from the nominal.

Every quantity has a stream of its own, which depends on campaign seed, robot, trajectory and repetition only: all
controllers, plants, tiers, knowledge levels and load histories of a motion meet the same draws, and one more quantity
moves no other. Controllers keep the nominal model; ``oracle`` knows the drawn load.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from .body import Body
from .liquid import Liquid
from .robots import Robot
from .specification import RunSpecification
from .streams import scenario_stream
from .tiers import Tier

FRICTION = 0.20
"""Largest share by which a joint's friction, Coulomb and viscous alike, differs from the tier's."""
PAYLOAD_MASS = 0.01
"""Largest share by which the mass beyond the gripper differs from what the load says."""
PAYLOAD_CENTRE = 5e-3
"""Largest distance of its centre from the nominal place along each axis of the flange [m]."""
LINK_MASS = 0.02
"""Largest share by which the mass and inertia of a link differ from the model's."""
INITIAL_OFFSET = 5e-3
"""Largest distance of a joint from the plan at the first tick [rad]; the arm is at rest."""
SLOSH_AMPLITUDE = 0.035
"""Swing of a liquid at the first tick, about 2 degrees, a fifth of what the fast paths excite [rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Draws:
    """The draws of one repetition.

    Attributes:
        friction: Factor of each joint's friction, shape (n,).
        payload_mass: Factor of mass and inertia beyond the gripper.
        payload_centre: Shift of their centre in the flange frame, shape (3,) [m].
        link_mass: Factor of mass and inertia of the link that each joint moves, shape (n,).
        initial_offset: Joint positions less the plan's at the first tick, shape (n,) [rad].
        slosh_phase: Phase of a liquid's first mode about the flange's x and y axes at the first tick, shape (2,) [rad].
    """

    friction: np.ndarray
    payload_mass: float
    payload_centre: np.ndarray
    link_mass: np.ndarray
    initial_offset: np.ndarray
    slosh_phase: np.ndarray

    def arm(self, robot: Robot) -> Robot:
        """Return the arm that the plant simulates.

        Args:
            robot: The nominal arm, which controllers know.
        """
        factors = dict(zip((joint.child for joint in robot.description.moving), self.link_mass.tolist(), strict=True))
        links = tuple(
            replace(
                link,
                mass=link.mass * factors.get(link.name, 1.0),
                moments=tuple(moment * factors.get(link.name, 1.0) for moment in link.moments),
            )
            for link in robot.description.links
        )
        return replace(robot, description=replace(robot.description, links=links))

    def drives(self, tier: Tier) -> Tier:
        """Return the tier with the drawn friction."""
        return replace(tier, coulomb=tier.coulomb * self.friction, viscous=tier.viscous * self.friction)

    def carried(self, body: Body) -> Body:
        """Return a body of the load as it hangs there."""
        return body.displaced(self.payload_mass, self.payload_centre)

    def slosh(self, liquid: Liquid) -> tuple[np.ndarray, np.ndarray]:
        """Return angles and rates of a liquid's pendulum at the first tick, from where it would rest.

        Args:
            liquid: The liquid.

        Returns:
            Angles [rad] and rates [rad/s] about the flange's x and y axes, each of shape (2,).
        """
        rate = SLOSH_AMPLITUDE * liquid.frequency
        return SLOSH_AMPLITUDE * np.cos(self.slosh_phase), -rate * np.sin(self.slosh_phase)

    def as_table(self) -> dict[str, object]:
        """Return the draws as plain values."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in values.items()}


def draw(specification: RunSpecification, n: int) -> Draws:
    """Return the draws of a run; those of the nominal plant unless its specification asks for draws.

    Args:
        specification: The run.
        n: Number of joints.
    """
    if not specification.draws:
        ones, zeros = np.ones(n), np.zeros(n)
        return Draws(
            friction=ones,
            payload_mass=1.0,
            payload_centre=np.zeros(3),
            link_mass=ones,
            initial_offset=zeros,
            slosh_phase=np.zeros(2),
        )

    def uniform(stream: str, bound: float, size: int) -> np.ndarray:
        return scenario_stream(stream, specification).uniform(-bound, bound, size)

    return Draws(
        friction=1.0 + uniform("friction", FRICTION, n),
        payload_mass=1.0 + float(uniform("payload mass", PAYLOAD_MASS, 1)[0]),
        payload_centre=uniform("payload centre", PAYLOAD_CENTRE, 3),
        link_mass=1.0 + uniform("link masses", LINK_MASS, n),
        initial_offset=uniform("initial offset", INITIAL_OFFSET, n),
        slosh_phase=uniform("slosh phase", np.pi, 2),
    )
