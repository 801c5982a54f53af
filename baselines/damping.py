"""Damping of a Cartesian spring by rule: the tool's inertia and a damping ratio decide, per direction.

Both designs take the same arguments, so that a law holds one of them and does not ask which.
"""

from collections.abc import Callable

import numba
import numpy as np

MOBILITY_FLOOR = 1e-9
"""Smallest mobility that counts, as a share of the largest: below it the arm cannot move that way."""

FREQUENCY_FLOOR = 8.0
"""Smallest natural frequency that damps in :func:`double_diagonalised_damping` [rad/s]; singularities are below."""


@numba.njit(cache=True)
def tool_mobility(mass_matrix: np.ndarray, jacobian: np.ndarray, mobility: np.ndarray) -> None:
    r"""Write the acceleration of the tool for a unit wrench.

    .. math:: A = J M^{-1} J^T = Y^T Y, \quad L Y = J^T, \quad M = L L^T

    Source: Khatib, A unified approach for motion and force control of robot manipulators, IEEE J. Robotics and
    Automation 3 (1987).

    Args:
        mass_matrix: M, positive definite, shape (n, n) [kg m^2].
        jacobian: J, linear before angular, shape (6, n).
        mobility: Receives A, shape (6, 6) [1/kg, 1/(kg m), 1/(kg m^2)].
    """
    n = mass_matrix.shape[0]
    factor, half = np.empty((n, n)), np.empty((n, 6))
    for i in range(n):
        for j in range(i + 1):
            rest = mass_matrix[i, j]
            for k in range(j):
                rest -= factor[i, k] * factor[j, k]
            factor[i, j] = np.sqrt(rest) if i == j else rest / factor[j, j]
        for c in range(6):
            rest = jacobian[c, i]
            for k in range(i):
                rest -= factor[i, k] * half[k, c]
            half[i, c] = rest / factor[i, i]
    for r in range(6):
        for c in range(r + 1):
            total = 0.0
            for k in range(n):
                total += half[k, r] * half[k, c]
            mobility[r, c] = total
            mobility[c, r] = total


@numba.njit(cache=True)
def square_root_damping(
    mobility: np.ndarray, stiffness: np.ndarray, ratio: float, damping: np.ndarray, inertia: np.ndarray
) -> None:
    r"""Write the damping whose factors are the square roots of inertia and stiffness.

    .. math:: D = \zeta (\Lambda^{1/2} K^{1/2} + K^{1/2} \Lambda^{1/2}), \quad \Lambda = A^{-1}

    Directions in which the arm cannot move get no damping, and an inertia at the floor of the mobility.
    Source: Albu-Schaeffer, Ott, Frese, Hirzinger, Cartesian impedance control of redundant robots, ICRA 2003
    (factorisation design).

    Args:
        mobility: A, shape (6, 6) [1/kg, 1/(kg m), 1/(kg m^2)].
        stiffness: Diagonal of K, shape (6,) [N/m, N m/rad].
        ratio: Damping ratio zeta.
        damping: Receives D, symmetric, shape (6, 6) [N s/m, N s, N m s].
        inertia: Receives the tool's inertia, symmetric, shape (6, 6) [kg, kg m, kg m^2].
    """
    values, vectors = np.linalg.eigh(mobility)
    floor = MOBILITY_FLOOR * values[5]
    root = np.sqrt(stiffness)
    damping[:] = 0.0
    inertia[:] = 0.0
    for i in range(6):
        mass = 1.0 / max(values[i], floor)
        root_mass = ratio * np.sqrt(mass) if values[i] > floor else 0.0
        for r in range(6):
            for c in range(6):
                pair = vectors[r, i] * vectors[c, i]
                inertia[r, c] += mass * pair
                damping[r, c] += root_mass * pair * (root[r] + root[c])


@numba.njit(cache=True)
def double_diagonalised_damping(
    mobility: np.ndarray, stiffness: np.ndarray, ratio: float, damping: np.ndarray, inertia: np.ndarray
) -> None:
    r"""Write the damping that gives every mode of inertia and stiffness the same ratio.

    .. math:: K^{1/2} A K^{1/2} = U \mathrm{diag}(\omega^2) U^T, \quad
        D = 2 \zeta K^{1/2} U \mathrm{diag}(1 / \max(\omega, \omega_{min})) U^T K^{1/2}

    The floor on the natural frequencies bounds D near a singularity; the inertia keeps its own, far smaller one.
    Source: Albu-Schaeffer, Ott, Frese, Hirzinger, Cartesian impedance control of redundant robots, ICRA 2003
    (double diagonalisation), in a form free of units.

    Args:
        mobility: A, shape (6, 6) [1/kg, 1/(kg m), 1/(kg m^2)].
        stiffness: Diagonal of K, shape (6,) [N/m, N m/rad].
        ratio: Damping ratio zeta.
        damping: Receives D, symmetric, shape (6, 6) [N s/m, N s, N m s].
        inertia: Receives the tool's inertia, symmetric, shape (6, 6) [kg, kg m, kg m^2].
    """
    root = np.sqrt(stiffness)
    scaled = np.empty((6, 6))
    for r in range(6):
        for c in range(6):
            scaled[r, c] = root[r] * mobility[r, c] * root[c]
    squares, vectors = np.linalg.eigh(scaled)
    floor = MOBILITY_FLOOR * squares[5]
    damping[:] = 0.0
    inertia[:] = 0.0
    for i in range(6):
        square = max(squares[i], floor)
        rate = 2.0 * ratio / max(np.sqrt(square), FREQUENCY_FLOOR)
        for r in range(6):
            for c in range(6):
                pair = root[r] * vectors[r, i] * vectors[c, i] * root[c]
                inertia[r, c] += pair / square
                damping[r, c] += rate * pair


Design = Callable[[np.ndarray, np.ndarray, float, np.ndarray, np.ndarray], None]
"""Takes mobility, stiffness and ratio; fills damping and inertia."""

DAMPING_DESIGNS: dict[str, Design] = {
    "square_root": square_root_damping,
    "double_diagonalisation": double_diagonalised_damping,
}
"""The damping designs by the name of their setting."""
