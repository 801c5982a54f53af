"""Wall times and operation counts: percentiles that see the heavy ticks, and estimates that add up."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation import METRICS
from torquebench.evaluation.energy import energy_table, estimate
from torquebench.evaluation.metrics import (
    deadline_miss_fraction,
    evaluate,
    op_energy_estimate,
    solver_iterations_median,
    solver_iterations_p99,
    tick_time_every_10,
    tick_time_every_50,
    tick_time_max,
    tick_time_median,
    tick_time_p99,
    tick_time_p999,
    tick_times_by_stride,
)

TIMES = np.where(np.arange(1, 1001) % 50 == 0, 2.0e-3, 0.2e-3)
"""A controller whose slow level runs every fiftieth call: 980 times 0.2 ms, 20 times 2 ms."""


def test_a_slow_level_of_two_per_cent_shows_in_the_99th_percentile_and_in_the_misses():
    assert tick_time_median(TIMES) == pytest.approx(0.2e-3)
    assert tick_time_p99(TIMES) == pytest.approx(2.0e-3)
    assert tick_time_p999(TIMES) == tick_time_max(TIMES) == pytest.approx(2.0e-3)
    assert deadline_miss_fraction(TIMES, 1e-3) == pytest.approx(0.02)


def test_a_call_of_just_the_period_keeps_it():
    assert deadline_miss_fraction(np.full(10, 1e-3), 1e-3) == 0.0


def test_levels_are_told_apart_by_their_calls():
    """Calls count from 1; a call of all levels is not one of the middle level."""
    number = np.arange(1, 501)
    times = np.select([number % 50 == 0, number % 10 == 0], [3.0, 2.0], 1.0)
    assert tick_times_by_stride(times).tolist() == [1.0, 2.0, 3.0]
    assert (tick_time_every_10(times), tick_time_every_50(times)) == (2.0, 3.0)
    assert math.isnan(tick_time_every_10(times[:9]))


@given(st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=60))
def test_percentiles_are_ordered(times):
    """Median, 99 %, 99.9 %, largest."""
    row = [figure(np.array(times)) for figure in (tick_time_median, tick_time_p99, tick_time_p999, tick_time_max)]
    assert all(a <= b + 1e-12 for a, b in pairwise(row))


def test_wall_times_are_never_among_the_metrics_of_a_log(arm):
    """The table of results is the same on every machine, even where a log carries times."""
    log = arm()
    log.call_time = np.full(len(log.t), 1e-4)
    timings = {name for name, found in METRICS.items() if found.kind == "timing"}
    assert len(timings) == 7
    assert not timings & set(evaluate(log)["run"])
    assert not any("call_time" in found.needs for found in METRICS.values() if found.kind != "timing")


def test_the_estimate_is_the_sum_of_counts_by_energies():
    """974 operations of computed torque at 1 kHz, 516 of them multiplications: about 2.3 uW."""
    prices = np.array([3.7, 0.9])
    assert op_energy_estimate(np.array([1e6, 0.0]), prices) == pytest.approx(3.7)
    assert op_energy_estimate(np.array([0.0, 1e6]), prices) == pytest.approx(0.9)
    assert op_energy_estimate(np.array([0.53e6, 0.44e6]), prices) == pytest.approx(2.36, abs=0.01)


def test_the_metric_and_the_report_s_estimate_are_one_figure():
    """Two definitions of one name would drift apart."""
    prices = energy_table().operations
    counts = {name: float(place) for place, name in enumerate(prices, start=1)}
    metric = op_energy_estimate(
        np.array(list(counts.values())), np.array([price.picojoules for price in prices.values()])
    )
    assert estimate(counts, touched=0.0, kept=1.0).arithmetic == pytest.approx(metric, rel=1e-12)


def test_iterations_of_a_solver_have_a_median_and_a_tail():
    iterations = np.append(np.full(99, 3.0), 40.0)
    assert solver_iterations_median(iterations) == 3.0
    assert solver_iterations_p99(iterations) == pytest.approx(np.percentile(iterations, 99.0))
    assert solver_iterations_p99(iterations) > 3.0
