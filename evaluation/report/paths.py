"""The motions in space, with the error along the path: where on its way a controller errs."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np

from ...controllers import InvalidInput
from ...scenarios.store import Store
from .findings import POSITION, Findings
from .numbers import counting, significant
from .worlds import Run

PARTS = 72
"""Parts of a lap; each is drawn by the largest error within it."""
SHARES = (0.2, 0.4, 0.6, 0.8)
"""Shares of all parts at which the next width of line begins, before the limits are rounded."""
SIZE, GAP = 150, 14
"""Side of a view, and room around it."""
AXES = "xyz"


@dataclass(frozen=True, kw_only=True)
class PathDrawing:
    """One motion as one controller followed it.

    Attributes:
        trajectory: Name of the motion.
        label: The controller.
        load: The load in words.
        points: Planned tool positions at the ends of the parts of the last lap, shape (parts + 1, 3) [m].
        errors: Largest position error within each part, shape (parts,) [mm].
        href: The run's row.
    """

    trajectory: str
    label: str
    load: str
    points: np.ndarray
    errors: np.ndarray
    href: str

    @property
    def most(self) -> str:
        """The largest error, with its unit."""
        return f"{significant(float(self.errors.max()))} mm"


@dataclass(frozen=True, kw_only=True)
class PathsPanel:
    """The motions of a world on the page.

    Attributes:
        limits: Errors at which the next width of line begins, increasing [mm].
        motions: Name of each motion and its drawings.
    """

    limits: tuple[float, ...]
    motions: Sequence[tuple[str, Sequence[PathDrawing]]]

    @property
    def legend(self) -> list[tuple[int, str]]:
        """Return width class and meaning of each width."""
        texts = [significant(limit, 2) for limit in self.limits]
        between = [f"{low} to {high} mm" for low, high in pairwise(texts)]
        return list(enumerate([f"below {texts[0]} mm", *between, f"above {texts[-1]} mm"] if texts else ["all"]))

    def draw(self, drawing: PathDrawing) -> str:
        """Return a drawing as an ``svg`` element: two views to one scale, the widest plane of the motion first."""
        first, second, third = np.argsort(-np.ptp(drawing.points, axis=0), kind="stable")
        middle = (drawing.points.min(axis=0) + drawing.points.max(axis=0)) / 2.0
        scale = (SIZE - 2 * GAP) / max(float(np.ptp(drawing.points, axis=0).max()), 1e-6)
        places = SIZE / 2 + scale * (drawing.points - middle) * np.array([1.0, 1.0, -1.0])
        title = f"{drawing.trajectory}, {drawing.label}, {drawing.load}: largest error of the last lap {drawing.most}"
        views = [sorted((first, second)), sorted((first, third))]
        return (
            f'<svg class="way" role="img" viewBox="0 0 {2 * SIZE} {SIZE}"><title>{escape(title)}</title>'
            + "".join(self._view(places, drawing.errors, axes, SIZE * number) for number, axes in enumerate(views))
            + "</svg>"
        )

    def _view(self, places: np.ndarray, errors: np.ndarray, axes: Sequence[int], left: int) -> str:
        right, up = axes
        parts: dict[int, list[str]] = {}
        for number, error in enumerate(errors):
            (x, y), (u, v) = places[number, axes], places[number + 1, axes]
            # The z axis was turned over already; y is when it points up the page.
            y, v = (SIZE - y, SIZE - v) if up == 1 else (y, v)
            width = int(np.searchsorted(self.limits, error, side="right"))
            parts.setdefault(width, []).append(f"M{x + left:.1f} {y:.1f}L{u + left:.1f} {v:.1f}")
        lines = "".join(f'<path class="way-{width}" d="{"".join(moves)}"/>' for width, moves in sorted(parts.items()))
        named = f"{AXES[right]} \N{RIGHTWARDS ARROW}, {AXES[up]} \N{UPWARDS ARROW}"
        return f'{lines}<text x="{left + 4}" y="{SIZE - 3}">{named}</text>'


def paths_panel(findings: Findings, store: Store) -> PathsPanel | None:
    """Return the motions as the first of the ranking and the reference followed them; None without any trace.

    Args:
        findings: The world's findings.
        store: The open store that it comes from.
    """
    labels = list(dict.fromkeys([*findings.ranked(POSITION)[:1], findings.world.reference]))
    motions: dict[str, list[PathDrawing]] = {}
    for label in labels:
        for run in _one_each(findings.runs_of(label)):
            drawing = _drawing(run, store)
            if drawing is not None:
                motions.setdefault(drawing.trajectory, []).append(drawing)
    if not motions:
        return None
    errors = np.concatenate([drawing.errors for drawings in motions.values() for drawing in drawings])
    limits = dict.fromkeys(float(f"{np.quantile(errors, share):.1g}") for share in SHARES)
    return PathsPanel(
        limits=tuple(limit for limit in limits if limit > 0.0),
        motions=sorted(motions.items(), key=lambda item: counting(item[0])),
    )


def _one_each(runs: Iterable[Run]) -> list[Run]:
    """Return one finished run of each motion: its heaviest load, its first repetition."""
    found: dict[str, Run] = {}
    for run in sorted(runs, key=lambda run: (-run.row.mass, run.row.material, run.row.repetition)):
        if run.row.status == "ok" and run.stored.trace:
            found.setdefault(run.row.trajectory, run)
    return list(found.values())


def _drawing(run: Run, store: Store) -> PathDrawing | None:
    try:
        trace = store.trace(run.stored.trace)
        points, errors = _last_lap(trace, run.stored.specification.laps)
    except (InvalidInput, KeyError, ValueError, IndexError):
        # A trace that cannot be read costs its drawing, not the page.
        return None
    return PathDrawing(
        trajectory=run.row.trajectory,
        label=run.row.controller,
        load=run.load,
        points=points,
        errors=errors,
        href=f"#{run.anchor}",
    )


def _last_lap(trace: Mapping[str, np.ndarray], laps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return places and errors of the parts of the last lap; a motion returns to where it began."""
    t, p, p_ref = (trace[name].astype(float) for name in ("t", "p", "p_ref"))
    half = 0.5 * (t[1] - t[0])
    rows = np.flatnonzero(t >= -half)
    rows = rows[-(len(rows) // laps) :]
    errors = 1e3 * np.linalg.norm(p[rows] - p_ref[rows], axis=1)
    starts = np.unique(np.linspace(0, len(rows), PARTS, endpoint=False).astype(int))
    points = p_ref[rows[starts]]
    return np.vstack([points, points[:1]]), np.maximum.reduceat(errors, starts)
