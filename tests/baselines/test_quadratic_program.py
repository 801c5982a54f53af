"""The kept solver: right, repeatable, bounded in work, and honest when it does not know."""

import numpy as np
import pytest
from torquebench.baselines.quadratic_program import ProjectionProgram, QuadraticProgram

CAPS = {"tolerance": 1e-8, "outer": 20, "inner": 20}


def program(seed, *, size=5):
    """Return a strictly convex program with some active rows."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((size, size))
    hessian, gradient = root @ root.T + np.eye(size), 5.0 * rng.standard_normal(size)
    return hessian, gradient, rng.standard_normal((size, size)), np.full(size, -0.3), np.full(size, 0.3)


def drifting(count):
    """Return neighbouring programs, as successive ticks are."""
    hessian, gradient, rows, least, most = program(0)
    return [(hessian, gradient * (1.0 + 0.01 * k), rows, least, most) for k in range(count)]


@pytest.mark.parametrize("seed", range(5))
def test_a_box_is_solved_as_projected_coordinates(seed):
    """With a diagonal Hessian the solution is the clipped minimiser."""
    rng = np.random.default_rng(seed)
    weights, gradient = rng.uniform(1.0, 100.0, 4), 50.0 * rng.standard_normal(4)
    solver = QuadraticProgram(4, 4, **CAPS)
    found = solver.solve(np.diag(weights), gradient, np.eye(4), np.full(4, -0.5), np.full(4, 0.5))
    assert found == pytest.approx(np.clip(-gradient / weights, -0.5, 0.5), abs=1e-7)


def test_a_warm_start_finds_what_a_cold_one_finds_with_less_work():
    """The solution is a property of the program, not of where the search began."""
    warm, cold = QuadraticProgram(5, 5, **CAPS), QuadraticProgram(5, 5, warm=False, **CAPS)
    for data in drifting(50):
        assert warm.solve(*data) == pytest.approx(cold.solve(*data), abs=1e-6)
    assert warm.iterations < cold.iterations
    assert warm.solves == cold.solves == 50


def test_a_contradiction_ends_early_and_leaves_no_trace():
    """No answer instead of a wrong or late one; the next program starts cold and is solved."""
    size = 3
    rows = np.vstack([np.eye(size), np.eye(size)])
    ok = (np.full(6, -1.0), np.full(6, 1.0))
    torn = (np.array([1.0] * 3 + [-2.0] * 3), np.array([2.0] * 3 + [-1.0] * 3))
    solver = QuadraticProgram(size, 6, **CAPS)
    gradient = np.array([-5.0, 0.5, 5.0])
    first = solver.solve(np.eye(size), gradient, rows, *ok)
    assert solver.solve(np.eye(size), gradient, rows, *torn) is None
    assert solver.last_iterations <= CAPS["outer"] * (CAPS["inner"] + 1)
    assert solver.solve(np.eye(size), gradient, rows, *ok) == pytest.approx(first, abs=1e-7)


def test_a_solution_belongs_to_its_caller():
    """Writing into it must not move the next warm start, nor may the next solve change it."""
    kept, touched = QuadraticProgram(5, 5, **CAPS), QuadraticProgram(5, 5, **CAPS)
    for data in drifting(5):
        found = touched.solve(*data)
        assert np.array_equal(found, kept.solve(*data))
        found[:] = 1e6


def test_not_a_number_is_no_solution():
    """What the solver makes of it does not reach the drives."""
    hessian, gradient, rows, least, most = program(0)
    assert QuadraticProgram(5, 5, **CAPS).solve(hessian, gradient * np.nan, rows, least, most) is None


def test_multipliers_of_rows_that_are_free_again_are_let_go():
    """Residuals alone would keep them: two programs whose stationarity holds with the same point and multipliers."""
    solver, far = QuadraticProgram(2, 2, **CAPS), np.full(2, 1e3)
    pushed = solver.solve(np.eye(2), np.zeros(2), np.eye(2), -far, np.full(2, -1.0))
    assert pushed == pytest.approx(np.full(2, -1.0), abs=1e-7)
    assert solver.solve(np.eye(2), np.zeros(2), np.eye(2), -far, far) == pytest.approx(np.zeros(2), abs=1e-7)


def test_a_projection_is_what_the_whole_program_is_with_or_without_the_solver():
    """Settled on the last active rows, or by ProxQP from nothing: the nearest point is one point."""
    rng, size, rows = np.random.default_rng(4), 6, 6
    columns, bounds = rng.standard_normal((size, rows)), (np.full(rows, -1.0), np.full(rows, 1.0))
    kept = ProjectionProgram(size, rows, **CAPS)
    for k in range(60):
        gradient = 1.5 * np.sin(0.1 * k + np.arange(size))
        whole = QuadraticProgram(size, rows, **CAPS).solve(np.eye(size), gradient, columns.T, *bounds)
        assert kept.solve(gradient, columns, *bounds) == pytest.approx(whole, abs=1e-6)
    assert kept.iterations > 0
    assert kept.solves == 60 and kept.asked < 6


def test_a_contradiction_in_a_projection_has_no_answer_and_leaves_no_trace():
    """It comes from the solver, and the next program is solved as if nothing had been."""
    size = 3
    columns = np.hstack([np.eye(size), np.eye(size)])
    ok = (np.full(6, -1.0), np.full(6, 1.0))
    torn = (np.array([1.0] * 3 + [-2.0] * 3), np.array([2.0] * 3 + [-1.0] * 3))
    program, gradient = ProjectionProgram(size, 6, **CAPS), np.array([-5.0, 0.5, 5.0])
    first = program.solve(gradient, columns, *ok)
    assert program.solve(gradient, columns, *torn) is None
    assert program.solve(gradient, columns, *ok) == pytest.approx(first, abs=1e-7)
    assert first == pytest.approx([1.0, -0.5, -1.0], abs=1e-7)
