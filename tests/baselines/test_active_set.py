"""The exact minimiser on known active rows, and the refusal to give one that is none."""

import numpy as np
import pytest
from torquebench.baselines.active_set import refine

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
