"""Laws of windows, and of evaluating a whole log."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.evaluation import METRICS, UnequalLengths, UnknownMetric, UnknownWindow, evaluate, metric
from torquebench.evaluation.metrics import window_rows
from torquebench.evaluation.metrics.laps import lap_bounds

LOG_METRICS = [m.id for m in METRICS.values() if m.kind == "log"]

DT = 1e-3


def clock(start, stop):
    """Return the ticks from start to stop, as a simulator counts them."""
    return np.arange(round(start / DT), round(stop / DT)) * DT


def test_the_run_begins_at_the_end_of_the_lead_in():
    """Negative time is the way from rest; its errors are no one's merit."""
    rows = window_rows(clock(-1.0, 12.0), "run", DT, 4.0)
    assert (rows.start, rows.stop) == (1000, 13000)


def test_the_steady_window_begins_with_the_second_lap():
    """The first lap contains the start-up of whatever learns."""
    rows = window_rows(clock(-1.0, 12.0), "steady", DT, 4.0)
    assert (rows.start, rows.stop) == (5000, 13000)


def test_a_lap_that_is_not_finished_belongs_to_no_window():
    """Half a lap weighs one half of the path twice."""
    assert window_rows(clock(0.0, 11.9), "run", DT, 4.0).stop == 8000


def test_rounding_of_the_clock_loses_no_tick():
    """A clock that sums 1 ms puts tick 0 a rounding error before or after 0."""
    for shift in (-1e-12, 1e-12, -0.4e-3):
        rows = window_rows(clock(-1.0, 8.0) + shift, "run", DT, 4.0)
        assert (rows.start, rows.stop) == (1000, 9000)


def test_a_motion_that_is_no_cycle_is_one_run():
    """Without laps everything from 0 counts, and nothing is steady."""
    t = clock(-0.5, 2.3)
    for lap in (None, float("inf")):
        rows = window_rows(t, "run", DT, lap)
        assert (rows.start, rows.stop) == (500, 2800)
        steady = window_rows(t, "steady", DT, lap)
        assert steady.start == steady.stop


def test_an_unknown_window_is_named():
    """With the windows that there are."""
    with pytest.raises(UnknownWindow, match="run, steady"):
        window_rows(clock(0.0, 1.0), "event", DT, 1.0)


def test_laps_need_not_be_whole_ticks():
    """Bounds are rounded one by one, so that the error does not sum up."""
    bounds = lap_bounds(10_000, 1.0 / 3.0, DT)
    assert bounds[:4].tolist() == [0, 333, 667, 1000]
    assert bounds[-1] == 10_000
    assert len(bounds) == 31


def test_every_metric_of_a_full_log_has_a_value_in_both_windows(arm):
    """A log of the contract's fields lacks nothing."""
    result = evaluate(arm())
    assert list(result) == ["run", "steady"]
    for window, ticks in (("run", 3000), ("steady", 2000)):
        assert list(result[window]) == LOG_METRICS
        assert {value.n for value in result[window].values()} == {ticks}
        without = {name for name, value in result[window].items() if value.status != "ok"}
        assert without == {"iso_corner_overshoot"}, "a circle has no corner"


def test_a_log_of_one_lap_has_no_steady_window(arm):
    """Left out, rather than filled with NaN."""
    assert list(evaluate(arm(laps=1))) == ["run"]


def test_a_log_that_ended_in_the_lead_in_has_no_window(arm):
    """The run failed; there is nothing to say about its laps."""
    log = arm()
    early = SimpleNamespace(**{k: v[:500] if np.ndim(v) and len(v) > 100 else v for k, v in vars(log).items()})
    assert evaluate(early) == {}


def test_what_a_log_does_not_have_is_left_out(arm):
    """A CSV of tool positions gives the metrics of tool positions."""
    log = arm()
    bare = SimpleNamespace(t=log.t, dt=log.dt, p=log.p, p_ref=log.p_ref)
    ids = set(evaluate(bare)["run"])
    assert {"tcp_position_error_mean", "time_lag"} <= ids
    assert "contour_error_mean" not in ids
    assert "joint_error_mean" not in ids


def test_a_tier_without_rate_limits_has_no_rate_clipping(arm):
    """None means that there is none; 0 would mean that it was never reached."""
    log = arm()
    log.torque_rate = None
    result = evaluate(log)["run"]
    assert "torque_rate_clip_fraction" not in result
    assert len(result) == len(LOG_METRICS) - 1


def test_only_what_was_asked_for_is_computed(arm):
    """In the order asked for."""
    ids = ["time_lag", "joint_error_mean"]
    assert list(evaluate(arm(), ids=ids, windows=("steady",))["steady"]) == ids


def test_an_unknown_metric_is_named_with_its_nearest(arm):
    """One typing error, one line."""
    with pytest.raises(UnknownMetric, match="did you mean 'time_lag'"):
        evaluate(arm(), ids=["time_lagg"])


def test_a_metric_of_ones_own_is_evaluated_like_the_others(arm):
    """A plug-in passes its table; nothing else changes."""

    @metric(unit="rad", better="lower", family="own", needs=("q",), source="here", label="own")
    def excursion(q: np.ndarray) -> float:
        """Largest angle."""
        return float(np.abs(q).max())

    result = evaluate(arm(), windows=("run",), metrics={**METRICS, "excursion": excursion})
    assert result["run"]["excursion"].value == pytest.approx(0.4, abs=0.01)


def test_a_diverged_tick_fails_the_windows_that_hold_it_and_no_others(arm):
    """A NaN in the first lap spoils the run, not the steady window."""
    log = arm()
    log.p = log.p.copy()
    log.p[1500] = np.nan
    result = evaluate(log)
    assert result["run"]["tcp_position_error_mean"].status == "failed"
    assert result["run"]["joint_error_mean"].status == "ok"
    assert result["steady"]["tcp_position_error_mean"].status == "ok"


def test_the_lead_in_never_matters(arm):
    """Whatever happened before 0 leaves every value as it is."""
    log = arm()
    before = evaluate(log)
    log.q = log.q.copy()
    log.q[:1000] = np.nan
    assert evaluate(log) == before


def test_a_field_that_lost_a_tick_is_an_error(arm):
    """Slicing would hide it at the start and pair everything wrongly at the end."""
    log = arm()
    log.q = log.q[:-1]
    with pytest.raises(UnequalLengths):
        evaluate(log)


def test_importing_the_room_is_light():
    """SciPy is imported by the functions that need it: the command line's help must answer at once."""
    code = (
        "import sys, torquebench.evaluation; print([m for m in sys.modules if m.split('.')[0] in ('scipy', 'numba')])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_a_tick_has_one_contour_distance_whatever_window_it_is_averaged_in(arm):
    """The path a tool is near to does not end where an average begins."""
    log = arm()
    values = evaluate(log, ids=["contour_error_max", "contour_error_mean"])
    alone = evaluate(log, ids=["contour_error_max", "contour_error_mean"], windows=["steady"])
    assert alone["steady"] == values["steady"]
