"""The plan: what the arm should do now, and on request what it should do later."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np


@dataclass(frozen=True, slots=True)
class Preview:
    """The plan at k times; base-aligned axes at the tool point, linear before angular.

    Attributes:
        q: Joint positions, shape (k, n) [rad].
        dq: Joint velocities, shape (k, n) [rad/s].
        ddq: Joint accelerations, shape (k, n) [rad/s^2].
        pose: Tool poses in the base frame, shape (k, 4, 4) [m].
        twist: Tool twists, shape (k, 6) [m/s, rad/s].
        acceleration: Tool accelerations, shape (k, 6) [m/s^2, rad/s^2].
    """

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    acceleration: np.ndarray


class Reference(Protocol):
    """The whole plan as an object, so that a controller may plan at reset.

    Attributes:
        period: Duration of one lap [s].
        lead_in: Duration of the start from rest; time 0 is its end and phase 0 of a lap [s].
        q: Joint positions over one lap at 1 ms from phase 0, shape (N, n), read-only [rad].
        dq: Joint velocities, shape (N, n) [rad/s].
        ddq: Joint accelerations, shape (N, n) [rad/s^2].
        pose: Tool poses, shape (N, 4, 4) [m].
        twist: Tool twists, shape (N, 6) [m/s, rad/s].
        acceleration: Tool accelerations, shape (N, 6) [m/s^2, rad/s^2].
    """

    period: float
    lead_in: float
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    acceleration: np.ndarray

    def preview(self, times: np.ndarray) -> Preview:
        """Return the plan at absolute times, shape (k,) [s]; valid until the next call."""
        ...


@dataclass(slots=True)
class Target:
    """The plan at the observation's time; read-only views that the harness refills every tick.

    Attributes:
        q: Joint positions, shape (n,) [rad].
        dq: Joint velocities, shape (n,) [rad/s].
        ddq: Joint accelerations, shape (n,) [rad/s^2].
        pose: Tool pose in the base frame, shape (4, 4) [m].
        twist: Tool twist, base-aligned axes at the tool point, linear before angular, shape (6,) [m/s, rad/s].
        acceleration: Tool acceleration, same axes, shape (6,) [m/s^2, rad/s^2].
        reference: The whole plan.
    """

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    acceleration: np.ndarray
    reference: Reference

    def preview(self, times: np.ndarray) -> Preview:
        """Return the plan at absolute times; whole laps go on beyond the end.

        Args:
            times: Seconds on the observation's clock, shape (k,) [s].

        Returns:
            Preallocated arrays, valid until the next call.
        """
        return self.reference.preview(times)
