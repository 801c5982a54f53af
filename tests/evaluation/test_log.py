"""A log of one's own: what it accepts, what it refuses and in which words, and how it is resampled."""

import re
from dataclasses import fields

import numpy as np
import pytest
from torquebench.evaluation import InvalidLog, Log, evaluate, missing_fields
from torquebench.evaluation.metrics import METRICS

T = np.arange(400) * 0.01


def circle(t, delay=0.0):
    angle = np.pi * (np.asarray(t) - delay)
    return 0.14 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)


def test_a_log_of_lists_is_evaluated_like_the_harnesss(arm):
    """The same arrays by another door give the same figures, every metric of them."""
    names = {field.name for field in fields(Log)}
    made = arm()
    log = Log(**{name: np.asarray(f).tolist() for name, f in vars(made).items() if name in names})
    assert log.dt == pytest.approx(1e-3)
    assert missing_fields(log) == {}
    ours, theirs = evaluate(log)["run"], evaluate(made)["run"]
    assert list(ours) == list(theirs)
    for name, value in theirs.items():
        assert ours[name].value == pytest.approx(value.value, rel=1e-6, nan_ok=True), name


def test_what_a_metric_lacks_is_named():
    """Left out is not forgotten: whoever logs the torque next time reads here what it brings."""
    log = Log(t=T, p=circle(T), p_ref=circle(T), lap=2.0)
    missing = missing_fields(log)
    assert missing["joint_error_mean"] == ("q", "q_ref")
    assert missing["energy_per_path"] == ("tau", "q", "mass")
    assert "contour_error_mean" not in missing
    assert set(missing) | set(evaluate(log)["run"]) == {m.id for m in METRICS.values() if m.kind == "log"}
    assert missing_fields(log, ["torque_ripple"]) == {"torque_ripple": ("tau",)}


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"t": [0.0]}, "log, t: shape (1,)"),
        ({"t": [0.0, 0.2, 0.2]}, "0.2 s in row 2 after 0.2 s"),
        ({"t": [0.0, np.nan, 0.2]}, "row 1"),
        ({"t": [-np.inf, 0.0, 0.2]}, "row 1 after -inf s"),
        ({"t": T, "p": np.zeros((399, 3))}, "log, p: shape (399, 3); valid is (400, 3)"),
        ({"t": T, "q": np.zeros((400, 6)), "tau": np.zeros((400, 7))}, "log, tau: shape (400, 7); valid is (400, 6)"),
        ({"t": T, "q": np.zeros((400, 6)), "effort": np.zeros(7)}, "log, effort: shape (7,); valid is (6,)"),
        ({"t": T, "q": [[1.0], [1.0, 2.0]]}, "log, q: "),
        ({"t": T, "quat": np.full((400, 4), 0.6)}, "log, quat: length 1.2 in row 0; valid are unit quaternions"),
        ({"t": T, "lap": 0.0}, "log, lap: 0.0"),
    ],
)
def test_what_is_no_log_is_refused_in_one_line(given, says):
    """Field, what came, what is valid."""
    with pytest.raises(InvalidLog, match=re.escape(says)) as caught:
        Log(**given)
    assert "\n" not in str(caught.value)


def test_uneven_steps_are_refused_when_the_period_is_asked_for():
    """They may be resampled first; a rate over them would be a number without a meaning."""
    log = Log(t=np.delete(T, 7), p=circle(np.delete(T, 7)))
    with pytest.raises(InvalidLog, match="resample"):
        evaluate(log)
    assert log.resampled(0.01).dt == pytest.approx(0.01)


def test_resampling_keeps_lines_and_arcs():
    """Straight in positions; an attitude turns evenly on the shorter arc, whatever its quaternion's sign."""
    angle = 0.3 * T
    quat = np.column_stack([0 * T, 0 * T, np.sin(angle / 2), np.cos(angle / 2)])
    quat *= np.where(np.arange(len(T)) % 2, 1.0, -1.0)[:, None]
    log = Log(t=T, q=np.outer(T, [1.0, -2.0]), quat=quat, effort=[3.0, 4.0]).resampled(0.0025)
    assert log.t[-1] == pytest.approx(T[-1])
    assert len(log.t) == 4 * 399 + 1
    assert log.q == pytest.approx(np.outer(log.t, [1.0, -2.0]), abs=1e-12)
    assert np.abs(2.0 * np.arctan(log.quat[:, 2] / log.quat[:, 3])) == pytest.approx(0.3 * log.t, abs=1e-9)
    assert log.effort.tolist() == [3.0, 4.0]


@pytest.mark.parametrize("lost", [slice(3, 4), slice(0, 1), slice(398, 400), slice(0, 398)])
def test_resampling_neither_fills_a_hole_nor_widens_it(lost):
    """A sample that is not finite fails its metrics at every period; what lies beside two good samples stays."""
    quat, q = np.tile([0.0, 0.0, 0.0, 1.0], (400, 1)), np.ones((400, 2))
    quat[lost, 2], q[lost, 1] = np.nan, np.nan
    log = Log(t=T, q=q, quat=quat).resampled(0.0025)
    before, after = (np.searchsorted(T, log.t + shift, side) for shift, side in ((1e-9, "right"), (-1e-9, "left")))
    good = np.isfinite(q).all(axis=1)
    expected = good[before - 1] & good[after.clip(max=399)]
    for field in (log.q, log.quat):
        assert np.array_equal(np.isfinite(field).all(axis=1), expected)


def test_a_slow_log_resampled_has_the_lag_of_the_motion():
    """50 Hz to 1 kHz: chords between samples, so the lag stays."""
    t = np.arange(600) * 0.02
    log = Log(t=t, p=circle(t, 0.03), p_ref=circle(t), lap=2.0).resampled(1e-3)
    assert evaluate(log, ["time_lag"])["run"]["time_lag"].value == pytest.approx(0.03, abs=1e-4)


@pytest.mark.parametrize(("lost", "refused"), [(4, False), (5, True)])
def test_gaps_beyond_five_samples_are_not_made_up(lost, refused):
    t = np.delete(T, slice(100, 100 + lost))
    log = Log(t=t, q=np.zeros((len(t), 1)))
    if refused:
        with pytest.raises(InvalidLog, match="in row 99"):
            log.resampled(0.01)
    else:
        assert len(log.resampled(0.01).t) == 400
    with pytest.raises(InvalidLog, match="period"):
        log.resampled(0.0)


def test_degrees_and_millimetres_are_doubted_and_radians_and_metres_are_not():
    """An error of 0.3 is good in one unit and a crash in the other."""
    assert Log(t=T, q=np.full((400, 2), 3.0), p=circle(T)).doubts() == []
    doubts = Log(t=T, q=np.full((400, 2), 90.0), p=1e3 * circle(T)).doubts()
    assert len(doubts) == 2
    assert "degrees" in doubts[0] and "millimetres" in doubts[1]


def test_a_sample_that_is_not_finite_fails_its_metrics_and_no_others():
    """A hole in the attitude says nothing about the position."""
    quat = np.tile([0.0, 0.0, 0.0, 1.0], (400, 1))
    holed = quat.copy()
    holed[3, 0] = np.nan
    found = evaluate(Log(t=T, p=circle(T), p_ref=circle(T), quat=holed, quat_ref=quat))["run"]
    assert found["tcp_orientation_error_mean"].status == "failed"
    assert found["tcp_position_error_mean"].status == "ok"
