"""A rigid body on the flange, and the sum of several."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..controllers import InvalidInput
from .axes import parallel_axis


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A rigid body in the flange frame; equal bodies are equal to the bit.

    Attributes:
        mass: Mass [kg].
        com: Centre of mass in the flange frame, shape (3,), read-only [m].
        inertia: Tensor about the centre of mass in flange axes, shape (3, 3), read-only [kg m^2].
    """

    mass: float
    com: np.ndarray
    inertia: np.ndarray

    def __post_init__(self) -> None:
        """Copy the arrays, so that no later change reaches the body, and check them."""
        object.__setattr__(self, "mass", float(self.mass))
        object.__setattr__(self, "com", _constant(self.com, (3,), "centre of mass"))
        object.__setattr__(self, "inertia", _constant(self.inertia, (3, 3), "inertia"))
        if not (np.isfinite(self.mass) and self.mass >= 0):
            raise InvalidInput(f"mass {self.mass:g} kg", "body", "masses are finite and not negative")

    @property
    def parameters(self) -> np.ndarray:
        """Mass, first moments and inertia about the flange origin, as :attr:`RobotModel.payload` orders them.

        m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz in flange axes, shape (10,) [kg, kg m, kg m^2]; a new array.
        """
        about = self.inertia + parallel_axis(self.mass, self.com)
        tensor = (about[0, 0], about[0, 1], about[1, 1], about[0, 2], about[1, 2], about[2, 2])
        return np.array([self.mass, *(self.mass * self.com), *tensor])

    @property
    def rigid(self) -> "Body":
        """What moves with the flange whatever happens: all of a rigid body."""
        return self

    def scaled(self, factor: float) -> "Body":
        """Return the same shape with another density: mass and inertia times a factor, centre unchanged."""
        return Body(mass=self.mass * factor, com=self.com, inertia=self.inertia * factor)

    def displaced(self, factor: float, shift: np.ndarray) -> "Body":
        """Return the body as it hangs elsewhere with another density.

        Args:
            factor: Of mass and inertia.
            shift: Of the centre of mass, shape (3,) [m].
        """
        return Body(mass=self.mass * factor, com=self.com + shift, inertia=self.inertia * factor)

    def _key(self) -> tuple[object, ...]:
        # Adding zero turns -0.0 into 0.0, which equal numbers have to share.
        return self.mass, (self.com + 0.0).tobytes(), (self.inertia + 0.0).tobytes()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())


def combine(bodies: Iterable[Body]) -> Body:
    """Return the rigid union of bodies in one frame, by the parallel-axis theorem.

    Args:
        bodies: Any number of bodies; of none or massless ones the union has no mass and its centre at the origin.

    Returns:
        One body with the sum of the masses, their common centre and the inertia about it.
    """
    parts = tuple(bodies)
    mass = sum(part.mass for part in parts)
    com = sum((part.mass * part.com for part in parts), np.zeros(3)) / mass if mass else np.zeros(3)
    inertia = np.zeros((3, 3))
    for part in parts:
        inertia += part.inertia + parallel_axis(part.mass, part.com - com)
    return Body(mass=mass, com=com, inertia=inertia)


def _constant(values: np.ndarray, shape: tuple[int, ...], what: str) -> np.ndarray:
    """Return a read-only copy of the expected shape."""
    array = np.array(values, dtype=float)
    if array.shape != shape or not np.all(np.isfinite(array)):
        raise InvalidInput(f"{what} of shape {array.shape}", "body", f"expected finite numbers of shape {shape}")
    array.flags.writeable = False
    return array
