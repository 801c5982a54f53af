"""A log of one's own on bare arrays, of a real robot even: checked once, then evaluated like the harness's."""

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import InvalidLog

JOINTS = ("q", "dq", "q_ref", "dq_ref", "ddq_ref", "tau_cmd", "tau_lim", "tau")
LIMITS = ("effort", "torque_rate", "velocity", "lower", "upper")
WIDTHS = {"p": 3, "p_ref": 3, "quat": 4, "quat_ref": 4, "twist": 6, "twist_ref": 6, "wrench": 6}
"""Columns of the fields that have a row for each tick, other than those of the joints."""

UNEVEN = 0.01
"""Largest departure of a time step from the period, as a share of it."""

UNIT_LENGTH = 1e-3
"""Largest departure of a quaternion's length from 1."""

WIDEST_GAP = 5.5
"""Longest step that is filled when a log is resampled, in median steps: five of them, and their jitter."""

DEGREES, MILLIMETRES = 4.0 * math.pi, 10.0
"""Joint positions [rad] and tool positions [m] beyond which the unit is doubtful."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Log:
    """One run, row k: the state before torque k acts, and the reference of tick k. All but the time is optional.

    Attributes:
        t: Time, evenly spaced, 0 at phase 0 of the first lap that counts, shape (N,) [s].
        q: Joint positions, shape (N, n) [rad].
        dq: Joint velocities, shape (N, n) [rad/s].
        q_ref: Planned joint positions, shape (N, n) [rad].
        dq_ref: Planned joint velocities, shape (N, n) [rad/s].
        ddq_ref: Planned joint accelerations, shape (N, n) [rad/s^2].
        tau_cmd: What the controller asked for, before any limit, shape (N, n) [N m].
        tau_lim: What the limiter made of it, shape (N, n) [N m].
        tau: What acted at the joints, shape (N, n) [N m].
        p: Tool positions in the base frame, shape (N, 3) [m].
        p_ref: Planned tool positions, shape (N, 3) [m].
        quat: Tool attitudes, xyzw, shape (N, 4).
        quat_ref: Planned tool attitudes, xyzw, shape (N, 4).
        twist: Tool twists, base-aligned, linear before angular, shape (N, 6) [m/s, rad/s].
        twist_ref: Planned tool twists, likewise, shape (N, 6) [m/s, rad/s].
        wrench: Load on the flange, flange axes, shape (N, 6) [N, N m].
        lap: Duration of one lap [s]; None for a motion that is no cycle.
        mass: What is moved beyond the flange [kg].
        effort: Torque limits, shape (n,) [N m].
        torque_rate: Torque rate limits, shape (n,) [N m/s].
        velocity: Velocity limits, shape (n,) [rad/s].
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].

    Raises:
        InvalidLog: If a field has the wrong shape, the time does not increase, or a quaternion is not of length 1.
    """

    t: np.ndarray
    q: np.ndarray | None = None
    dq: np.ndarray | None = None
    q_ref: np.ndarray | None = None
    dq_ref: np.ndarray | None = None
    ddq_ref: np.ndarray | None = None
    tau_cmd: np.ndarray | None = None
    tau_lim: np.ndarray | None = None
    tau: np.ndarray | None = None
    p: np.ndarray | None = None
    p_ref: np.ndarray | None = None
    quat: np.ndarray | None = None
    quat_ref: np.ndarray | None = None
    twist: np.ndarray | None = None
    twist_ref: np.ndarray | None = None
    wrench: np.ndarray | None = None
    lap: float | None = None
    mass: float | None = None
    effort: np.ndarray | None = None
    torque_rate: np.ndarray | None = None
    velocity: np.ndarray | None = None
    lower: np.ndarray | None = None
    upper: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Turn lists into arrays, and refuse what cannot be a log."""
        for name, value in self._given().items():
            if name not in ("lap", "mass"):
                object.__setattr__(self, name, _array(name, value))
        for name in ("lap", "mass"):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise InvalidLog(name, f"{value}", "valid is a number above 0, or nothing")
        _check_time(self.t)
        self._check_shapes()
        for name in ("quat", "quat_ref"):
            if getattr(self, name) is not None:
                _check_quaternions(name, getattr(self, name))

    @cached_property
    def dt(self) -> float:
        """The period [s].

        Raises:
            InvalidLog: If the time steps are not even.
        """
        steps = np.diff(self.t)
        period = float(self.t[-1] - self.t[0]) / len(steps)
        worst = int(np.abs(steps - period).argmax())
        if abs(steps[worst] - period) > UNEVEN * period:
            came = f"a step of {steps[worst]:.6g} s in row {worst} where the mean is {period:.6g} s"
            raise InvalidLog("t", came, "valid are even steps: resample the log to a period")
        return period

    def resampled(self, period: float) -> "Log":
        """Return the log at even steps: straight lines between samples, great arcs between attitudes.

        Args:
            period: Time between rows [s].

        Raises:
            InvalidLog: If the period is not positive, or a gap is longer than five samples.
        """
        steps = np.diff(self.t)
        if not period > 0.0:
            raise InvalidLog("period", f"{period}", "valid is a number of seconds above 0")
        if steps.max() > WIDEST_GAP * float(np.median(steps)):
            came = f"a gap of {steps.max():.6g} s in row {int(steps.argmax())}"
            raise InvalidLog("t", came, "valid are gaps of at most five samples: cut the log there")
        t = self.t[0] + np.arange(math.floor((self.t[-1] - self.t[0]) / period + 1e-6) + 1) * period
        changed = {name: value for name, value in self._given().items() if name in JOINTS or name in WIDTHS}
        between: dict[str, Any] = {
            name: (_attitudes if name.startswith("quat") else _lines)(t, self.t, value)
            for name, value in changed.items()
        }
        return replace(self, t=t, **between)

    def doubts(self) -> list[str]:
        """Return what looks like another unit, a sentence each."""
        found = []
        for name in ("q", "q_ref"):
            value = getattr(self, name)
            if value is not None and np.abs(value).max(initial=0.0) > DEGREES:
                found.append(f"{name} goes beyond 4 pi; is it in degrees?")
        for name in ("p", "p_ref"):
            value = getattr(self, name)
            if value is not None and np.abs(value).max(initial=0.0) > MILLIMETRES:
                found.append(f"{name} goes beyond 10 m; is it in millimetres?")
        return found

    def _given(self) -> dict[str, np.ndarray]:
        """Return the fields that are not None."""
        return {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) is not None}

    def _check_shapes(self) -> None:
        """Compare every field with the number of ticks, and of joints."""
        ticks, given = len(self.t), self._given()
        joints = next((value.shape[-1] for name, value in given.items() if name in JOINTS and value.ndim == 2), None)
        for name, value in given.items():
            if name in JOINTS or name in WIDTHS:
                valid = (ticks, WIDTHS.get(name, joints))
            elif name in LIMITS:
                valid = (joints,) if joints is not None else value.shape[:1]
            else:
                continue
            if value.shape != valid:
                raise InvalidLog(name, f"shape {value.shape}", f"valid is {valid}, a row for each of {ticks} times")


def _array(name: str, value: object) -> np.ndarray:
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidLog(name, " ".join(str(error).split()), "valid are numbers, equally many in each row") from error


def _check_time(t: np.ndarray) -> None:
    if t.ndim != 1 or len(t) < 2:
        raise InvalidLog("t", f"shape {t.shape}", "valid are two times or more, shape (N,)")
    bad = np.flatnonzero(~(np.diff(t) > 0.0) | ~np.isfinite(t[1:]) | ~np.isfinite(t[:-1]))
    if len(bad):
        row = int(bad[0])
        raise InvalidLog("t", f"{t[row + 1]:.9g} s in row {row + 1} after {t[row]:.9g} s", "valid is a time that grows")


def _check_quaternions(name: str, quat: np.ndarray) -> None:
    """Refuse lengths other than 1; samples that are not finite are left to the metrics, which fail on them."""
    off = np.abs(np.linalg.norm(quat, axis=1) - 1.0)
    if np.isfinite(off).any() and np.nanmax(off) > UNIT_LENGTH:
        row = int(np.nanargmax(off))
        raise InvalidLog(name, f"length {np.linalg.norm(quat[row]):.4g} in row {row}", "valid are unit quaternions")


def _lines(t: np.ndarray, times: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Return samples at other times, straight between ticks."""
    return np.column_stack([np.interp(t, times, column) for column in samples.T])


def _attitudes(t: np.ndarray, times: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Return attitudes at other times, along great arcs; NaN beside a sample that is not finite."""
    from scipy.spatial.transform import Rotation, Slerp

    known, lost = np.isfinite(samples).all(axis=1), ~np.isfinite(_lines(t, times, samples)).all(axis=1)
    if known.sum() < 2:
        return np.full((len(t), 4), np.nan)
    times, arcs = times[known], Slerp(times[known], Rotation.from_quat(samples[known]))
    return np.where(lost[:, None], np.nan, arcs(t.clip(times[0], times[-1])).as_quat())
