"""Times of a tick: one machine's own, against the period they must fit into."""

import re
from dataclasses import replace

import pytest


@pytest.fixture
def timed(shelf):
    """Puts runs of one controller with given call times [us] on the shelf."""

    def put(controller, *calls):
        for repetition, (median, p99, longest, misses) in enumerate(calls):
            run = shelf.specification(controller, "none", repetition=repetition)
            timing = {"call_us_median": median, "call_us_p99": p99, "call_us_max": longest, "deadline_misses": misses}
            shelf.put(run, replace(shelf.result(run, 1e-3, "slow"), timing=timing))

    return put


def numbers_of(row):
    """Return the numbers of a row of a table: one that reads as it is has no value beside its text."""
    cells = re.findall(r'<td class="n[^"]*"(?: data-v="([^"]+)")?>([^<]*)<', row)
    return [float(value or text) for value, text in cells if value or text[:1].isdigit()]


def section_of(page):
    return page.html.partition('id="w1-timing"')[2].partition('id="w1-runs"')[0]


def test_a_call_beyond_the_period_is_marked_by_shape(shelf, timed):
    """Colour alone would not say it; one late call of ten thousand is a late call."""
    timed("flexiv_factory", (10.0, 20.0, 900.0, 0.0), (12.0, 30.0, 800.0, 0.0))
    timed("mpc", (400.0, 900.0, 1500.0, 3.0))
    text = section_of(shelf.campaign().report())
    drawn = text.partition('<svg class="chart"')[2].partition("</figure>")[0]
    first, second = drawn.split('<g class="line">')[1:]
    quick, late = (first, second) if "flexiv_factory" in first else (second, first)
    assert 'class="hollow"' in quick and "M0-6 6 5-6 5Z" not in quick
    assert "M0-6 6 5-6 5Z" in late and 'class="hollow"' not in late
    assert "against the period of 1000 \N{MICRO SIGN}s" in text


def test_the_table_takes_medians_over_runs_and_the_longest_of_all(shelf, timed):
    """A mean of maxima is the maximum of nothing."""
    timed("flexiv_factory", (10.0, 20.0, 100.0, 0.0), (12.0, 30.0, 800.0, 0.0), (14.0, 40.0, 200.0, 6.0))
    text = section_of(shelf.campaign().report())
    row = text.partition("<tbody>")[2].partition("</tr>")[0]
    assert numbers_of(row) == [12.0, 30.0, 800.0, 2.0]


def test_calls_of_slow_levels_stand_apart(shelf, timed):
    """Two calls of a hundred take fifty times as long: a median of all of them would call the controller quick."""
    timed("flexiv_factory", (10.0, 20.0, 100.0, 0.0))
    run = shelf.specification("cbmc_v3", "none")
    calls = {"call_us_median": 2.0, "call_us_p99": 50.0, "call_us_max": 160.0, "deadline_misses": 0.0}
    levels = {"tick_time_every_10": 9e-6, "tick_time_every_50": 49e-6}
    shelf.put(run, replace(shelf.result(run, 2e-3, "slow"), timing={**calls, **levels}))
    text = section_of(shelf.campaign().report())
    rows = [row for row in text.partition("<tbody>")[2].split("<tr>") if '<td class="n"' in row]
    numbers = [numbers_of(row) for row in rows]
    assert sorted(numbers) == [[2.0, 9.0, 49.0, 50.0, 160.0, 0.0], [10.0, 20.0, 100.0, 0.0]]


def test_the_machine_is_named_and_a_second_one_too(shelf, timed):
    """Times of two machines in one row are times of none."""
    timed("flexiv_factory", (10.0, 20.0, 100.0, 0.0))
    record = shelf.record()
    shelf.campaign(record)
    assert "cores 8, processor x86-64" in section_of(
        shelf.campaign(record | {"machine": {"processor": "other"}}).report()
    )


def test_two_machines_are_said_to_be_mixed(shelf, timed):
    timed("flexiv_factory", (10.0, 20.0, 100.0, 0.0))
    record = shelf.record()
    text = section_of(shelf.campaign(record).campaign(record | {"machine": {"processor": "other"}}).report())
    assert "these times are mixed" in text


def test_without_times_there_is_no_section(shelf):
    """Refused runs have none."""
    shelf.fail(shelf.specification("mpc", "none"), status="refused")
    assert 'id="w1-timing"' not in shelf.campaign().report().html
