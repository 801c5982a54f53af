"""Closed paths of the tool as analytic functions of time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

Point = tuple[float, float, float]

TOOL_DOWN: tuple[Point, Point, Point] = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))
"""Tool axis straight down, yaw 0; base frame."""


@runtime_checkable
class Path(Protocol):
    """A closed motion of the tool; anything with these members is a trajectory.

    Poses are in the base frame; twists and accelerations in base-aligned axes at the tool point, linear before
    angular. All three repeat after ``period``.

    Attributes:
        name: What tables call it.
        period: Duration of one lap, a whole number of milliseconds [s].
        centre: Its centre, which the arm faces, shape (3,) [m].
        group: Paths that are summarised together, for example ``"slow"``.
    """

    @property
    def name(self) -> str: ...  # noqa: D102 - the class documents the four attributes

    @property
    def period(self) -> float: ...  # noqa: D102

    @property
    def centre(self) -> Point: ...  # noqa: D102

    @property
    def group(self) -> str: ...  # noqa: D102

    def pose(self, t: np.ndarray) -> np.ndarray:
        """Return tool poses at times t of shape (k,) [s], shape (k, 4, 4) [m]."""
        ...

    def twist(self, t: np.ndarray) -> np.ndarray:
        """Return tool twists, shape (k, 6) [m/s, rad/s]."""
        ...

    def acceleration(self, t: np.ndarray) -> np.ndarray:
        """Return tool accelerations, shape (k, 6) [m/s^2, rad/s^2]."""
        ...


@dataclass(frozen=True, kw_only=True)
class HarmonicPath:
    r"""A finite Fourier series of the tool point, with the tool's orientation fixed.

    .. math:: p(t) = c + \sum_{h=1}^{H} a_h \cos(h \omega t) + b_h \sin(h \omega t), \quad \omega = 2 \pi / T

    Attributes:
        name: What tables call it.
        period: Duration T of one lap [s].
        centre: The constant term c, base frame [m].
        group: Paths that are summarised together.
        cosine: Coefficients a_1 to a_H [m].
        sine: Coefficients b_1 to b_H, as many [m].
        rotation: Rows of the tool's rotation in the base frame.
    """

    name: str
    period: float
    centre: Point
    cosine: tuple[Point, ...]
    sine: tuple[Point, ...]
    group: str = ""
    rotation: tuple[Point, Point, Point] = TOOL_DOWN

    def pose(self, t: np.ndarray) -> np.ndarray:
        """Return tool poses at times t of shape (k,) [s], shape (k, 4, 4) [m]."""
        poses = np.zeros((len(t), 4, 4))
        poses[:, :3, :3] = self.rotation
        poses[:, :3, 3] = self.centre + self._derivative(t, order=0)
        poses[:, 3, 3] = 1.0
        return poses

    def twist(self, t: np.ndarray) -> np.ndarray:
        """Return tool twists, base-aligned axes, shape (k, 6) [m/s, rad/s]."""
        return np.hstack((self._derivative(t, order=1), np.zeros((len(t), 3))))

    def acceleration(self, t: np.ndarray) -> np.ndarray:
        """Return tool accelerations, base-aligned axes, shape (k, 6) [m/s^2, rad/s^2]."""
        return np.hstack((self._derivative(t, order=2), np.zeros((len(t), 3))))

    def _derivative(self, t: np.ndarray, *, order: int) -> np.ndarray:
        """Return the series less its constant, differentiated 0, 1 or 2 times, shape (k, 3)."""
        return fourier_series(t, self.period, self.cosine, self.sine, order=order)


def fourier_series(
    t: np.ndarray, period: float, cosine: tuple[Point, ...], sine: tuple[Point, ...], *, order: int
) -> np.ndarray:
    """Return a Fourier series without a constant term, differentiated some times.

    Args:
        t: Times, shape (k,) [s].
        period: Its period [s].
        cosine: Coefficients of the harmonics from the first, each of three components.
        sine: As many.
        order: How often it is differentiated.

    Returns:
        Its values, shape (k, 3).
    """
    rate = 2.0 * np.pi / period * np.arange(1, len(cosine) + 1)
    a, b = np.array(cosine), np.array(sine)
    # One differentiation takes (a, b) to h w (b, -a).
    for _ in range(order):
        a, b = rate[:, None] * b, -rate[:, None] * a
    angle = np.outer(t, rate)
    return np.asarray(np.cos(angle) @ a + np.sin(angle) @ b)


def circle(
    *, name: str, period: float, centre: Point, radius: float, tilt: float = 0.0, group: str = ""
) -> HarmonicPath:
    """Return a circle about a point; at tilt 0 it is horizontal and starts on the far side.

    Args:
        name: What tables call it.
        period: Duration of one lap [s].
        centre: Its centre, base frame [m].
        radius: Its radius [m].
        tilt: Lifts the x axis of its plane about the base's -y axis [rad].
        group: Paths that are summarised together.
    """
    return rotated_circle(name=name, period=period, centre=centre, radius=radius, tilt=tilt, turn=0.0, group=group)


def rotated_circle(
    *, name: str, period: float, centre: Point, radius: float, tilt: float, turn: float, group: str = ""
) -> HarmonicPath:
    """Return :func:`circle` turned by an angle about the vertical through its centre.

    Args:
        name: What tables call it.
        period: Duration of one lap [s].
        centre: Its centre, base frame [m].
        radius: Its radius [m].
        tilt: Lifts the x axis of its plane [rad].
        turn: Angle about the base's z axis [rad].
        group: Paths that are summarised together.
    """
    c, s, lift = np.cos(turn), np.sin(turn), np.cos(tilt)
    return HarmonicPath(
        name=name,
        period=period,
        centre=centre,
        cosine=(_point(radius * lift * c, radius * lift * s, radius * np.sin(tilt)),),
        sine=(_point(-radius * s, radius * c, 0.0),),
        group=group,
    )


def yz_circle(*, name: str, period: float, centre: Point, radius: float, group: str = "") -> HarmonicPath:
    """Return a circle in the plane of the base's y and z axes that starts at its top.

    Args:
        name: What tables call it.
        period: Duration of one lap [s].
        centre: Its centre, base frame [m].
        radius: Its radius [m].
        group: Paths that are summarised together.
    """
    cosine, sine = ((0.0, 0.0, radius),), ((0.0, radius, 0.0),)
    return HarmonicPath(name=name, period=period, centre=centre, cosine=cosine, sine=sine, group=group)


def eight(
    *, name: str, period: float, centre: Point, radius: float, z_amplitude: float, group: str = ""
) -> HarmonicPath:
    """Return a figure of eight along the base's y axis, half as wide along x, that rises and falls once a lap.

    Args:
        name: What tables call it.
        period: Duration of one lap [s].
        centre: Its crossing point, base frame [m].
        radius: Half its extent along y [m].
        z_amplitude: Half its extent along z [m].
        group: Paths that are summarised together.
    """
    cosine = ((0.0, radius, 0.0), (0.0, 0.0, 0.0))
    sine = ((0.0, 0.0, z_amplitude), (radius / 2.0, 0.0, 0.0))
    return HarmonicPath(name=name, period=period, centre=centre, cosine=cosine, sine=sine, group=group)


def fourier(
    *,
    name: str,
    period: float,
    centre: Sequence[float],
    cosine: Sequence[Sequence[float]],
    sine: Sequence[Sequence[float]],
    group: str = "",
) -> HarmonicPath:
    """Return a path by its coefficients, as a data file lists them.

    Args:
        name: What tables call it.
        period: Duration of one lap [s].
        centre: The constant term, base frame [m].
        cosine: Coefficients a_1 to a_H [m].
        sine: Coefficients b_1 to b_H, as many [m].
        group: Paths that are summarised together.
    """
    a, b = (tuple(_point(*row) for row in rows) for rows in (cosine, sine))
    return HarmonicPath(name=name, period=period, centre=_point(*centre), cosine=a, sine=b, group=group)


def _point(x: float, y: float, z: float) -> Point:
    return (float(x), float(y), float(z))
