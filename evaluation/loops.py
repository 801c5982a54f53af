r"""Margins of feedback loops from measured responses, on bare arrays.

With a signal w added to the controller's output u of one channel after the other, every loop closed, the applied
signal is a = u + w, and the columns of two matrices are measured at each frequency:

.. math:: T = -U W^{-1}, \quad S = A W^{-1} = I - T

They are the complementary sensitivity and the sensitivity at the plant's input. The loop that is broken at channel j
while the others stay closed is L_j = -U_jj / A_jj = T_jj / (1 - T_jj).
Source: Skogestad and Postlethwaite, Multivariable Feedback Control (2005), sections 2.4 and 3.2; for disk margins
Seiler, Packard and Gahinet, An Introduction to Disk Margins, IEEE Control Systems 40 (2020).
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class LoopMargins:
    """The classical margins of one loop; infinite where the response never crosses.

    Attributes:
        gain: Gain margin, the factor nearest to 1 that reaches the edge of stability, below 1 for a loss of gain.
        phase: Smallest phase margin [deg].
        delay: Smallest delay that takes the loop to the edge of stability [s].
        modulus: Smallest distance of the response from -1.
        crossover: Gain crossover of the smallest phase margin, NaN without one [rad/s].
    """

    gain: float
    phase: float
    delay: float
    modulus: float
    crossover: float


@dataclass(frozen=True, kw_only=True)
class DiskMargin:
    """A disk margin without skew.

    Attributes:
        alpha: Size of the disk of simultaneous gain and phase errors.
        gain: Factor by which the gain may rise or fall, (2 + alpha) / (2 - alpha); infinite from alpha 2 on.
        phase: Phase that may be lost, 2 atan(alpha / 2) [deg].
        omega: Frequency of the worst case [rad/s].
    """

    alpha: float
    gain: float
    phase: float
    omega: float


def closed_loop(commands: np.ndarray, injection: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Return the measured complementary sensitivity of each period.

    Args:
        commands: Controller outputs while one channel after the other was excited, shape (n, periods, samples, n).
        injection: What was added to the excited channel, one period, shape (n, samples).
        lines: Cycles within the period at which something was injected, shape (F,).

    Returns:
        T, shape (periods, F, n, n); column j belongs to the excitation of channel j.
    """
    lines = np.asarray(lines, dtype=int)
    outputs = np.fft.rfft(commands, axis=2)[:, :, lines]
    inputs = np.fft.rfft(injection, axis=1)[:, lines]
    return np.asarray(-np.moveaxis(outputs / inputs[:, None, :, None], 0, -1))


def broken_loops(closed: np.ndarray) -> np.ndarray:
    """Return the response of every loop broken at one channel while the others stay closed.

    Args:
        closed: T, shape (F, n, n).

    Returns:
        L_j at each frequency, shape (F, n).
    """
    own = np.diagonal(closed, axis1=1, axis2=2)
    return np.asarray(own / (1.0 - own))


def scatter(closed: np.ndarray) -> np.ndarray:
    """Return how little the periods agree: the relative standard error of each channel's disk margin.

    Args:
        closed: T of at least two periods, shape (periods, F, n, n).

    Returns:
        Largest standard error of the mean over periods, over the largest magnitude of (S - T) / 2, shape (n,).
    """
    own = np.diagonal(closed, axis1=2, axis2=3)
    error = own.std(axis=0, ddof=1) / np.sqrt(len(own))
    return np.asarray(error.max(axis=0) / np.abs(0.5 - own.mean(axis=0)).max(axis=0))


def loop_margins(response: np.ndarray, omega: np.ndarray) -> LoopMargins:
    """Return the classical margins of a loop, from a spline through its response.

    Args:
        response: L at each frequency, shape (F,), at least four.
        omega: Frequencies, increasing, shape (F,) [rad/s].
    """
    import control

    measured = control.frd(response, omega, smooth=True)
    gains, phases, moduli, _, crossovers, _ = control.stability_margins(measured, returnall=True)
    if not len(phases):
        phase = delay = math.inf
        crossover = math.nan
    else:
        nearest = int(np.argmin(np.abs(phases)))
        phase, crossover = float(phases[nearest]), float(crossovers[nearest])
        delay = float(np.min(np.radians(np.remainder(phases, 360.0)) / crossovers))
    smallest = np.abs(1.0 + response).min()
    return LoopMargins(
        gain=float(gains[np.argmin(np.abs(np.log(gains)))]) if len(gains) else math.inf,
        phase=phase,
        delay=delay,
        modulus=float(min(moduli.min(initial=math.inf), smallest)),
        crossover=crossover,
    )


def disk_margin(response: np.ndarray, omega: np.ndarray) -> DiskMargin:
    r"""Return the disk margin of a loop at the measured frequencies.

    .. math:: \alpha = 1 / \max_\omega |\tfrac{1}{2} (S - T)|, \quad S = 1 / (1 + L), \quad T = 1 - S

    Args:
        response: L at each frequency, shape (F,).
        omega: Frequencies, shape (F,) [rad/s].
    """
    return _disk(np.abs(0.5 * (1.0 - response) / (1.0 + response)), omega)


def multiloop_disk_margin(closed: np.ndarray, omega: np.ndarray) -> DiskMargin:
    r"""Return a disk margin that holds for independent errors of all channels at once.

    The exact one needs the structured singular value of (S - T) / 2. Two bounds of it are cheap, and the smaller one
    counts at each frequency: the largest singular value, and the spectral radius of the matrix of magnitudes, which
    is the largest singular value under the best scaling of channels for magnitudes alone. So the margin is a
    guarantee at the measured frequencies, and may be larger.
    Source: Safonov, Stability margins of diagonally perturbed multivariable feedback systems, IEE Proc. D 129 (1982).

    Args:
        closed: T, shape (F, n, n).
        omega: Frequencies, shape (F,) [rad/s].
    """
    difference = 0.5 * np.eye(closed.shape[1]) - closed
    singular = np.linalg.svd(difference, compute_uv=False)[:, 0]
    perron = np.abs(np.linalg.eigvals(np.abs(difference))).max(axis=1)
    return _disk(np.minimum(singular, perron), omega)


def linear_disk_margin(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, *, omega: np.ndarray, period: float = 0.0
) -> DiskMargin:
    """Return the disk margin of a linear loop with one channel, by python-control.

    Args:
        a: State matrix of the loop L, shape (m, m).
        b: Input matrix, shape (m, 1).
        c: Output matrix, shape (1, m).
        d: Feedthrough, shape (1, 1).
        omega: Frequencies to look at, shape (F,) [rad/s].
        period: Sampling period, 0 for a continuous loop [s].
    """
    import control

    loop = control.ss(a, b, c, d, period or 0)
    alphas, _, _ = control.disk_margins(loop, np.asarray(omega, dtype=float), returnall=True)
    return _disk(1.0 / np.asarray(alphas), omega)


def _disk(sizes: np.ndarray, omega: np.ndarray) -> DiskMargin:
    """Return the disk margin of the largest |S - T| / 2."""
    worst = int(np.argmax(sizes))
    alpha = 1.0 / float(sizes[worst])
    return DiskMargin(
        alpha=alpha,
        gain=(2.0 + alpha) / (2.0 - alpha) if alpha < 2.0 else math.inf,
        phase=math.degrees(2.0 * math.atan(alpha / 2.0)),
        omega=float(omega[worst]),
    )
