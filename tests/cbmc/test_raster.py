"""Rasters: every spike once, at its window, step and neuron, up to the bound that was asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.cbmc.raster import FIELDS, Raster


def windows(seed, count=4, steps=10, neurons=6, rate=0.3):
    """Random spikes of a layer, window by window."""
    rng = np.random.default_rng(seed)
    return [(rng.random((steps, neurons)) < rate).astype(float) for _ in range(count)]


def played(spikes, capacity=10_000, layer="gc"):
    """Return a raster that heard some windows of one layer."""
    raster = Raster(capacity)
    for window in spikes:
        raster.note(layer, window)
    return raster


@given(st.integers(0, 2**32 - 1))
def test_a_raster_gives_every_spike_back(seed):
    """Drawn again from its rows, the raster is what the layer did."""
    spikes = windows(seed)
    rows = played(spikes).events()["spikes_gc"]
    again = np.zeros((len(spikes), *spikes[0].shape))
    again[rows[:, 0], rows[:, 1], rows[:, 2]] += 1.0
    assert np.array_equal(again, np.array(spikes))
    assert len(rows) == int(np.sum(spikes))


@given(st.integers(0, 2**32 - 1))
def test_rows_are_in_the_order_of_time(seed):
    """Window, then step, then neuron: a plot or a count of intervals needs no sorting."""
    rows = played(windows(seed)).events()["spikes_gc"]
    assert [tuple(row) for row in rows] == sorted(tuple(row) for row in rows)


@pytest.mark.parametrize("capacity", [1, 7, 40])
def test_what_fits_is_the_beginning_and_not_a_choice(capacity):
    """A bounded raster is a shorter raster: the same first rows, nothing skipped in between."""
    spikes = windows(3)
    whole = played(spikes).events()["spikes_gc"]
    cut = played(spikes, capacity).events()["spikes_gc"]
    assert np.array_equal(cut, whole[:capacity])


def test_a_window_without_a_spike_is_counted_all_the_same():
    """Otherwise silence would shorten time."""
    raster = Raster(10)
    for window in (np.zeros((5, 2)), np.zeros((5, 2)), np.eye(5, 2)):
        raster.note("gc", window)
    assert raster.events()["spikes_gc"].tolist() == [[2, 0, 0], [2, 1, 1]]


def test_layers_have_their_own_windows_and_their_own_room():
    """The cerebellum answers every 50 ms, the thalamus every 10: their windows are not each other's."""
    raster = Raster(3)
    raster.note("purkinje", np.ones((2, 1)))
    for _ in range(5):
        raster.note("thalamus", np.ones((1, 1)))
    events = raster.events()
    assert set(events) == {"spikes_purkinje", "spikes_thalamus"}
    assert events["spikes_purkinje"].tolist() == [[0, 0, 0], [0, 1, 0]]
    assert events["spikes_thalamus"][:, 0].tolist() == [0, 1, 2]


def test_a_silent_layer_is_an_empty_list_and_an_unheard_one_is_absent():
    """No spikes is an answer; no listener is none."""
    events = played([np.zeros((5, 2))], layer="gc").events()
    assert events["spikes_gc"].shape == (0, len(FIELDS))
    assert Raster(10).events() == {}


def test_a_raster_without_room_hears_nothing_and_breaks_nothing():
    """The setting 0 means none."""
    assert played(windows(1), capacity=0).events()["spikes_gc"].shape == (0, 3)


def test_rows_are_small_whole_numbers():
    """A hundred thousand spikes are a megabyte, not three."""
    rows = played(windows(2)).events()["spikes_gc"]
    assert rows.dtype == np.int32
