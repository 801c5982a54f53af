"""Sixteen bits a sample: nearly nothing may be lost, peaks least of all."""

import base64

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from torquebench.evaluation.report.series import MOST, NOTHING, STEPS, quantised, thinned

SAMPLES = arrays(float, st.integers(1, 60), elements=st.floats(-1e6, 1e6, width=32))


def back(series):
    """Return samples as the page's script reads them."""
    whole = np.frombuffer(base64.b64decode(series["data"]), "<u2")
    return np.where(whole == NOTHING, np.nan, series["low"] + series["step"] * whole)


@given(SAMPLES)
def test_a_sample_comes_back_within_a_step(values):
    """A step is the range over 65534; the limits are rounded, which may cost as much again."""
    found = back(quantised(values))
    step = np.ptp(values) / STEPS + 1e-6 * np.abs(values).max()
    assert np.abs(found - values).max() <= step + 1e-12


def test_what_is_not_finite_stays_so_and_moves_nothing_else():
    """A run that diverged ends in NaN; its curve ends there and keeps its scale."""
    found = back(quantised(np.array([0.0, np.nan, 2.0, np.inf])))
    assert np.isnan(found[[1, 3]]).all()
    assert found[[0, 2]] == pytest.approx([0.0, 2.0], abs=1e-4)


def test_a_series_of_nothing_is_a_series():
    """All samples lost, or one and the same."""
    assert np.isnan(back(quantised(np.full(3, np.nan)))).all()
    assert back(quantised(np.full(3, 7.25))) == pytest.approx(7.25)


@given(st.integers(MOST + 1, 6 * MOST), st.integers(0, 2**32 - 1))
def test_thinning_keeps_every_peak_near_its_place(length, seed):
    """Plain striding loses the very sample that somebody looks for."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=length)
    values[peak := int(rng.integers(length))] = 100.0
    kept, part = thinned(values)
    assert len(kept) <= MOST
    assert (kept.max(), kept.min()) == (values.max(), values.min())
    assert int(kept.argmax()) // 2 == peak // part


def test_a_short_series_stays_as_it_is():
    """Two samples stand for two."""
    values = np.arange(MOST, dtype=float)
    kept, part = thinned(values)
    assert kept is values
    assert part == 2
