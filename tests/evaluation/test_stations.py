"""Stations of a command path and where laps cross their planes, against a search written another way."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import interp1d
from scipy.optimize import brentq
from scipy.stats import gmean
from torquebench.evaluation.metrics import iso_path_accuracy, iso_path_repeatability, jerk_ratio, material_ratio
from torquebench.evaluation.metrics.stations import STATIONS, at_rows, crossed_by_all, station_crossings

DT, TICKS = 0.01, 200
LAP = DT * TICKS


def flown(seed, laps=3, delay=0.04):
    """A smooth closed path and a tool that is late, too small, and a little elsewhere in each lap."""
    rng = np.random.default_rng(seed)
    first, second = rng.normal(size=(2, 3)) * 0.1
    third, fourth = rng.normal(size=(2, 3)) * 0.02

    def at(t):
        angle = 2.0 * np.pi * t[:, None] / LAP
        round_ = first * np.cos(angle) + second * np.sin(angle)
        return round_ + third * np.cos(2.0 * angle) + fourth * np.sin(2.0 * angle)

    t = np.arange(laps * TICKS) * DT
    wander = 1e-3 * np.sin(2.0 * np.pi * 0.37 * t[:, None] / LAP + np.arange(3))
    return 0.99 * at(t - delay) + wander, at(t)


def searched(p, p_ref):
    """Crossings by root finding on the interpolated tool path: points, shape (stations, laps, 3)."""
    path = p_ref[:TICKS]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    along = (np.arange(STATIONS) + 0.5) / STATIONS * length[-1]
    tool, plan = interp1d(np.arange(len(p)), p, axis=0), interp1d(length, path, axis=0)
    found = np.full((STATIONS, len(p) // TICKS, 3), np.nan)
    for station, where in enumerate(along):
        edge = np.searchsorted(length, where)
        normal, point = path[edge] - path[edge - 1], plan(where)
        row = edge - 1 + (where - length[edge - 1]) / (length[edge] - length[edge - 1])

        def height(r, point=point, normal=normal):
            return float((tool(r) - point) @ normal)

        for lap in range(found.shape[1]):
            planned = row + lap * TICKS
            grid = np.arange(max(int(planned) - 10, 0), min(int(planned) + 12, len(p)))
            heights = [height(r) for r in grid]
            ups = [r for r, a, b in zip(grid, heights, heights[1:], strict=False) if a <= 0.0 < b]
            if ups:
                rows = [brentq(height, r, r + 1) for r in ups]
                found[station, lap] = tool(min(rows, key=lambda r: abs(r - planned))) - point
    return found


@pytest.mark.parametrize("seed", range(3))
def test_crossings_and_criteria_are_those_of_another_search(seed):
    """Root finding, station by station: the same points, and from them the criteria by NaN-aware means."""
    p, p_ref = flown(seed)
    theirs = searched(p, p_ref)
    ours = station_crossings(p, p_ref, DT, LAP)
    assert ours.offset == pytest.approx(theirs, abs=1e-9, nan_ok=True)
    mean = np.nanmean(theirs, axis=1)
    assert iso_path_accuracy(p, p_ref, DT, LAP) == pytest.approx(np.linalg.norm(mean, axis=1).max(), abs=1e-9)
    several = theirs[np.isfinite(theirs[..., 0]).sum(axis=1) >= 2]
    radius = np.linalg.norm(several - np.nanmean(several, axis=1, keepdims=True), axis=2)
    expected = (np.nanmean(radius, axis=1) + 3.0 * np.nanstd(radius, axis=1, ddof=1)).max()
    assert iso_path_repeatability(p, p_ref, DT, LAP) == pytest.approx(expected, abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-0.1, 0.1))
def test_every_crossing_lies_in_its_plane(seed, delay):
    """Offsets are at right angles to the path, however late the tool is."""
    p, p_ref = flown(seed, delay=delay)
    found = station_crossings(p, p_ref, DT, LAP)
    edge = found.row.astype(int)
    normal = p_ref[edge + 1] - p_ref[edge]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = np.einsum("sld,sd->sl", found.offset, normal)
    assert np.nanmax(np.abs(along)) < 1e-9


def test_a_lap_that_is_an_eighth_late_is_found_by_the_long_search():
    """Beyond the short search nothing may be lost; a tool on its path has no offset but the chords'."""
    angle = 2.0 * np.pi * np.arange(3 * TICKS) / TICKS
    plan = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    found = station_crossings(np.roll(plan, TICKS // 8, axis=0), plan, DT, LAP)
    assert np.isfinite(found.when[:, 0]).all()
    assert np.nanmax(np.abs(found.offset)) < 1e-9
    late = found.when[:, 0] - found.row
    assert late == pytest.approx(np.full(STATIONS, TICKS / 8), abs=1e-6)


def test_rows_with_fractions_are_numpys_interpolation():
    samples = np.random.default_rng(0).normal(size=(30, 2))
    rows = np.linspace(0.0, 29.0, 77)
    expected = np.column_stack([np.interp(rows, np.arange(30), column) for column in samples.T])
    assert at_rows(samples, rows) == pytest.approx(expected)


@pytest.mark.parametrize(("lost", "kept"), [(0, 50), (5, 45), (6, None)])
def test_a_tenth_of_the_stations_may_be_missed_and_no_more(lost, kept):
    """What is judged must be the path, not the part that went well."""
    samples = np.zeros((50, 2, 3))
    samples[:lost, 0] = np.nan
    found = crossed_by_all(samples)
    assert (None if found is None else len(found)) == kept


def test_the_jerk_is_that_of_repeated_differences():
    """Another derivative, of a path slow enough for both."""
    t = np.arange(4000) * 1e-3
    plan = np.stack([np.cos(2.0 * t), np.sin(2.0 * t), 0.0 * t], axis=1)
    tool = plan + 0.3 * np.stack([0.0 * t, 0.0 * t, np.sin(4.0 * t)], axis=1)
    jerk = [np.diff(path, 3, axis=0) / 1e-9 for path in (tool, plan)]
    expected = np.sqrt((jerk[0] ** 2).sum() / (jerk[1] ** 2).sum())
    assert jerk_ratio(tool, plan, 1e-3) == pytest.approx(expected, rel=2e-3)


def test_the_ratio_of_materials_is_scipys_geometric_mean():
    water, sand = np.random.default_rng(1).uniform(0.01, 0.03, (2, 4, 8))
    assert material_ratio(water, sand) == pytest.approx(gmean((water / sand).ravel()))
