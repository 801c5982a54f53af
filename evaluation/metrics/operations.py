"""What a controller's arithmetic comes to: solver iterations, and a labelled estimate of its energy from counts."""

import numpy as np

from .registry import metric

MULTIPLY, ADD = 3.7e-12, 0.9e-12
"""Energy of a float32 operation in 45 nm at 0.9 V [J], after Horowitz, ISSCC 2014; measured on no machine of ours."""

MICRO = 1e6


@metric(
    unit="uW",
    better="lower",
    family="operations",
    needs=("multiplications", "additions"),
    source="3.7 pJ a multiplication, 0.9 pJ an addition (45 nm, float32; Horowitz, ISSCC 2014)",
    label="estimated power of the arithmetic (no measurement)",
    kind="table",
)
def op_energy_estimate(multiplications: float, additions: float) -> float:
    """Estimated power of the arithmetic alone; never without the counts that it is made of.

    A multiply-accumulate counts as one of each, an accumulate (a weight added on a spike) as an addition. Memory
    traffic, which dominates in networks whose weights fit into no cache, is not in it.

    Args:
        multiplications: Multiplications in each second of simulated time [1/s].
        additions: Additions in each second of simulated time [1/s].

    Returns:
        The estimate [uW]; NaN if a count is not finite.

    Raises:
        EmptyWindow: If arrays came and they are empty.
    """
    return float(MICRO * (MULTIPLY * multiplications + ADD * additions))


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
