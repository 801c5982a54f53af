"""What a controller's arithmetic comes to: solver iterations, and a labelled estimate of its energy from counts."""

import numpy as np

from .registry import metric

PICOJOULES_TO_MICROJOULES = 1e-6


@metric(
    unit="uW",
    better="lower",
    family="operations",
    needs=("operations", "picojoules"),
    source="counts times prices of single operations, for example 3.7 pJ a multiplication (Horowitz, ISSCC 2014)",
    label="estimated power of the arithmetic (no measurement)",
    kind="table",
)
def op_energy_estimate(operations: np.ndarray, picojoules: np.ndarray) -> float:
    """Estimated power of the arithmetic alone, learning included; never without the counts that it is made of.

    Memory traffic, which dominates in networks whose weights fit into no cache, is not in it. The prices that reports
    use are those of :func:`~torquebench.evaluation.energy.energy_table`.

    Args:
        operations: Operations of each kind in a second of simulated time, shape (K,) [1/s].
        picojoules: Energy of one operation of each kind, shape (K,) [pJ].

    Returns:
        The estimate [uW]; NaN if a count or a price is not finite.

    Raises:
        EmptyWindow: If there is no kind of operation.
    """
    return float(PICOJOULES_TO_MICROJOULES * np.dot(operations, picojoules))


@metric(
    unit="iterations",
    better="lower",
    family="operations",
    needs=("iterations",),
    source="median",
    label="iterations of a solve, median",
    kind="table",
)
def solver_iterations_median(iterations: np.ndarray) -> float:
    """Median number of iterations that a solver needed.

    Args:
        iterations: Iterations of each solve, shape (S,).

    Returns:
        The median; NaN if any is not finite.

    Raises:
        EmptyWindow: If there is no solve.
    """
    return float(np.median(iterations))


@metric(
    unit="iterations",
    better="lower",
    family="operations",
    needs=("iterations",),
    source="99th percentile",
    label="iterations of a solve, 99th percentile",
    kind="table",
)
def solver_iterations_p99(iterations: np.ndarray) -> float:
    """Number of iterations that 99 % of the solves stay within (linear interpolation).

    Args:
        iterations: Iterations of each solve, shape (S,).

    Returns:
        The percentile; NaN if any is not finite.

    Raises:
        EmptyWindow: If there is no solve.
    """
    return float(np.percentile(iterations, 99.0))
