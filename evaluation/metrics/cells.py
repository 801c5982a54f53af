"""Cells of a grid against each other: materials, the worst of all, repetitions, new motions, verdicts."""

import math

import numpy as np

from .registry import UNDEFINED, metric, variant


def _ratio_of_geometric_means(a: np.ndarray, b: np.ndarray) -> float:
    """Return the geometric mean of one table by that of another; NaN where an entry is not positive."""
    if not (a.size and b.size and (a > 0.0).all() and (b > 0.0).all()):
        return UNDEFINED
    return math.exp(float(np.log(a).mean() - np.log(b).mean()))


@metric(
    unit="-",
    better="none",
    family="adaptation",
    needs=("water", "sand"),
    source="paper, Obs. 5: geometric mean over motions and masses of water / sand",
    label="error with water by that with sand",
    kind="table",
)
def material_ratio(water: np.ndarray, sand: np.ndarray) -> float:
    """How much larger the error is with water; right is 1.

    Args:
        water: Errors with water, a row for each mass, shape (masses, motions), any unit.
        sand: Errors of the same cells with sand, shape (masses, motions), the same unit.

    Returns:
        The ratio [1]; NaN if an entry is not finite or not positive.

    Raises:
        EmptyWindow: If there is no mass.
        UnequalLengths: If the tables hold different numbers of masses.
    """
    return _ratio_of_geometric_means(water, sand)


@metric(
    unit="m",
    better="lower",
    family="adaptation",
    needs=("errors",),
    source="largest entry",
    label="position error of the worst cell",
    kind="table",
)
def worst_case_position(errors: np.ndarray) -> float:
    """Error of the cell in which it is largest.

    Args:
        errors: A row for each load, shape (loads, motions) [m].

    Returns:
        The error [m]; NaN if an entry is not finite.

    Raises:
        EmptyWindow: If there is no load.
    """
    return float(errors.max())


worst_case_orientation = variant(
    worst_case_position, "worst_case_orientation", "orientation error of the worst cell", quantity=("m", "rad")
)


@metric(
    unit="-",
    better="lower",
    family="adaptation",
    needs=("errors",),
    source="largest entry / mean",
    label="error of the worst cell by the mean",
    kind="table",
)
def worst_to_mean(errors: np.ndarray) -> float:
    """How much larger the error of the worst cell is than that of all.

    Args:
        errors: A row for each load, shape (loads, motions), any unit.

    Returns:
        The ratio, at least 1 [1]; NaN if an entry is not finite or there is no error.

    Raises:
        EmptyWindow: If there is no load.
    """
    mean = float(errors.mean())
    return float(errors.max()) / mean if mean > 0.0 else UNDEFINED


@metric(
    unit="m",
    better="lower",
    family="adaptation",
    needs=("repeats",),
    source="paper, caption of the results: largest less smallest over repetitions, mean over cells",
    label="range of the position error over repetitions",
    kind="table",
)
def repeat_range_position(repeats: np.ndarray) -> float:
    """Range over the repetitions, averaged over the cells; it grows with their number.

    Args:
        repeats: A row for each cell, shape (cells, repetitions) [m].

    Returns:
        The range [m]; NaN if an entry is not finite.

    Raises:
        EmptyWindow: If there is no cell.
    """
    return float(np.ptp(repeats, axis=1).mean())


repeat_range_orientation = variant(
    repeat_range_position,
    "repeat_range_orientation",
    "range of the orientation error over repetitions",
    quantity=("m", "rad"),
)


@metric(
    unit="-",
    better="lower",
    family="adaptation",
    needs=("new", "trained"),
    source="geometric mean on motions of no training / on the training's own",
    label="error on new motions by that on trained ones",
    kind="table",
)
def heldout_gap(new: np.ndarray, trained: np.ndarray) -> float:
    """How much larger the error is on motions that no training has seen.

    Args:
        new: Errors on such motions, a row for each load, shape (loads, motions), any unit.
        trained: Errors on the motions of the training with the same loads, shape (loads, motions), the same unit.

    Returns:
        The ratio [1]; NaN if an entry is not finite or not positive.

    Raises:
        EmptyWindow: If there is no load.
        UnequalLengths: If the tables hold different numbers of loads.
    """
    return _ratio_of_geometric_means(new, trained)


@metric(
    unit="1",
    better="higher",
    family="adaptation",
    needs=("verdicts", "others"),
    source="share of claims with the same verdict under two conditions",
    label="agreement of verdicts",
    kind="table",
)
def verdict_agreement(verdicts: np.ndarray, others: np.ndarray) -> float:
    """Share of the claims whose verdict is the same under two conditions.

    Args:
        verdicts: A number for the class of each claim's verdict, shape (claims,).
        others: The same claims' under the other condition, shape (claims,).

    Returns:
        The share [1]; NaN if an entry is not finite.

    Raises:
        EmptyWindow: If there is no claim.
        UnequalLengths: If the arrays hold different numbers of claims.
    """
    return float((verdicts == others).mean())
