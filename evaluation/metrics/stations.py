"""Where each lap of an attained path crosses the planes normal to the command path, as ISO 9283 wants it."""

from dataclasses import dataclass

import numpy as np

from .geometry import rotation_vectors
from .laps import lap_bounds
from .shared import shared

STATIONS = 50
"""Planes along one lap of the command path, equally far apart; the standard asks for no fewer."""

RESTING_PATH = 1e-3
"""Length of a lap below which the command path is a point [m]."""

LEFT_OUT = 0.1
"""Share of the stations that may go without: a late tool crosses the last planes after the end of the log."""


SHORT_SEARCH = 16
"""Share of the search for a crossing that is looked through first."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """The attained laps at the stations of the command path.

    Attributes:
        offset: Attained less command point, in the plane, shape (stations, laps, 3) [m]; NaN where a lap never crosses.
        when: Row at which each lap crosses, with its fraction, shape (stations, laps); NaN likewise.
        row: Row of each station in the first lap, with its fraction, shape (stations,).
    """

    offset: np.ndarray
    when: np.ndarray
    row: np.ndarray


@shared
def station_crossings(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> Crossings | None:
    """Find where each whole lap crosses the planes normal to the command path.

    A lap crosses in the direction of the path, within a quarter lap of the plan; of several crossings the one nearest
    in time counts. Between ticks the attained path is straight.

    Args:
        p: Tool positions from phase 0 of a lap, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s].

    Returns:
        The crossings; None without a whole lap, or if the command path is a point.
    """
    bounds = lap_bounds(len(p), lap, dt)
    if len(bounds) < 2 or bounds[1] < 3:
        return None
    path = p_ref[: bounds[1]]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    if length[-1] < RESTING_PATH:
        return None
    row, point, tangent = _planes(path, length)
    reach = round(lap / dt / 4)
    rows = bounds[:-1] + row[:, None]
    # A crossing near the plan is nearer than all that the short search leaves out: the long one is for the rest.
    when = _crossings(p, point, tangent, rows, reach // SHORT_SEARCH)
    late = np.isnan(when).any(axis=1)
    when[late] = _crossings(p, point[late], tangent[late], rows[late], reach)
    crossed = np.isfinite(when)
    offset = at_rows(p, np.where(crossed, when, 0.0)) - point[:, None]
    return Crossings(np.where(crossed[..., None], offset, np.nan), when, row)


def _planes(path: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return row with fraction, point and unit normal of each station, equally far apart along a path."""
    moving = np.flatnonzero(np.diff(length, prepend=-1.0) > 0.0)
    along = (np.arange(STATIONS) + 0.5) / STATIONS * length[-1]
    after = np.searchsorted(length[moving], along)
    start, end = path[moving[after - 1]], path[moving[after]]
    share = (along - length[moving[after - 1]]) / (length[moving[after]] - length[moving[after - 1]])
    tangent = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    return np.interp(along, length[moving], moving), start + share[:, None] * (end - start), tangent


def _crossings(p: np.ndarray, point: np.ndarray, tangent: np.ndarray, rows: np.ndarray, reach: int) -> np.ndarray:
    """Return the rows at which a path crosses planes forwards, nearest to the planned rows; NaN where it does not.

    Args:
        p: Positions, shape (N, 3) [m].
        point: A point of each plane, shape (planes, 3) [m].
        tangent: Its unit normal, shape (planes, 3).
        rows: Planned row of each lap at each plane, shape (planes, laps).
        reach: How far from the planned row a crossing may be.
    """
    first = rows.astype(int) - reach
    searched = (first[..., None] + np.arange(2 * reach + 2)).clip(0, len(p) - 1)
    height = np.einsum("slkd,sd->slk", p[searched], tangent) - np.einsum("sd,sd->s", point, tangent)[:, None, None]
    below = height <= 0.0
    plane, lap, up = np.nonzero(below[..., :-1] > below[..., 1:])
    start, rise = height[plane, lap, up], height[plane, lap, up + 1] - height[plane, lap, up]
    found = searched[plane, lap, up] - start / rise
    # Written from the farthest to the nearest, so that of several crossings the nearest stays.
    order = np.argsort(-np.abs(found - rows[plane, lap]), kind="stable")
    when = np.full(rows.shape, np.nan)
    when[plane[order], lap[order]] = found[order]
    return when


def at_rows(samples: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return samples at rows with fractions, straight between ticks.

    Args:
        samples: Shape (N, d).
        rows: Any shape, from 0 to N - 1.

    Returns:
        Shape (..., d).
    """
    before = np.minimum(rows.astype(int), len(samples) - 2)
    share = (rows - before)[..., None]
    return np.asarray((1.0 - share) * samples[before] + share * samples[before + 1])


@shared
def station_rotations(found: Crossings, quat: np.ndarray, quat_ref: np.ndarray) -> np.ndarray:
    """Return the attitude at each crossing as seen from the commanded attitude of its station.

    Args:
        found: The crossings of the same ticks.
        quat: Tool attitudes xyzw, shape (N, 4).
        quat_ref: Reference attitudes xyzw, shape (N, 4).

    Returns:
        Rotation vectors in the commanded tool's axes, shape (stations, laps, 3) [rad]; NaN where a lap never crosses.
    """
    crossed = np.isfinite(found.when)
    rows = np.where(crossed, found.when, 0.0)
    commanded = np.broadcast_to(_attitudes(quat_ref, found.row)[:, None, :], (*rows.shape, 4))
    vectors = rotation_vectors(_attitudes(quat, rows).reshape(-1, 4), commanded.reshape(-1, 4))
    return np.where(crossed[..., None], vectors.reshape(*rows.shape, 3), np.nan)


def _attitudes(quat: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return attitudes at rows with fractions; of a tick's two quaternions the nearer sign."""
    before = np.minimum(rows.astype(int), len(quat) - 2)
    share = (rows - before)[..., None]
    one, other = quat[before], quat[before + 1]
    other = np.where((one * other).sum(axis=-1, keepdims=True) < 0.0, -other, other)
    return np.asarray((1.0 - share) * one + share * other)


def crossed_by_all(samples: np.ndarray) -> np.ndarray | None:
    """Return the stations that every lap crosses: a mean over other laps at each station would compare nothing.

    Args:
        samples: Shape (stations, laps, d), NaN where a lap does not cross.

    Returns:
        Shape (some stations, laps, d); None if more than a tenth of the stations are left out.
    """
    crossed = np.isfinite(samples).all(axis=(1, 2))
    return samples[crossed] if crossed.mean() >= 1.0 - LEFT_OUT else None
