"""Bisection: the first failure of a response, and the word when there is more to it."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.scenarios.margins import MARGINS
from torquebench.scenarios.search import search


@given(last=st.integers(1, 100), edge=st.integers(1, 120))
def test_a_monotone_response_is_bracketed_to_one_step(last, edge):
    """Everything below the edge passes: the last step that does is the margin, wherever the rungs stand."""
    found = search(lambda step: step < edge, last)
    assert found.passed == min(edge - 1, last)
    assert found.failed == (edge if edge <= last else None)
    assert found.monotone


def test_a_response_that_recovers_reports_its_first_failure_and_is_flagged():
    """Passes, fails, passes: a search that only narrowed a bracket could never see it."""
    found = search(lambda step: step < 20 or step >= 60, 100)
    assert (found.passed, found.failed, found.monotone) == (19, 20, False)


@given(response=st.lists(st.booleans(), min_size=2, max_size=80))
def test_any_response_is_bracketed_between_neighbours_and_flagged_if_it_recovers(response):
    """Whatever an arm does: the last pass and the first failure stand side by side, and the flag is what was seen."""
    found = search(response.__getitem__, len(response) - 1)
    seen = dict(found.probes)
    assert all(passed == response[step] for step, passed in seen.items())
    failures = [step for step, passed in seen.items() if not passed]
    assert found.failed == (min(failures) if failures else None)
    assert found.passed == (None if not response[0] else len(response) - 1 if not failures else found.failed - 1)
    assert found.monotone == (not any(passed for step, passed in seen.items() if failures and step > found.failed))


def test_a_nominal_failure_has_no_margin():
    """Nothing is tried beyond a world that is not come through as it is."""
    found = search(lambda step: False, 100)
    assert (found.passed, found.failed, found.probes) == (None, 0, ((0, False),))


def test_no_step_is_tried_twice():
    """A step is a run of seconds."""
    tried = []
    search(lambda step: not tried.append(step) and step < 37, 100)
    assert len(tried) == len(set(tried)) <= 12


@pytest.mark.parametrize("margin", MARGINS.values(), ids=lambda margin: margin.id)
def test_a_grid_begins_with_the_nominal_world_and_gets_worse(margin):
    """Otherwise the first failure is not the nearest one."""
    values = [margin.of(step, 1e-3) for step in range(len(margin.grid))]
    assert values[0] == abs(margin.grid[0] - margin.origin)
    assert all(one < two for one, two in pairwise(values))


def test_the_resolutions_are_those_of_the_definition():
    """0.1 kg, 1 ms, 5 %, a factor of 1.5."""
    load, delay, up, down, noise = list(MARGINS.values())[:5]
    assert load.of(1, 1e-3) == pytest.approx(0.1)
    assert delay.of(1, 1e-3) == pytest.approx(1e-3)
    assert up.of(1, 1e-3) == down.of(1, 1e-3) == pytest.approx(0.05)
    assert noise.of(5, 1e-3) / noise.of(4, 1e-3) == pytest.approx(1.5, rel=1e-5)
