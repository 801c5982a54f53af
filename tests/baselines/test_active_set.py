"""The exact minimiser on known active rows, and the refusal to give one that is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.baselines.active_set import ATTEMPTS, refine, settle_projection

TOLERANCE = 1e-9


def program(seed, *, size=6, rows=8):
    """Return a strictly convex program without bounds."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((size, size))
    return root @ root.T + np.eye(size), rng.standard_normal(size), rng.standard_normal((rows, size))


@pytest.mark.parametrize("seed", range(5))
def test_it_solves_the_optimality_conditions_on_the_active_rows(seed):
    """As one linear system with the multipliers; the sign of a multiplier says which bound."""
    hessian, gradient, rows = program(seed)
    multipliers = np.array([1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    most, least = np.full(8, 50.0), np.full(8, -50.0)
    most[0], least[2] = 0.3, -0.2
    found = np.zeros(6)
    assert refine(hessian, gradient, rows, least, most, multipliers, TOLERANCE, found)
    active = rows[[0, 2]]
    system = np.block([[hessian, active.T], [active, np.zeros((2, 2))]])
    expected = np.linalg.solve(system, np.concatenate([-gradient, [0.3, -0.2]]))
    assert found == pytest.approx(expected[:6], abs=1e-10)


def test_without_active_rows_it_is_the_free_minimiser():
    """H x = -g."""
    hessian, gradient, rows = program(0)
    found, far = np.zeros(6), np.full(8, 1e20)
    assert refine(hessian, gradient, rows, -far, far, np.zeros(8), TOLERANCE, found)
    assert found == pytest.approx(np.linalg.solve(hessian, -gradient), abs=1e-10)


def test_what_violates_a_row_is_not_taken():
    """A row was forgotten: the solution to the solver's tolerance stays as it is."""
    hessian, gradient, rows = program(0)
    found, tight = np.full(6, 7.0), np.full(8, 1e-6)
    assert not refine(hessian, gradient, rows, -tight, tight, np.zeros(8), TOLERANCE, found)
    assert np.all(found == 7.0)


def test_rows_that_depend_on_each_other_are_not_solved():
    """Two copies of a row have no multipliers of their own."""
    hessian, gradient, rows = program(0)
    rows[1] = 2.0 * rows[0]
    found, far, multipliers = np.full(6, 7.0), np.full(8, 1.0), np.array([1.0, 1.0, 0, 0, 0, 0, 0, 0])
    assert not refine(hessian, gradient, rows, -far, far, multipliers, TOLERANCE, found)
    assert np.all(found == 7.0)


def projection(seed, *, size=6, rows=6):
    """Return gradient, rows by column and bounds of a projection that some rows are in the way of."""
    rng = np.random.default_rng(seed)
    return 1.5 * rng.standard_normal(size), rng.standard_normal((size, rows)), np.full(rows, -1.0), np.full(rows, 1.0)


def settled(data, sides):
    """Return how many sets were tried, and what was found."""
    found = np.full(len(data[0]), 7.0)
    return settle_projection(*data, sides, TOLERANCE, found), found


@given(seed=st.integers(0, 10_000), guess=st.lists(st.sampled_from([-1.0, 0.0, 1.0]), min_size=6, max_size=6))
def test_what_is_settled_is_the_optimum_whatever_the_guess(seed, guess):
    """Inside all rows, and pulled by active rows alone, each towards its own side: convexity leaves no other point."""
    gradient, columns, least, most = data = projection(seed)
    sides = np.array(guess)
    tried, found = settled(data, sides)
    assert 1 <= abs(tried) <= ATTEMPTS
    if tried < 0:
        assert np.all(found == 7.0)
        return
    values = columns.T @ found
    assert np.all(values <= most + 1e-8) and np.all(values >= least - 1e-8)
    active = np.flatnonzero(sides)
    pulls, *_ = np.linalg.lstsq(columns[:, active], -(gradient + found), rcond=None)
    assert columns[:, active] @ pulls == pytest.approx(-(gradient + found), abs=1e-7)
    assert np.all(pulls * sides[active] >= -1e-9)
    assert values[active] == pytest.approx(sides[active], abs=1e-8)


def test_the_right_guess_needs_one_attempt_and_a_free_point_none_of_its_rows():
    """The next plan has the active rows of the last: that is what makes it cheap."""
    data, sides = projection(1), np.zeros(6)
    assert settled(data, sides)[0] > 1 and sides.any()
    again = sides.copy()
    assert settled(data, again)[0] == 1 and np.array_equal(sides, again)
    free = (0.01 * data[0], *data[1:])
    assert settled(free, again)[0] > 0 and not again.any()


def test_few_programs_are_left_to_the_solver():
    """Correct but never successful would be no use: from no guess at all nine of ten are settled."""
    tried = [settled(projection(seed), np.zeros(6))[0] for seed in range(200)]
    assert sum(number > 0 for number in tried) > 180


def test_a_contradiction_is_not_settled():
    """Two copies of a row that ask for opposite things: the solver must hear of it."""
    gradient, columns, least, most = projection(2)
    columns[:, 1] = columns[:, 0]
    least[0], most[0], least[1], most[1] = 2.0, 3.0, -3.0, -2.0
    tried, found = settled((gradient, columns, least, most), np.zeros(6))
    assert tried < 0 and np.all(found == 7.0)
