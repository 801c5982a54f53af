"""A curve in letters, for a terminal."""

import numpy as np

BLOCKS = " \N{LOWER ONE EIGHTH BLOCK}\N{LOWER ONE QUARTER BLOCK}\N{LOWER THREE EIGHTHS BLOCK}\N{LOWER HALF BLOCK}" + (
    "\N{LOWER FIVE EIGHTHS BLOCK}\N{LOWER THREE QUARTERS BLOCK}\N{LOWER SEVEN EIGHTHS BLOCK}\N{FULL BLOCK}"
)
"""From nothing to a whole cell, by eighths."""


def plot(x: np.ndarray, y: np.ndarray, *, title: str, width: int = 64, height: int = 8) -> str:
    """Return a curve of values from zero up as lines of text.

    Every column is as high as the largest of its samples: striding would lose peaks.

    Args:
        x: Evenly spaced, shape (K,).
        y: Not negative, shape (K,).
        title: What it shows, with its unit.
        width: Columns of the curve.
        height: Rows of the curve.
    """
    columns = np.array([part.max() for part in np.array_split(y, min(width, len(y)))])
    top = float(columns.max()) or 1.0
    eighths = np.ceil(columns / top * height * 8 - 1e-9).astype(int)
    rows = [
        "".join(BLOCKS[min(max(level - 8 * below, 0), 8)] for level in eighths.tolist())
        for below in reversed(range(height))
    ]
    labels = [f"{top:.3g}", *[""] * (height - 2), "0"]
    margin = max(map(len, labels))
    ends = f"{x[0]:g}", f"{x[-1]:g} s"
    axis = " " * (margin + 2) + ends[0] + ends[1].rjust(len(columns) - len(ends[0]))
    body = [f"{label:>{margin}} \N{BOX DRAWINGS LIGHT VERTICAL}{row}" for label, row in zip(labels, rows, strict=True)]
    return "\n".join([title, *body, axis])
