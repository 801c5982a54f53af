"""The minimiser of a quadratic program from its active rows, known or guessed: the same to the bit in each run."""

import numba
import numpy as np

DEPENDENT = 1e-10
"""A row that adds less than this share of itself to those before it is taken for dependent on them."""
ATTEMPTS = 6
"""Sets of active rows that are tried before the solver is asked."""


@numba.njit(cache=True)
def refine(
    hessian: np.ndarray,
    gradient: np.ndarray,
    rows: np.ndarray,
    least: np.ndarray,
    most: np.ndarray,
    multipliers: np.ndarray,
    tolerance: float,
    solution: np.ndarray,
) -> bool:
    r"""Replace a solution to some tolerance by the exact one on the same active rows, if that is one.

    .. math:: x = -H^{-1} (g + A^T \lambda), \quad A H^{-1} A^T \lambda = -b - A H^{-1} g

    with A the rows whose multipliers are not zero and b their bounds. Kept only if it violates no row.
    Source: Nocedal, Wright, Numerical Optimization (2006), section 16.2 (Schur complement method).

    Args:
        hessian: H, positive definite, shape (v, v).
        gradient: g, shape (v,).
        rows: C, shape (r, v).
        least: l, shape (r,).
        most: u, shape (r,).
        multipliers: Of the rows, positive at the upper bound, negative at the lower, shape (r,).
        tolerance: Largest violation of a row, and largest multiplier of an inactive one.
        solution: The solution, shape (v,); receives the exact one.

    Returns:
        Whether it was replaced.
    """
    v, count = gradient.shape[0], rows.shape[0]
    factor, free, spread, columns = np.empty((v, v)), np.empty(v), np.empty(v), np.empty((v, count))
    if not _cholesky(hessian, factor):
        return False
    _forward(factor, gradient, free)
    for i in range(count):
        if abs(multipliers[i]) > tolerance:
            _forward(factor, rows[i], spread)
            columns[:, i] = spread
    opposite, forces = np.empty(v), np.empty(count)
    if not _project(free, columns, least, most, multipliers, tolerance, opposite, forces):
        return False
    _backward(factor, opposite)
    if not holds(np.ascontiguousarray(rows.T), least, most, opposite, tolerance):
        return False
    for k in range(v):
        solution[k] = -opposite[k]
    return True


@numba.njit(cache=True)
def settle(
    hessian: np.ndarray,
    gradient: np.ndarray,
    rows: np.ndarray,
    least: np.ndarray,
    most: np.ndarray,
    sides: np.ndarray,
    tolerance: float,
    solution: np.ndarray,
) -> int:
    r"""Do the same as :func:`settle_projection` for any H, in the coordinates :math:`L^T x` that make it the identity.

    Args:
        hessian: H, positive definite, shape (v, v).
        gradient: g, shape (v,).
        rows: C, shape (r, v).
        least: l, shape (r,).
        most: u, shape (r,).
        sides: Guess, as there, shape (r,); receives the last.
        tolerance: Largest violation of a row.
        solution: Receives the minimiser, shape (v,).

    Returns:
        How many sets were tried; minus that if none of them was the right one.
    """
    v, count = gradient.shape[0], rows.shape[0]
    factor, free, spread, columns = np.empty((v, v)), np.empty(v), np.empty(v), np.empty((v, count))
    if not _cholesky(hessian, factor):
        return -1
    _forward(factor, gradient, free)
    if not sides.any():
        # Most programs are free: their rows need no other coordinates.
        spread[:] = free
        _backward(factor, spread)
        if holds(np.ascontiguousarray(rows.T), least, most, spread, tolerance):
            solution[:] = -spread
            return 1
    for i in range(count):
        _forward(factor, rows[i], spread)
        columns[:, i] = spread
    tried = settle_projection(free, columns, least, most, sides, tolerance, spread)
    if tried > 0:
        _backward(factor, spread)
        solution[:] = spread
    return tried


@numba.njit(cache=True)
def settle_projection(
    gradient: np.ndarray,
    columns: np.ndarray,
    least: np.ndarray,
    most: np.ndarray,
    sides: np.ndarray,
    tolerance: float,
    solution: np.ndarray,
) -> int:
    r"""Find the minimiser for H = 1 from a guess of its active rows, if a few corrections of the guess lead to it.

    Rows whose multipliers have the wrong sign are let go, rows that are violated are taken in, until neither is left:
    then the conditions of the optimum hold, and a strictly convex program has only one. The sets may also run in a
    circle, so that few are tried.
    Source: Hintermueller, Ito, Kunisch, The primal-dual active set strategy as a semismooth Newton method, SIAM Journal
    on Optimization 13 (2003).

    Args:
        gradient: g, shape (v,).
        columns: C by column, shape (v, r).
        least: l, shape (r,).
        most: u, shape (r,).
        sides: Guess, 1 for rows at the upper bound, -1 at the lower, 0 for all others, shape (r,); receives the last.
        tolerance: Largest violation of a row.
        solution: Receives the minimiser, shape (v,).

    Returns:
        How many sets were tried; minus that if none of them was the right one.
    """
    v, count = gradient.shape[0], sides.shape[0]
    opposite, forces, values = np.empty(v), np.empty(count), np.empty(count)
    for attempt in range(1, ATTEMPTS + 1):
        if not _project(gradient, columns, least, most, sides, 0.5, opposite, forces):
            return -attempt
        _rows_at(columns, opposite, values)
        is_right = True
        for i in range(count):
            side = sides[i]
            if side * forces[i] < 0.0:
                side = 0.0
            elif side == 0.0 and not values[i] <= most[i] + tolerance:
                side = 1.0
            elif side == 0.0 and not values[i] >= least[i] - tolerance:
                side = -1.0
            is_right &= side == sides[i]
            sides[i] = side
        if is_right:
            if not np.isfinite(opposite).all():
                return -attempt
            for k in range(v):
                solution[k] = -opposite[k]
            return attempt
    return -ATTEMPTS


@numba.njit(cache=True)
def refine_projection(
    gradient: np.ndarray,
    columns: np.ndarray,
    least: np.ndarray,
    most: np.ndarray,
    multipliers: np.ndarray,
    tolerance: float,
    solution: np.ndarray,
) -> bool:
    r"""Do the same as :func:`refine` where H is the identity, so that a program of many unknowns costs little.

    Args:
        gradient: g, shape (v,).
        columns: C by column, shape (v, r).
        least: l, shape (r,).
        most: u, shape (r,).
        multipliers: Of the rows, positive at the upper bound, negative at the lower, shape (r,).
        tolerance: Largest violation of a row, and largest multiplier of an inactive one.
        solution: The solution, shape (v,); receives the exact one.

    Returns:
        Whether it was replaced.
    """
    opposite, forces = np.empty(gradient.shape[0]), np.empty(multipliers.shape[0])
    if not _project(gradient, columns, least, most, multipliers, tolerance, opposite, forces):
        return False
    if not holds(columns, least, most, opposite, tolerance):
        return False
    for k in range(gradient.shape[0]):
        solution[k] = -opposite[k]
    return True


@numba.njit(cache=True)
def _project(
    gradient: np.ndarray,
    columns: np.ndarray,
    least: np.ndarray,
    most: np.ndarray,
    multipliers: np.ndarray,
    tolerance: float,
    opposite: np.ndarray,
    forces: np.ndarray,
) -> bool:
    """Write the opposite of the minimiser on the active rows for H = 1, and return whether they are independent.

    The rows' own multipliers there are written too, zero for rows that are not active.
    Sums run over the unknowns in the outer loop: the processor then adds many rows at once, and in the same order.
    """
    v, count = gradient.shape[0], 0
    active = np.empty(columns.shape[1], dtype=np.int64)
    for i in range(columns.shape[1]):
        if abs(multipliers[i]) > tolerance:
            active[count] = i
            count += 1
    if count > v:
        return False
    rows, schur, inner, pulls = (
        np.empty((v, count)),
        np.zeros((count, count)),
        np.empty((count, count)),
        np.empty(count),
    )
    for a in range(count):
        i = active[a]
        pulls[a] = -(most[i] if multipliers[i] > 0.0 else least[i])
    for k in range(v):
        for a in range(count):
            rows[k, a] = columns[k, active[a]]
        for a in range(count):
            pulls[a] -= rows[k, a] * gradient[k]
        for a in range(count):
            share = rows[k, a]
            for b in range(count):
                schur[a, b] += share * rows[k, b]
    if not _cholesky(schur, inner):
        return False
    _forward(inner, pulls.copy(), pulls)
    _backward(inner, pulls)
    for k in range(v):
        opposite[k] = gradient[k]
        for a in range(count):
            opposite[k] += pulls[a] * rows[k, a]
    forces[:] = 0.0
    for a in range(count):
        forces[active[a]] = pulls[a]
    return True


@numba.njit(cache=True)
def holds(columns: np.ndarray, least: np.ndarray, most: np.ndarray, opposite: np.ndarray, tolerance: float) -> bool:
    """Return whether the opposite of a point violates no row by more than the tolerance; NaN never holds.

    Args:
        columns: C by column, shape (v, r).
        least: l, shape (r,).
        most: u, shape (r,).
        opposite: Minus the point, shape (v,).
        tolerance: Largest violation.
    """
    values = np.empty(columns.shape[1])
    _rows_at(columns, opposite, values)
    inside = True
    for i in range(values.shape[0]):
        inside &= least[i] - tolerance <= values[i] <= most[i] + tolerance
    return inside


@numba.njit(cache=True)
def _rows_at(columns: np.ndarray, opposite: np.ndarray, values: np.ndarray) -> None:
    """Write what the rows are at the opposite of a point."""
    values[:] = 0.0
    for k in range(opposite.shape[0]):
        share = opposite[k]
        for i in range(values.shape[0]):
            values[i] -= columns[k, i] * share


@numba.njit(cache=True)
def _cholesky(matrix: np.ndarray, factor: np.ndarray) -> bool:
    """Write the lower factor, and return whether the matrix is safely positive definite."""
    for i in range(matrix.shape[0]):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= factor[i, k] * factor[j, k]
            if i > j:
                factor[i, j] = rest / factor[j, j]
            elif rest > DEPENDENT * matrix[i, i]:
                factor[i, i] = np.sqrt(rest)
            else:
                return False
    return True


@numba.njit(cache=True)
def _forward(factor: np.ndarray, right: np.ndarray, result: np.ndarray) -> None:
    """Write the solution of L x = b."""
    for i in range(right.shape[0]):
        rest = right[i]
        for k in range(i):
            rest -= factor[i, k] * result[k]
        result[i] = rest / factor[i, i]


@numba.njit(cache=True)
def _backward(factor: np.ndarray, result: np.ndarray) -> None:
    """Replace b by the solution of L^T x = b."""
    n = result.shape[0]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            result[i] -= factor[k, i] * result[k]
        result[i] /= factor[i, i]
