"""The shift in time that fits a motion to its reference best."""

from dataclasses import dataclass

import numpy as np

from .shared import shared

LONGEST, SHARE = 0.2, 8
"""The longest shift tried [s], and the part of the window it may not exceed (one eighth)."""


@dataclass(frozen=True)
class Shift:
    """A fitted shift of the reference.

    Attributes:
        lag: Time by which the motion is late [s].
        square: Mean squared error that is left, in the motion's unit squared.
        unshifted: Mean squared error without a shift, over the same ticks.
        censored: Whether the fit sits at the longest shift tried, so that the lag may be longer.
    """

    lag: float
    square: float
    unshifted: float
    censored: bool


@shared
def best_shift(x: np.ndarray, x_ref: np.ndarray, dt: float, resting: float) -> Shift | None:
    """Fit the shift s that minimises the mean of ``|x(k) - x_ref(k - s)|^2``.

    Ticks at which some shift would leave the window are not used. A parabola through the three lowest points
    resolves a fraction of a tick.

    Args:
        x: The motion, shape (N, d).
        x_ref: Its reference, shape (N, d).
        dt: Control period [s].
        resting: Spread of the reference below which a shift has no meaning, in the motion's unit.

    Returns:
        The fit; None if the reference rests or the window is too short for a shift of one tick.
    """
    longest = int(min(LONGEST / dt, len(x) / SHARE) + 1e-9)
    # One tick of shift has a border on either side and leaves nothing for a parabola.
    if longest < 2 or np.sqrt(x_ref.var(axis=0).sum()) < resting:
        return None
    best = int(np.argmin(_squares_by_shift(x, x_ref, longest))) - longest
    here, unshifted = _square(x, x_ref, best, longest), _square(x, x_ref, 0, longest)
    if here == 0.0 or abs(best) == longest:
        # A perfect fit needs no parabola, which would turn the ends of the window into a fraction of a tick.
        return Shift(best * dt, here, unshifted, censored=abs(best) == longest)
    before, after = (_square(x, x_ref, best + step, longest) for step in (-1, 1))
    curvature = before - 2.0 * here + after
    offset = 0.5 * (before - after) / curvature if curvature > 0.0 else 0.0
    return Shift((best + offset) * dt, max(here - 0.25 * (before - after) * offset, 0.0), unshifted, censored=False)


def _square(x: np.ndarray, x_ref: np.ndarray, shift: int, longest: int) -> float:
    """Return the mean squared error at one shift, over the ticks at which every shift exists."""
    stop = len(x) - longest
    difference = x[longest:stop] - x_ref[longest - shift : stop - shift]
    return float(np.einsum("kd,kd->", difference, difference) / len(difference))


def _squares_by_shift(x: np.ndarray, x_ref: np.ndarray, longest: int) -> np.ndarray:
    """Return the same for all shifts from -longest to longest by one correlation, up to a common constant."""
    centre = x_ref.mean(axis=0)
    reference = x_ref - centre
    inner = np.zeros_like(reference)
    inner[longest : len(x) - longest] = x[longest : len(x) - longest] - centre
    length = 1 << (len(x) + 2 * longest).bit_length()
    spectra = np.conj(np.fft.rfft(reference, length, axis=0)) * np.fft.rfft(inner, length, axis=0)
    correlation = np.fft.irfft(spectra.sum(axis=1), length)
    shifts = np.arange(-longest, longest + 1)
    energy = np.concatenate([[0.0], np.cumsum(np.einsum("kd,kd->k", reference, reference))])
    squares = energy[len(x) - longest - shifts] - energy[longest - shifts] - 2.0 * correlation[shifts]
    return np.asarray(squares)
