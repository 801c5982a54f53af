r"""Closed paths on which the tool turns too: position and roll, pitch, yaw are Fourier series of time."""

from dataclasses import dataclass

import numpy as np

from .paths import HarmonicPath, Point, fourier_series


@dataclass(frozen=True, kw_only=True)
class TurningPath(HarmonicPath):
    r"""A :class:`HarmonicPath` whose tool turns away from its rotation by angles about the base's axes.

    .. math:: R(t) = R_z(\psi) R_y(\theta) R_x(\varphi) R_0, \quad
              \omega = \dot\psi e_z + R_z (\dot\theta e_y + R_y \dot\varphi e_x)

    Attributes:
        turn_cosine: Coefficients of roll, pitch, yaw, from the first harmonic [rad].
        turn_sine: As many [rad].
    """

    turn_cosine: tuple[Point, ...]
    turn_sine: tuple[Point, ...]

    def pose(self, t: np.ndarray) -> np.ndarray:
        """Return tool poses at times t of shape (k,) [s], shape (k, 4, 4) [m]."""
        poses = super().pose(t)
        about_z, about_y, about_x = self._rotations(t)
        poses[:, :3, :3] = about_z @ about_y @ about_x @ np.array(self.rotation)
        return poses

    def twist(self, t: np.ndarray) -> np.ndarray:
        """Return tool twists, base-aligned axes, shape (k, 6) [m/s, rad/s]."""
        twists = super().twist(t)
        rates, axes = self._angles(t, order=1), self._axes(t)
        twists[:, 3:] = np.einsum("ka,kai->ki", rates, axes)
        return twists

    def acceleration(self, t: np.ndarray) -> np.ndarray:
        """Return tool accelerations, base-aligned axes, shape (k, 6) [m/s^2, rad/s^2]."""
        accelerations = super().acceleration(t)
        rates, growths, axes = self._angles(t, order=1), self._angles(t, order=2), self._axes(t)
        roll, pitch, yaw = (rates[:, a, None] * axes[:, a] for a in range(3))
        # The axis of yaw stands still, that of pitch turns with yaw, that of roll with both.
        carried = np.cross(yaw, pitch) + np.cross(yaw + pitch, roll)
        accelerations[:, 3:] = np.einsum("ka,kai->ki", growths, axes) + carried
        return accelerations

    def _angles(self, t: np.ndarray, *, order: int) -> np.ndarray:
        """Return roll, pitch, yaw differentiated some times, shape (k, 3)."""
        return fourier_series(t, self.period, self.turn_cosine, self.turn_sine, order=order)

    def _rotations(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the rotations by yaw, pitch and roll, each of shape (k, 3, 3)."""
        roll, pitch, yaw = self._angles(t, order=0).T
        return _about(2, yaw), _about(1, pitch), _about(0, roll)

    def _axes(self, t: np.ndarray) -> np.ndarray:
        """Return the axes of roll, pitch and yaw in the base frame, shape (k, 3, 3), one a row."""
        about_z, about_y, _ = self._rotations(t)
        upright = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(t), 3))
        return np.stack(((about_z @ about_y)[:, :, 0], about_z[:, :, 1], upright), axis=1)


def _about(axis: int, angle: np.ndarray) -> np.ndarray:
    """Return rotations about a coordinate axis, shape (k, 3, 3)."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rotation = np.zeros((len(angle), 3, 3))
    rotation[:, axis, axis] = 1.0
    rotation[:, j, j] = rotation[:, k, k] = np.cos(angle)
    rotation[:, k, j], rotation[:, j, k] = np.sin(angle), -np.sin(angle)
    return rotation
