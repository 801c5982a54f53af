"""Distance to the reference path as a curve, wherever on it the tool should be by now."""

import math

import numpy as np

from .shared import shared_series

BLOCKS = (64, 16, 4, 1)
"""Segments in a block, level by level of the search."""

ROWS = 1024
"""Ticks searched at once; bounds the memory where nothing can be pruned."""


@shared_series
def contour_distances(p: np.ndarray, p_ref: np.ndarray, dt: float, lap: float) -> np.ndarray:
    """Return the distance of each tool position to the reference polyline within a quarter lap of its tick.

    The polyline consists of segments, not of vertices, and is closed if the reference is a number of whole laps.
    The window keeps a figure that crosses itself from lending its other branch. The search is exact: blocks of the
    path are replaced by their chords, whose distance bounds the block's from both sides by its bulge, and only
    blocks that can still win are split.

    Args:
        p: Tool positions, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].
        dt: Control period [s].
        lap: Duration of one lap [s]; infinite for a reference that is no cycle.

    Returns:
        Shape (N,) [m].
    """
    ticks = len(p)
    closed = _is_closed(p_ref, dt, lap)
    reach = max(1, round(lap / dt / 4)) if math.isfinite(lap) else ticks
    reach = min(reach, max(ticks // 2, 1) if closed else ticks)
    margin = BLOCKS[0] * math.ceil((reach + 1) / BLOCKS[0])
    index = np.arange(-margin, margin + BLOCKS[0] * math.ceil((ticks + 1) / BLOCKS[0]) + 1)
    path = p_ref[index % ticks if closed else np.clip(index, 0, ticks - 1)]
    levels = [_Chords(path, size) for size in BLOCKS]
    result = np.empty(ticks)
    for start in range(0, ticks, ROWS):
        own = np.arange(start, min(start + ROWS, ticks))
        result[own] = _nearest(p[own], own + margin, reach, path, levels)
    return result


def _is_closed(p_ref: np.ndarray, dt: float, lap: float) -> bool:
    """Return whether the rows are whole laps whose end meets their beginning."""
    laps = len(p_ref) * dt / lap
    if len(p_ref) < 3 or round(laps) < 1 or abs(laps - round(laps)) * lap > 0.75 * dt:
        return False
    step = np.linalg.norm(np.diff(p_ref, axis=0), axis=1).max()
    return bool(np.linalg.norm(p_ref[0] - p_ref[-1]) <= 2.0 * step)


class _Chords:
    """The path in blocks of equally many segments, each with its chord and the bulge of the path beside it."""

    def __init__(self, path: np.ndarray, size: int) -> None:
        self.size = size
        self.start = np.ascontiguousarray(path[:-1:size])
        self.chord = path[size::size] - self.start
        squares = np.einsum("bd,bd->b", self.chord, self.chord)
        # A block that returns to its start has no chord: its start stands in, and the bulge covers the rest.
        self.inverse = np.divide(1.0, squares, out=np.zeros_like(squares), where=squares > 0.0)
        inner = np.arange(len(self.start))[:, None] * size + np.arange(1, size)
        blocks = np.broadcast_to(np.arange(len(self.start))[:, None], inner.shape)
        self.bulge = self.distance(path[inner.ravel()], blocks.ravel()).reshape(inner.shape).max(axis=1, initial=0.0)

    def distance(self, points: np.ndarray, blocks: np.ndarray) -> np.ndarray:
        """Return the distance of each point to the chord of its block, shape (M,) [m]."""
        offset = points - self.start[blocks]
        chord = self.chord[blocks]
        along = np.clip(np.einsum("md,md->m", offset, chord) * self.inverse[blocks], 0.0, 1.0)
        offset -= along[:, None] * chord
        return np.asarray(np.sqrt(np.einsum("md,md->m", offset, offset)))


def _nearest(points: np.ndarray, own: np.ndarray, reach: int, path: np.ndarray, levels: list[_Chords]) -> np.ndarray:
    """Return the distance of each point to the segments within ``reach`` of its own vertex of the path."""
    best: np.ndarray = np.linalg.norm(points - path[own], axis=1)
    row, block = _within_spheres(points, own, reach, path, levels[0], best)
    for chords, finer in zip(levels, [*levels[1:], None], strict=True):
        first, last = block * chords.size, (block + 1) * chords.size
        overlaps = (first < own[row] + reach) & (last > own[row] - reach)
        row, block, first, last = row[overlaps], block[overlaps], first[overlaps], last[overlaps]
        distance, bulge = chords.distance(points[row], block), chords.bulge[block]
        inside = (first >= own[row] - reach) & (last <= own[row] + reach)
        np.minimum.at(best, row[inside], (distance + bulge)[inside])
        if finer is None:
            break
        # Strictly below: where no block can beat the bound, the bound itself is attained.
        open_ = distance - bulge < best[row]
        split = chords.size // finer.size
        row = np.repeat(row[open_], split)
        block = (block[open_][:, None] * split + np.arange(split)).ravel()
    return best


def _within_spheres(
    points: np.ndarray, own: np.ndarray, reach: int, path: np.ndarray, chords: _Chords, best: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of row and coarse block that can hold the nearest point; tightens ``best`` in place."""
    size = chords.size
    first, last = (own[0] - reach) // size, (own[-1] + reach) // size + 1
    blocks = np.arange(max(first, 0), min(last, len(chords.start)))
    middle = blocks * size + size // 2
    centre = path[middle]
    members = path[blocks[:, None] * size + np.arange(size + 1)]
    radius = np.linalg.norm(members - centre[:, None], axis=2).max(axis=1)
    # Coordinate by coordinate: a third of the time of one array of differences.
    distance = np.zeros((len(points), len(centre)))
    for axis in range(points.shape[1]):
        difference = points[:, axis, None] - centre[:, axis]
        difference *= difference
        distance += difference
    np.sqrt(distance, out=distance)
    inside = np.abs(middle - own[:, None]) <= reach
    np.minimum(best, np.where(inside, distance, np.inf).min(axis=1), out=best)
    row, column = np.nonzero(distance - radius < best[:, None])
    return row, blocks[column]
