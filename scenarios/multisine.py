"""A multisine: many sines at once, each on a line of the Fourier transform of one period, so that nothing leaks."""

import numpy as np

LOWEST, HIGHEST, LINES = 2.0, 400.0, 45
"""Frequency range [Hz] and wanted number of lines."""

SHARE = 0.005
"""Amplitude of each line as a share of a joint's torque limit: with random phases the peak is near 8 % of the limit,
and the torque's rate stays below what the drives allow."""


def log_lines(samples: int, period: float) -> np.ndarray:
    """Return the lines of a multisine, nearly evenly spaced in the logarithm, shape (F,).

    Args:
        samples: Samples of one period.
        period: Time between samples [s].
    """
    spacing = 1.0 / (samples * period)
    highest = min(HIGHEST, 0.4 / period)
    wanted = np.geomspace(LOWEST, highest, LINES) / spacing
    return np.unique(np.maximum(1, np.round(wanted))).astype(int)


def multisine(lines: np.ndarray, samples: int, generator: np.random.Generator) -> np.ndarray:
    """Return one period of sines of amplitude 1 with random phases, shape (samples,).

    Args:
        lines: Cycles of each sine within the period, shape (F,).
        samples: Samples of the period.
        generator: Draws the phases.
    """
    phases = generator.uniform(0.0, 2.0 * np.pi, len(lines))
    # A cosine of amplitude 1 is half its phasor on each side of the two-sided spectrum.
    spectrum = np.zeros(samples // 2 + 1, complex)
    spectrum[lines] = 0.5 * samples * np.exp(1j * phases)
    return np.asarray(np.fft.irfft(spectrum, n=samples))
