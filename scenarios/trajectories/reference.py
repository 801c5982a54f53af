r"""The plan of a run: lead-in from rest, then whole laps without end, on one clock that is 0 at phase 0 of a lap.

The lead-in runs the lap's clock up from rest over T seconds with a quintic, u the share of it that has passed:

.. math:: \varphi(u) = T (2.5 u^4 - 3 u^5 + u^6) - T / 2, \quad \dot\varphi = 10 u^3 - 15 u^4 + 6 u^5

Between the samples of a lap everything is interpolated by cubic Hermite polynomials; samples come out exactly.
"""

from dataclasses import dataclass

import numba
import numpy as np

from ...controllers import Preview
from ..margins import HOLD
from ..robots import Robot
from ..tick import target_dtype
from .kinematics import spectral_derivative
from .lap_cache import cached_lap
from .paths import Path

STEP = 1e-3
"""Time between the samples of a lap [s]."""

HOLD_PERIOD = 4.0
"""Duration of what counts as a lap of the motion at rest [s]."""


@dataclass(eq=False)
class Plan:
    """A :class:`~torquebench.controllers.Reference`: one lap sampled at 1 ms, read-only, and the plan at any time.

    Attributes:
        name: Name of the trajectory.
        group: Its group.
        period: Duration of one lap [s].
        lead_in: Duration of the start from rest, 0 for none [s].
        q: Joint positions from phase 0, shape (N, n) [rad].
        dq: Joint velocities, shape (N, n) [rad/s].
        ddq: Joint accelerations, shape (N, n) [rad/s^2].
        pose: Tool poses, shape (N, 4, 4) [m].
        twist: Tool twists, shape (N, 6) [m/s, rad/s].
        acceleration: Tool accelerations, shape (N, 6) [m/s^2, rad/s^2].
    """

    name: str
    group: str
    period: float
    lead_in: float
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    acceleration: np.ndarray

    @classmethod
    def build(cls, robot: Robot, path: Path, *, lead_in: float) -> "Plan":
        """Solve a path for an arm, or take the solution from the cache.

        Args:
            robot: The arm.
            path: The path of its tool point.
            lead_in: Duration of the start from rest, 0 for none [s].

        Raises:
            InvalidInput: If the path cannot be followed.
        """
        lap = cached_lap(robot, path, step=STEP)
        times = np.arange(len(lap.q)) * STEP
        return cls(
            name=path.name,
            group=path.group,
            period=path.period,
            lead_in=lead_in,
            q=lap.q,
            dq=lap.dq,
            ddq=lap.ddq,
            pose=path.pose(times),
            twist=path.twist(times),
            acceleration=path.acceleration(times),
        )

    @classmethod
    def hold(cls, robot: Robot, *, lead_in: float) -> "Plan":
        """Return the motion of an arm that rests at its home, for as long as it takes.

        Args:
            robot: The arm.
            lead_in: Duration before time 0 [s].
        """
        count, n = round(HOLD_PERIOD / STEP), robot.n
        pose = robot.model().forward_kinematics(robot.home)
        return cls(
            name=HOLD,
            group=HOLD,
            period=HOLD_PERIOD,
            lead_in=lead_in,
            q=np.tile(robot.home, (count, 1)),
            dq=np.zeros((count, n)),
            ddq=np.zeros((count, n)),
            pose=np.tile(pose, (count, 1, 1)),
            twist=np.zeros((count, 6)),
            acceleration=np.zeros((count, 6)),
        )

    def __post_init__(self) -> None:
        """Make the samples read-only and prepare values and slopes for interpolation."""
        for name in ("q", "dq", "ddq", "pose", "twist", "acceleration"):
            getattr(self, name).flags.writeable = False
        count = len(self.q)
        jerks = spectral_derivative(np.hstack((self.ddq, self.acceleration)), self.period, order=1)
        n = self.q.shape[1]
        pose_rate = _pose_rate(self.pose, self.twist)
        flat = (count, 16)
        columns = (self.q, self.dq, self.ddq, self.pose.reshape(flat), self.twist, self.acceleration)
        slopes = (self.dq, self.ddq, jerks[:, :n], pose_rate.reshape(flat), self.acceleration, jerks[:, n:])
        self._values, self._slopes = np.hstack(columns), np.hstack(slopes)
        self._preview = np.zeros(0, target_dtype(n))

    def rows(self, times: np.ndarray) -> np.ndarray:
        """Return the plan at absolute times, shape (k,) [s], as records of :func:`~..tick.target_dtype`."""
        records = np.zeros(len(times), target_dtype(self.q.shape[1]))
        self._fill(np.asarray(times, dtype=float), records)
        return records

    def preview(self, times: np.ndarray) -> Preview:
        """Return the plan at absolute times, shape (k,) [s]; arrays that the next call refills."""
        times = np.asarray(times, dtype=float)
        if len(self._preview) != len(times):
            self._preview = np.zeros(len(times), target_dtype(self.q.shape[1]))
        self._fill(times, self._preview)
        rows = self._preview
        return Preview(
            q=rows["q"],
            dq=rows["dq"],
            ddq=rows["ddq"],
            pose=rows["pose"],
            twist=rows["twist"],
            acceleration=rows["acceleration"],
        )

    def _fill(self, times: np.ndarray, records: np.ndarray) -> None:
        block = records.view(np.float64).reshape(len(times), self._values.shape[1])
        _interpolate(times, self._values, self._slopes, self.q.shape[1], self.lead_in, STEP, block)


def _pose_rate(pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """Return the time derivative of homogeneous poses, shape (N, 4, 4)."""
    rate = np.zeros_like(pose)
    rate[:, :3, 3] = twist[:, :3]
    rate[:, :3, :3] = np.cross(twist[:, None, 3:], pose[:, :3, :3], axisb=1, axisc=1)
    return rate


@numba.njit(cache=True)
def _interpolate(times, values, slopes, n, lead_in, step, out):  # type: ignore[no-untyped-def]
    """Fill a row of joints, pose, twist and acceleration for each time."""
    count, width = values.shape
    for k in range(times.shape[0]):
        phase, rate, growth = _phase(times[k], lead_in)
        place = phase / step
        nearest = np.round(place)
        # A tick's time carries the rounding of its decimal digits: on a sample it must give the sample.
        if abs(place - nearest) < 1e-6:
            place = nearest
        low = int(np.floor(place))
        u = place - low
        i, j = low % count, (low + 1) % count
        a, b = (1.0 + 2.0 * u) * (1.0 - u) ** 2, u * u * (3.0 - 2.0 * u)
        c, d = u * (1.0 - u) ** 2 * step, u * u * (u - 1.0) * step
        for column in range(width):
            if u == 0.0:
                out[k, column] = values[i, column]
            else:
                out[k, column] = (
                    a * values[i, column] + b * values[j, column] + c * slopes[i, column] + d * slopes[j, column]
                )
        if rate != 1.0:
            _slow(out[k], n, 2 * n, n, rate, growth)
            _slow(out[k], 3 * n + 16, 3 * n + 22, 6, rate, growth)


@numba.njit(cache=True)
def _phase(time, lead_in):  # type: ignore[no-untyped-def]
    """Return phase, its rate and the rate's growth at a time."""
    if time >= 0.0 or lead_in <= 0.0:
        return time, 1.0, 0.0
    u = max(0.0, (time + lead_in) / lead_in)
    phase = lead_in * (2.5 * u**4 - 3.0 * u**5 + u**6) - 0.5 * lead_in
    rate = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    growth = 30.0 * u * u * (1.0 - u) ** 2 / lead_in
    return phase, rate, growth


@numba.njit(cache=True)
def _slow(row, velocity, acceleration, size, rate, growth):  # type: ignore[no-untyped-def]
    """Turn derivatives by phase into derivatives by time."""
    for i in range(size):
        by_phase = row[velocity + i]
        row[velocity + i] = by_phase * rate
        row[acceleration + i] = row[acceleration + i] * rate * rate + by_phase * growth
