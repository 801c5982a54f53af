"""What a pose leaves to the posture: the second level of the strict program, in coordinates of the null space."""

import numba
import numpy as np


def redundancy(jacobian: np.ndarray) -> int:
    """Return the number of joint motions that do not move the tool.

    Args:
        jacobian: J, shape (6, n).
    """
    return int(jacobian.shape[1] - np.linalg.matrix_rank(jacobian, tol=1e-6))


@numba.njit(cache=True)
def null_basis(mass_matrix: np.ndarray, jacobian: np.ndarray, mobility: np.ndarray, basis: np.ndarray) -> None:
    r"""Write an orthonormal basis of the joint motions that do not move the tool, in scaled unknowns.

    The eigenvectors with the smallest eigenvalues of :math:`R^T R`, where R is the jacobian in scaled unknowns with
    each row divided by the root of its mobility, so that metres and radians count alike.

    Args:
        mass_matrix: M, shape (n, n) [kg m^2].
        jacobian: J, shape (6, n).
        mobility: A, shape (6, 6) [1/kg, 1/(kg m), 1/(kg m^2)].
        basis: Receives N, shape (n, m).
    """
    n = mass_matrix.shape[0]
    square = np.zeros((n, n))
    largest = 0.0
    for r in range(6):
        largest = max(largest, mobility[r, r])
    for r in range(6):
        weight = 1.0 / max(mobility[r, r], 1e-9 * largest)
        for i in range(n):
            for j in range(n):
                root = np.sqrt(mass_matrix[i, i] * mass_matrix[j, j])
                square[i, j] += weight * jacobian[r, i] * jacobian[r, j] / root
    _, vectors = np.linalg.eigh(square)
    for k in range(basis.shape[1]):
        for i in range(n):
            basis[i, k] = vectors[i, k]


@numba.njit(cache=True)
def null_program(
    hessian: np.ndarray,
    gradient: np.ndarray,
    rows: np.ndarray,
    bounds: np.ndarray,
    first: np.ndarray,
    basis: np.ndarray,
    null_hessian: np.ndarray,
    null_gradient: np.ndarray,
    null_rows: np.ndarray,
    null_bounds: np.ndarray,
) -> None:
    r"""Write the second level's program in z, where :math:`y = y_1 + N z`.

    .. math:: \min_z \tfrac12 z^T N^T H N z + (g + H y_1)^T N z \quad \text{s.t.} \quad
        l - C y_1 \le C N z \le u - C y_1

    The bounds are widened so far that z = 0 lies within them: what the pose had to take stays taken, and the program
    always has a solution.

    Args:
        hessian: H, its upper left (n, n) block is read.
        gradient: g, its first n entries are read.
        rows: C of the first level, shape (2 n, 2 n); its left half is read.
        bounds: Lower and upper bounds of the first level, shape (2, 2 n).
        first: The first level's solution, slacks last, shape (2 n,).
        basis: N, shape (n, m).
        null_hessian: Receives the Hessian, shape (m, m).
        null_gradient: Receives the gradient, shape (m,).
        null_rows: Receives the rows, shape (2 n, m).
        null_bounds: Receives lower and upper bounds, shape (2, 2 n).
    """
    n, m = basis.shape
    product = np.empty((n, m))
    for i in range(n):
        for k in range(m):
            product[i, k] = 0.0
            for j in range(n):
                product[i, k] += hessian[i, j] * basis[j, k]
    for k in range(m):
        null_gradient[k] = 0.0
        for i in range(n):
            null_gradient[k] += gradient[i] * basis[i, k] + first[i] * product[i, k]
        for other in range(m):
            null_hessian[k, other] = 0.0
            for i in range(n):
                null_hessian[k, other] += basis[i, k] * product[i, other]
    for i in range(2 * n):
        value = 0.0
        for j in range(n):
            value += rows[i, j] * first[j]
        null_bounds[0, i], null_bounds[1, i] = min(bounds[0, i] - value, 0.0), max(bounds[1, i] - value, 0.0)
        for k in range(m):
            null_rows[i, k] = 0.0
            for j in range(n):
                null_rows[i, k] += rows[i, j] * basis[j, k]
