"""Corner overshoot in the style of ISO 9283:1998, 8.5: for polygons; the motions that ship have no corner."""

import math

import numpy as np

from .registry import UNDEFINED, metric

CORNER = math.radians(30.0)
"""Turn of the command path from one step to the next that makes a corner [rad]."""

SMALLEST_STEP = 1e-9
"""Step of a reference that rests [m]."""


def corner_rows(p_ref: np.ndarray) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Find the corners of a command path.

    Args:
        p_ref: Reference positions, shape (N, 3) [m].

    Returns:
        For each corner the row in which it is reached, that of the next one (or the end), and the directions before
        and after, each (3,).
    """
    steps = np.diff(p_ref, axis=0)
    size = np.linalg.norm(steps, axis=1)
    moving = np.flatnonzero(size > SMALLEST_STEP)
    direction = steps[moving] / size[moving, None]
    turns = np.flatnonzero(np.einsum("kd,kd->k", direction[:-1], direction[1:]) < math.cos(CORNER))
    # A plan may rest in its corner: the tool runs on from the row of arrival.
    rows = [int(moving[turn]) + 1 for turn in turns]
    ends = [*rows[1:], len(p_ref)]
    return [(row, end, direction[t], direction[t + 1]) for row, end, t in zip(rows, ends, turns, strict=False)]


@metric(
    unit="m",
    better="lower",
    family="iso",
    needs=("p", "p_ref"),
    source="ISO 9283:1998, 8.5.3, CO",
    label="corner overshoot, ISO style",
)
def iso_corner_overshoot(p: np.ndarray, p_ref: np.ndarray) -> float:
    """Largest distance by which the tool runs on beyond a corner, from the edge that follows it.

    A corner is a turn of the reference of more than 30 degrees from one step to the next. The distance is taken at
    right angles to the edge after the corner, on its outer side, until the next corner.

    Args:
        p: Tool positions, base frame, shape (N, 3) [m].
        p_ref: Reference positions of the same ticks, shape (N, 3) [m].

    Returns:
        The distance [m], 0 if no corner is overshot; NaN if any sample is not finite or the reference has no corner.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of ticks.
    """
    worst = UNDEFINED
    for row, end, before, after in corner_rows(p_ref):
        outward = before - (before @ after) * after
        size = float(np.linalg.norm(outward))
        # A path that turns back on itself overshoots along its own line.
        outward = outward / size if size > SMALLEST_STEP else before
        beyond = max(float(((p[row:end] - p_ref[row]) @ outward).max()), 0.0)
        worst = beyond if math.isnan(worst) else max(worst, beyond)
    return worst
