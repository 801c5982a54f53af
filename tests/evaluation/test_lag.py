"""Laws of lag, track and contour errors: the closed forms of a circle that is flown late or too small."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from torquebench.evaluation.metrics import (
    METRICS,
    Censored,
    along_track_error_mean,
    along_track_error_rms,
    along_track_series,
    contour_distances,
    contour_error_max,
    contour_error_mean,
    contour_error_p95,
    cross_track_error_mean,
    cross_track_error_rms,
    cross_track_series,
    joint_time_lag,
    joint_time_lags,
    lag_free_error,
    lag_share,
    tcp_position_error_mean,
    time_lag,
)

RADIUS, TURN = 0.14, 2.0 * np.pi / 4.0 * 0.030
"""Of the oracle circle, and the angle it turns in 30 ms."""


def brute_force(p, p_ref, reach, closed):
    """Return the distance to the segments within reach of each tick, one by one."""
    ticks, result = len(p), []
    for k in range(ticks):
        pairs = [(j % ticks, (j + 1) % ticks) for j in range(k - reach, k + reach)]
        inner = [(j, j + 1) for j in range(max(k - reach, 0), min(k + reach, ticks - 1))]
        best = np.linalg.norm(p[k] - p_ref[k])
        for a, b in pairs if closed else inner:
            chord = p_ref[b] - p_ref[a]
            square = chord @ chord
            along = np.clip((p[k] - p_ref[a]) @ chord / square, 0.0, 1.0) if square > 0.0 else 0.0
            best = min(best, np.linalg.norm(p[k] - p_ref[a] - along * chord))
        result.append(best)
    return np.array(result)


@pytest.mark.parametrize("delay", [0.010, 0.030])
def test_a_pure_delay_on_a_circle_is_all_lag_and_no_contour_error(circle, delay):
    """Lag must not be reported as inaccuracy of shape: the paper's 18 mm are 56 ms."""
    log = circle.followed_with(delay=delay)
    assert time_lag(log.p, log.p_ref, log.dt) == pytest.approx(delay, abs=1e-6)
    assert contour_error_mean(log.p, log.p_ref, log.dt, log.lap) < 1e-9


def test_a_fraction_of_a_tick_is_resolved(circle):
    """A delay line or a filter is no whole number of ticks."""
    log = circle.followed_with(delay=0.0304)
    assert time_lag(log.p, log.p_ref, log.dt) == pytest.approx(0.0304, abs=1e-6)
    assert lag_free_error(log.p, log.p_ref, log.dt) < 1e-6


def test_an_early_tool_has_a_negative_lag(circle):
    """Over-compensated feed-forward leads; the sign must say so."""
    log = circle.followed_with(delay=-0.012)
    assert time_lag(log.p, log.p_ref, log.dt) == pytest.approx(-0.012, abs=1e-6)


def test_the_error_of_a_late_tool_is_the_chord(circle):
    """The oracle's 6.596734 mm."""
    log = circle.followed_with(delay=0.030)
    assert tcp_position_error_mean(log.p, log.p_ref) == pytest.approx(6.596734e-3, abs=1e-9)
    assert tcp_position_error_mean(log.p, log.p_ref) == pytest.approx(2.0 * RADIUS * math.sin(TURN / 2.0), abs=1e-12)


def test_a_late_tool_is_behind_along_the_track(circle):
    """-rho sin(omega tau): the sign is the direction of travel."""
    log = circle.followed_with(delay=0.030)
    along = along_track_error_mean(log.p, log.p_ref, log.twist_ref)
    assert along == pytest.approx(-6.594903e-3, abs=1e-9)
    assert along == pytest.approx(-RADIUS * math.sin(TURN), abs=1e-12)
    assert along_track_error_rms(log.p, log.p_ref, log.twist_ref) == pytest.approx(-along, abs=1e-12)


def test_cross_track_is_not_contour(circle):
    """On a curve a pure lag leaves rho (1 - cos omega tau) across the track although the path is kept."""
    log = circle.followed_with(delay=0.030)
    cross = cross_track_error_mean(log.p, log.p_ref, log.twist_ref)
    assert cross == pytest.approx(0.155418e-3, abs=1e-9)
    assert cross_track_error_rms(log.p, log.p_ref, log.twist_ref) == pytest.approx(cross, abs=1e-9)
    assert contour_error_max(log.p, log.p_ref, log.dt, log.lap) < 1e-9


def test_a_small_and_late_circle_splits_into_lag_and_shape(circle):
    """7.105390 mm in all; 2.8 mm of it is the smaller circle, whatever the delay."""
    log = circle.followed_with(delay=0.030, scale=0.98)
    assert tcp_position_error_mean(log.p, log.p_ref) == pytest.approx(7.105390e-3, abs=1e-9)
    assert time_lag(log.p, log.p_ref, log.dt) == pytest.approx(0.030, abs=1e-6)
    assert lag_free_error(log.p, log.p_ref, log.dt) == pytest.approx(2.8e-3, abs=1e-8)
    for contour in (contour_error_mean, contour_error_p95, contour_error_max):
        # The polyline runs inside the circle by its sagitta, 43 nm at this speed.
        assert contour(log.p, log.p_ref, log.dt, log.lap) == pytest.approx(2.8e-3, abs=1e-7)


def test_the_share_of_lag_is_what_the_shift_explains(circle):
    """1 - (2.8 / 7.105390)^2."""
    log = circle.followed_with(delay=0.030, scale=0.98)
    expected = 1.0 - (2.8 / 7.105390) ** 2
    assert lag_share(log.p, log.p_ref, log.dt) == pytest.approx(expected, abs=1e-6)


def test_no_error_has_no_share(circle):
    """Zero over zero is not zero."""
    log = circle.followed_with()
    assert math.isnan(lag_share(log.p, log.p_ref, log.dt))


def test_a_lag_beyond_the_longest_shift_is_a_bound(circle):
    """A tool 300 ms late must not be printed as 200 ms late without a word."""
    log = circle.followed_with(delay=0.3)
    lag = time_lag(log.p, log.p_ref, log.dt)
    assert isinstance(lag, Censored)
    assert lag == pytest.approx(0.2)
    assert isinstance(lag_free_error(log.p, log.p_ref, log.dt), Censored)
    assert isinstance(lag_share(log.p, log.p_ref, log.dt), Censored)
    assert METRICS["time_lag"].value_of(vars(log)).status == "censored"


def test_a_reference_that_rests_has_no_lag(circle):
    """Any shift fits a standing reference; 0 would be an invention."""
    rest = np.full((2000, 3), 0.3)
    late = rest + 1e-3 * np.random.default_rng(0).normal(size=rest.shape)
    for metric in (time_lag, lag_free_error, lag_share):
        assert math.isnan(metric(late, rest, 1e-3))
    assert METRICS["time_lag"].value_of({"p": late, "p_ref": rest, "dt": 1e-3}).status == "undefined"


def test_a_window_of_a_few_ticks_has_no_lag(circle):
    """An eighth of the window must hold a shift and its neighbours."""
    log = circle.followed_with(delay=0.03)
    assert math.isnan(time_lag(log.p[:15], log.p_ref[:15], log.dt))


def test_the_shift_window_shrinks_with_the_window(circle):
    """Half a second of log cannot show 200 ms of lag with ticks to spare: the bound is an eighth of it."""
    log = circle.followed_with(delay=0.1)
    assert time_lag(log.p[:480], log.p_ref[:480], log.dt) == pytest.approx(0.060)


def test_the_joints_are_late_together_and_each_by_itself():
    """A soft wrist behind a stiff shoulder shows in the vector, not in the pooled number."""
    t = np.arange(4000) * 1e-3
    q_ref = np.stack([np.sin(2 * t), np.sin(2 * t + 1.0), np.zeros_like(t)], axis=1)
    q = np.stack([np.sin(2 * (t - 0.01)), np.sin(2 * (t - 0.03) + 1.0), np.zeros_like(t)], axis=1)
    lags = joint_time_lags(q, q_ref, 1e-3)
    assert lags[:2] == pytest.approx([0.01, 0.03], abs=1e-4)
    assert math.isnan(lags[2])
    assert 0.01 < joint_time_lag(q, q_ref, 1e-3) < 0.03


def test_a_wrong_amplitude_does_not_bias_the_lag(circle):
    """Least squares has no amplitude bias: a tool 10 % too large is not early or late."""
    log = circle.followed_with(delay=0.02, scale=1.1)
    assert time_lag(log.p, log.p_ref, log.dt) == pytest.approx(0.02, abs=1e-6)


def test_a_tool_on_the_other_branch_of_an_eight_is_not_on_the_path(eight):
    """Half a lap late at the crossing is 0 mm from the polyline and still wrong: the window must not jump."""
    reference = eight.followed_with().p_ref
    late = np.roll(reference, len(reference) // 2, axis=0)
    distances = contour_distances(late, reference, eight.dt, eight.period)
    quarter = len(reference) // 4
    whole = contour_distances(late, reference, eight.dt, math.inf)
    assert whole.max() < 1e-9
    assert distances[quarter] > 0.05


def test_a_late_tool_at_the_start_of_a_closed_path_is_on_the_path(circle):
    """The path is closed: just before phase 0 lies the end of the lap."""
    log = circle.followed_with(delay=0.030)
    assert contour_distances(log.p, log.p_ref, log.dt, log.lap)[0] < 1e-9


def test_an_open_reference_is_not_closed():
    """A straight move and back to nowhere: its end must not lend a segment to its start."""
    p_ref = np.stack([np.linspace(0.0, 1.0, 101), np.zeros(101), np.zeros(101)], axis=1)
    p = p_ref + np.array([0.0, 0.01, 0.0])
    p[0] = [-0.02, 0.0, 0.0]
    assert contour_distances(p, p_ref, 1e-3, math.inf)[0] == pytest.approx(0.02)
    assert contour_distances(p, p_ref, 1e-3, 0.101)[0] == pytest.approx(0.02)


def test_the_distance_is_to_segments_not_to_vertices():
    """Between two vertices 10 mm apart a tool on the line is on the path."""
    p_ref = np.stack([np.arange(5) * 0.01, np.zeros(5), np.zeros(5)], axis=1)
    p = p_ref + np.array([0.004, 0.0, 0.0])
    assert contour_distances(p[:4], p_ref[:4], 1.0, math.inf)[:3] == pytest.approx(0.0, abs=1e-15)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(4, 150), st.sampled_from([math.inf, 40.0, 100.0]))
def test_the_search_is_exact_on_an_open_path(seed, ticks, lap):
    """Branch and bound against trying every segment, on a random walk where no shortcut holds."""
    rng = np.random.default_rng(seed)
    p_ref = rng.normal(size=(ticks, 3)).cumsum(axis=0)
    p = p_ref + 3.0 * rng.normal(size=(ticks, 3))
    p_ref[-1] += 1000.0  # far from its start: certainly open
    reach = ticks if math.isinf(lap) else round(lap / 4)
    expected = brute_force(p, p_ref, min(reach, ticks), closed=False)
    assert contour_distances(p, p_ref, 1.0, lap) == pytest.approx(expected, abs=1e-9)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(16, 120), st.integers(1, 3))
def test_the_search_is_exact_on_a_closed_path(seed, ticks, laps):
    """The same where the window wraps around the end."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * np.arange(ticks * laps) / ticks
    waves = rng.normal(size=(2, 3, 3))
    p_ref = sum(
        np.sin((k + 1) * angle)[:, None] * waves[0, k] + np.cos((k + 1) * angle)[:, None] * waves[1, k]
        for k in range(3)
    )
    p = p_ref + 0.3 * rng.normal(size=p_ref.shape)
    expected = brute_force(p, p_ref, max(1, round(ticks / 4)), closed=True)
    assert contour_distances(p, p_ref, 1.0, float(ticks)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("place", [0.0, 0.1])
def test_a_resting_reference_is_a_point(place):
    """All segments are alike there; nothing may divide by their length."""
    p_ref = np.full((300, 3), 0.2)
    p = p_ref + np.array([place, 0.0, 0.0])
    assert contour_distances(p, p_ref, 1e-3, 0.3) == pytest.approx(place, abs=1e-12)


@given(st.floats(-0.1, 0.1), st.floats(0.8, 1.2))
@settings(max_examples=20, deadline=None)
def test_the_contour_error_never_exceeds_the_position_error(eight, delay, scale):
    """The reference of the same tick is itself on the path."""
    log = eight.followed_with(delay=delay, scale=scale)
    distance = np.linalg.norm(log.p - log.p_ref, axis=1)
    assert np.all(contour_distances(log.p, log.p_ref, log.dt, log.lap) <= distance + 1e-12)


@given(st.floats(-0.1, 0.1), st.floats(0.8, 1.2))
@settings(max_examples=20, deadline=None)
def test_along_and_across_make_up_the_whole(eight, delay, scale):
    """Pythagoras at every tick."""
    log = eight.followed_with(delay=delay, scale=scale)
    along = along_track_series(log.p, log.p_ref, log.twist_ref)
    across = cross_track_series(log.p, log.p_ref, log.twist_ref)
    assert along**2 + across**2 == pytest.approx(np.sum((log.p - log.p_ref) ** 2, axis=1), abs=1e-15)


def test_a_standing_reference_has_no_along(circle):
    """Without a direction of travel the whole error counts as across."""
    log = circle.followed_with(delay=0.03)
    still = np.zeros_like(log.twist_ref)
    assert along_track_error_mean(log.p, log.p_ref, still) == 0.0
    whole = tcp_position_error_mean(log.p, log.p_ref)
    assert cross_track_error_mean(log.p, log.p_ref, still) == pytest.approx(whole)


def test_an_error_straight_up_is_all_across(circle):
    """A sagging tool is neither early nor late."""
    log = circle.followed_with()
    sagging = log.p_ref - [0.0, 0.0, 0.005]
    assert along_track_error_rms(sagging, log.p_ref, log.twist_ref) == pytest.approx(0.0, abs=1e-12)
    assert contour_error_mean(sagging, log.p_ref, log.dt, log.lap) == pytest.approx(0.005, abs=1e-9)


def test_the_reference_against_itself_has_no_lag(eight):
    """Exactly zero, not the parabola's rounding."""
    log = eight.followed_with()
    assert time_lag(log.p_ref, log.p_ref, log.dt) == 0.0
    assert lag_free_error(log.p_ref, log.p_ref, log.dt) == 0.0
