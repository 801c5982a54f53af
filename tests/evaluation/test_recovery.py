"""Recovery and excess after a load event: closed forms of what an error does, and what no formula may change."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.metrics import (
    EVENT_METRICS,
    METRICS,
    Censored,
    event_excess_per_kg,
    excess_integral,
    excess_peak,
    excess_peak_time,
    recovery_time_nominal,
    recovery_time_settled,
    recovery_time_settled_10,
    recovery_time_settled_50,
    residual_excess,
)
from torquebench.evaluation.metrics.curves import first_stay, last_cycles, moving_average, row_at
from torquebench.evaluation.metrics.recovery import recovery_threshold

DT, LAP, EVENT, UNTIL = 1e-3, 2.0, 2.0, 12.0
BEFORE = 0.02
"""Error before the event: a quarter of it is the oracle's threshold of 5 mrad."""


def after(shape, rows=12000):
    """An error of 20 mrad that the event adds a shape to, and the twin without it."""
    base = np.full(rows, BEFORE)
    error = base.copy()
    error[2000:] += shape(np.arange(rows - 2000) * DT)
    return error, base


def exponential(t):
    return 0.05 * np.exp(-t / 0.4)


def cosine(t):
    damped = 2.0 * np.pi * 2.0
    rate = 0.2 * damped / math.sqrt(1.0 - 0.2**2)
    return 0.05 * np.exp(-rate * t) * np.cos(damped * t)


def settled(error, base):
    return recovery_time_settled(error, base, base, EVENT, UNTIL, LAP, DT)


def test_an_exponential_recovers_when_its_logarithm_says_so():
    """0.4 s times ln 10 is 0.92103 s; the next tick of the grid is 0.922 s."""
    assert settled(*after(exponential)) == pytest.approx(0.922, abs=1e-9)
    assert 0.4 * math.log(10.0) == pytest.approx(0.92103, abs=1e-5)


def test_a_stricter_share_takes_longer_by_its_logarithm():
    error, base = after(exponential)
    strict = recovery_time_settled_10(error, base, base, EVENT, UNTIL, LAP, DT)
    loose = recovery_time_settled_50(error, base, base, EVENT, UNTIL, LAP, DT)
    assert strict == pytest.approx(0.4 * math.log(25.0), abs=DT)
    assert loose == pytest.approx(0.4 * math.log(5.0), abs=DT)


def test_an_error_that_stays_never_recovers_and_says_so():
    """Infinite and a bound, not a large number: nobody may average it."""
    value = settled(*after(lambda t: exponential(t) + 0.02))
    assert isinstance(value, Censored)
    assert value == math.inf


def test_a_moment_of_smallness_is_no_recovery():
    """A decaying cosine passes zero at 0.125 s; it stays small only from 0.804 s, before its envelope at 0.898 s."""
    error, base = after(cosine)
    excess = np.abs(error - base)[2000:]
    assert first_stay(excess <= 0.005, DT, dwell=DT) == pytest.approx(0.115, abs=1e-9)
    assert settled(error, base) == pytest.approx(0.804, abs=1e-9)


def test_recovery_that_cannot_be_seen_is_undefined():
    """Half a second of calm does not fit into less than half a second."""
    error, base = after(exponential)
    assert math.isnan(recovery_time_settled(error, base, base, EVENT, EVENT + 0.5, LAP, DT))
    assert not math.isnan(recovery_time_settled(error, base, base, EVENT, EVENT + 0.501, LAP, DT))
    assert math.isnan(recovery_time_settled(error, base, base, 1.5, UNTIL, LAP, DT))


def test_what_settled_may_not_be_what_was():
    """A controller that never compensates settles at once on its new error, and never returns to the old."""
    base = np.full(12000, BEFORE)
    error = base.copy()
    error[2000:] = 3.0 * BEFORE
    heavy = np.full(12000, 3.0 * BEFORE)
    assert recovery_time_settled(error, base, heavy, EVENT, UNTIL, LAP, DT) == 0.0
    assert recovery_time_nominal(error, base, EVENT, UNTIL, LAP, DT) == math.inf
    assert residual_excess(error, base, EVENT, UNTIL, LAP, DT) == pytest.approx(2.0 * BEFORE)


def test_the_threshold_is_the_median_of_the_last_lap_and_never_vanishes():
    error = np.concatenate([np.full(1000, 9.0), np.full(2000, 0.04), np.full(1000, 7.0)])
    assert recovery_threshold(error, 3.0, LAP, DT, 0.25) == pytest.approx(0.01)
    assert recovery_threshold(np.zeros(4000), 3.0, LAP, DT, 0.25) == 1e-4
    assert math.isnan(recovery_threshold(error, 1.9, LAP, DT, 0.25))


def test_the_integral_of_an_exponential():
    """0.05 times 0.4 s, as a sum of ticks 0.020025."""
    error, base = after(exponential)
    assert excess_integral(error, base, EVENT, UNTIL, DT) == pytest.approx(0.020025, abs=1e-6)
    assert event_excess_per_kg(error, base, EVENT, UNTIL, -2.0, DT) == pytest.approx(0.0100125, abs=1e-6)
    assert math.isnan(event_excess_per_kg(error, base, EVENT, UNTIL, 0.0, DT))


def test_the_peak_is_looked_for_in_two_and_a_half_seconds():
    error, base = after(lambda t: np.exp(-(((t - 0.3) / 0.1) ** 2)) + 5.0 * (t > 3.0))
    assert excess_peak(error, base, EVENT, UNTIL, DT) == pytest.approx(1.0)
    assert excess_peak_time(error, base, EVENT, UNTIL, DT) == pytest.approx(0.3)


def test_no_excess_has_no_time_of_its_peak():
    base = np.full(12000, BEFORE)
    assert math.isnan(excess_peak_time(base, base, EVENT, UNTIL, DT))


def test_a_lap_that_is_no_whole_number_of_ticks_still_has_its_rows():
    assert len(last_cycles(np.arange(5000.0), 4.0, 1.0005, DT)) in (1000, 1001)
    assert len(last_cycles(np.arange(500.0), 0.4, 1.0, DT)) == 0
    assert len(last_cycles(np.arange(500.0), 0.4, math.inf, DT)) == 0


def test_an_event_acts_from_its_own_tick():
    assert [row_at(time, DT, 100) for time in (0.0, 0.05, 0.05 + 1e-12, 0.05 - 1e-12, 9.0, math.inf)] == [
        0, 50, 50, 50, 100, 100,
    ]  # fmt: skip


def test_a_moving_average_leaves_a_line_alone_and_knows_its_ends():
    line = np.linspace(0.0, 1.0, 101)
    assert moving_average(line, 0.005, DT)[10:-10] == pytest.approx(line[10:-10])
    assert moving_average(np.ones(30), 0.02, DT) == pytest.approx(np.ones(30))


noise = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).uniform(0.001, 0.05, 12000))


@given(noise)
def test_a_run_against_itself_has_nothing_to_recover_from(error):
    """The twin of an event that changes nothing."""
    for name in ("recovery_time_settled", "recovery_time_nominal", "residual_excess", "excess_integral", "excess_peak"):
        fields = {"error": error, "error_old": error, "error_new": error}
        fields |= {"event": EVENT, "until": UNTIL, "lap": LAP, "dt": DT}
        assert METRICS[name].value_of(fields).value == 0.0


@given(noise, st.floats(0.1, 10.0))
def test_errors_twice_as_large_recover_as_fast_and_cost_twice_as_much(base, factor):
    error = base.copy()
    error[2000:] += exponential(np.arange(10000) * DT)
    assert settled(factor * error, factor * base) == pytest.approx(settled(error, base), abs=2 * DT)
    large = excess_integral(factor * error, factor * base, EVENT, UNTIL, DT)
    assert large == pytest.approx(factor * excess_integral(error, base, EVENT, UNTIL, DT), rel=1e-9)


@given(st.integers(1, 4000))
def test_a_later_event_recovers_as_fast(ticks):
    """Only the time since the event counts."""
    error, base = after(exponential)
    shifted, calm = (np.concatenate([np.full(ticks, BEFORE), curve]) for curve in (error, base))
    later = recovery_time_settled(shifted, calm, calm, EVENT + ticks * DT, UNTIL + ticks * DT, LAP, DT)
    assert later == settled(error, base)


@pytest.mark.parametrize("metric_id", EVENT_METRICS)
def test_one_sample_that_is_not_finite_fails_the_event(metric_id):
    found = METRICS[metric_id]
    error, base = after(exponential)
    error[2500] = np.nan
    curves = {name: error if name.endswith("error") else base for name in found.needs if "error" in name}
    if not any(name.endswith("error") for name in curves):
        curves = dict.fromkeys(curves, error)
    fields = {**curves, "event": EVENT, "until": UNTIL, "lap": LAP, "dt": DT, "mass_change": 2.0}
    assert found.value_of(fields).status == "failed"


def test_a_recovery_that_never_came_survives_json():
    error, base = after(lambda t: exponential(t) + 0.02)
    fields = {"error": error, "error_old": base, "error_new": base}
    fields |= {"event": EVENT, "until": UNTIL, "lap": LAP, "dt": DT}
    stored = json.loads(json.dumps(METRICS["recovery_time_settled"].value_of(fields).as_dict()))
    assert stored == {"value": math.inf, "unit": "s", "status": "censored", "n": 12000}
