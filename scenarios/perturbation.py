"""What may be wrong with the world of a run that its controller is not told, the same for every controller."""

import math
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

from ..controllers import InvalidInput

if TYPE_CHECKING:
    from .body import Body
    from .robots import Robot
    from .tiers import Tier


@dataclass(frozen=True, kw_only=True)
class Perturbation:
    """Departures from the nominal world; nobody is told of them, the level ``oracle`` neither.

    Attributes:
        payload: Extra mass in the shape and at the place of the container [kg].
        delay: Extra ticks between command and torque, beyond those that the tier publishes.
        gain: Factor on the command before the limiter; the command that is read back has it divided out again.
        velocity_noise: Standard deviation of white noise on every measured joint velocity [rad/s].
        friction: Factor on Coulomb and viscous friction.
        offset: Norm of the joint error at the start, spread evenly over the joints [rad].
    """

    payload: float = 0.0
    delay: int = 0
    gain: float = 1.0
    velocity_noise: float = 0.0
    friction: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        """Check the ranges and give equal numbers one spelling; an offset may be negative, everything else may not."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not math.isfinite(value) or (value < 0 and field.name != "offset"):
                raise InvalidInput(f"{field.name} = {value:g}", "perturbation", "expected a finite number, 0 or more")
            object.__setattr__(self, field.name, int(value) if field.name == "delay" else float(value))

    def as_table(self) -> dict[str, float]:
        """Return what is not nominal by name; empty for the nominal world."""
        return {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if getattr(self, field.name) != field.default
        }

    def in_words(self) -> str:
        """Return what is not nominal: ``payload 1.5, delay 3``; ``none`` for the nominal world."""
        return ", ".join(f"{name} {value:g}" for name, value in self.as_table().items()) or "none"

    def bodies(self, robot: "Robot") -> "tuple[Body, ...]":
        """Return the extra mass as a body in the flange frame, nothing without one.

        Args:
            robot: Whose container gives it its shape.
        """
        return (robot.container.body.scaled(self.payload / robot.container.mass),) if self.payload else ()

    def drives(self, tier: "Tier") -> "Tier":
        """Return the tier as the plant has it; controllers are told the one that came.

        Args:
            tier: The published tier.
        """
        return replace(
            tier,
            delay_ticks=tier.delay_ticks + self.delay,
            coulomb=self.friction * tier.coulomb,
            viscous=self.friction * tier.viscous,
        )


NOMINAL = Perturbation()
"""Nothing is wrong."""
