"""The excitation of a loop: nothing but its lines, and within what the drives can do."""

import numpy as np
import pytest
from torquebench.scenarios.multisine import SHARE, log_lines, multisine


def test_the_lines_lie_on_the_grid_and_span_the_band():
    """About 45 of them from 2 to 400 Hz, whole cycles of a period of 4 s."""
    lines = log_lines(4000, 1e-3)
    assert lines[0] / 4.0 == 2.0
    assert lines[-1] / 4.0 == 400.0
    assert 40 <= len(lines) <= 45
    assert np.all(np.diff(lines) > 0)


def test_every_line_has_amplitude_one_and_nothing_leaks(rng):
    """All energy is in the lines."""
    lines = log_lines(4000, 1e-3)
    spectrum = np.abs(np.fft.rfft(multisine(lines, 4000, rng))) / 2000.0
    assert spectrum[lines] == pytest.approx(1.0)
    assert np.delete(spectrum, lines).max() < 1e-12


def test_the_drives_can_follow_it(rizon, rng):
    """A rate that the limiter cuts is another signal than the one that is divided by."""
    lines = log_lines(4000, 1e-3)
    rate = np.array(rizon.tiers["actuated"]["torque_rate_limit"]) * 1e-3
    for _ in range(20):
        wave = multisine(lines, 4000, rng)
        steps = np.abs(np.diff(np.append(wave, wave[0]))).max()
        assert np.all(SHARE * rizon.effort * steps < rate)
