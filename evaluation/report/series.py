"""Series on their way into a script: sixteen bits a sample, and peaks that survive where samples are left out."""

import base64

import numpy as np

STEPS = 65534
"""Steps between the least and the largest sample of a series."""
NOTHING = 65535
"""Stands where a sample is not finite."""
MOST = 1200
"""Most samples of a series that is only drawn."""

Series = dict[str, object]


def quantised(values: np.ndarray) -> Series:
    """Return a series in sixteen bits: sample i is ``low + step * data[i]``, off by half a step at most.

    Args:
        values: Shape (K,).

    Returns:
        ``low``, ``step``, and ``data``: little-endian unsigned integers in base 64, 65535 where a sample is not finite.
    """
    values = np.asarray(values, dtype=float)
    finite = np.isfinite(values)
    # Numbers are rounded to single precision first, so that they are short; the samples are counted from those.
    low = float(np.float32(values[finite].min())) if finite.any() else 0.0
    span = float(values[finite].max()) - low if finite.any() else 0.0
    step = float(f"{span / STEPS * (1 + 1e-6):.7g}") if span > 0.0 else 1.0
    whole = np.full(len(values), NOTHING, dtype="<u2")
    whole[finite] = np.clip(np.rint((values[finite] - low) / step), 0, STEPS).astype("<u2")
    return {"low": float(f"{low:.9g}"), "step": step, "data": base64.b64encode(whole.tobytes()).decode("ascii")}


def thinned(values: np.ndarray, most: int = MOST) -> tuple[np.ndarray, int]:
    """Return the least and the largest sample of equal parts of a series, in their order: no peak is lost.

    Args:
        values: Shape (K,).
        most: Most samples that may remain.

    Returns:
        The samples, and how many of the old ones two of them stand for; the series as it came and 2 if it is short.
    """
    if len(values) <= most:
        return values, 2
    part = -(-2 * len(values) // most)
    parts = -(-len(values) // part)
    padded = np.concatenate([values, np.full(parts * part - len(values), values[-1])]).reshape(parts, part)
    finite = np.isfinite(padded)
    low = np.argmin(np.where(finite, padded, np.inf), axis=1)
    high = np.argmax(np.where(finite, padded, -np.inf), axis=1)
    order = np.sort(np.column_stack([low, high]), axis=1)
    return np.take_along_axis(padded, order, axis=1).ravel(), part
