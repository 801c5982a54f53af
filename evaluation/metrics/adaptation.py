"""Adaptation to shape, speed, load and material: metrics of tables of mean errors, complete grids only.

A table has a row for each load and a column for each motion; an entry is the mean of a base metric over repetitions.
Positions and attitudes are judged apart, with the same formulas.
"""

import math

import numpy as np

from .registry import UNDEFINED, metric, variant


def _mean_log(errors: np.ndarray) -> float:
    """Return the mean logarithm, NaN where an entry is not positive."""
    return float(np.log(errors).mean()) if errors.size and (errors > 0.0).all() else math.nan


def _ranges(errors: np.ndarray) -> float:
    """Return the range over the columns, averaged over the rows."""
    return float(np.ptp(errors, axis=1).mean())


def _slope(values: np.ndarray, masses: np.ndarray) -> float:
    """Return the least-squares slope on the masses, averaged over the columns; NaN for one mass."""
    spread = masses - masses.mean()
    square = float(spread @ spread)
    return float((spread @ values).mean()) / square if square > 0.0 else UNDEFINED


@metric(
    unit="m",
    better="lower",
    family="adaptation",
    needs=("slow", "fast"),
    source="paper, Obs. 2: largest less smallest error over the motions, mean over loads, mean of the two groups",
    label="range of the position error over motions",
    kind="table",
)
def shape_range_position(slow: np.ndarray, fast: np.ndarray) -> float:
    """Range of the error over the motions of one speed group, averaged over the loads and the two groups.

    It falls when all errors fall; read it with :func:`shape_range_rel`.

    Args:
        slow: Errors of the slow motions, a row for each load, shape (loads, motions) [m].
        fast: Errors of the fast motions with the same loads, shape (loads, motions) [m].

    Returns:
        The range [m]; NaN if an entry is not finite.

    Raises:
        EmptyWindow: If there is no load.
        UnequalLengths: If the tables hold different numbers of loads.
    """
    return 0.5 * (_ranges(slow) + _ranges(fast))


shape_range_orientation = variant(
    shape_range_position,
    "shape_range_orientation",
    "range of the orientation error over motions",
    quantity=("m", "rad"),
)


@metric(
    unit="1",
    better="lower",
    family="adaptation",
    needs=("slow", "fast"),
    source="shape_range / mean error",
    label="range of the error over motions by mean error",
    kind="table",
)
def shape_range_rel(slow: np.ndarray, fast: np.ndarray) -> float:
    """Range over the motions, as in :func:`shape_range_position`, by the mean of all entries.

    Args:
        slow: Errors of the slow motions, shape (loads, motions), any unit.
        fast: Errors of the fast motions with the same loads, shape (loads, motions), the same unit.

    Returns:
        The share [1]; NaN if an entry is not finite or there is no error.

    Raises:
        EmptyWindow: If there is no load.
        UnequalLengths: If the tables hold different numbers of loads.
    """
    mean = float(np.concatenate([slow, fast], axis=1).mean())
    return 0.5 * (_ranges(slow) + _ranges(fast)) / mean if mean > 0.0 else UNDEFINED


@metric(
    unit="-",
    better="lower",
    family="adaptation",
    needs=("errors",),
    source="sample standard deviation over motions of ln(error), mean over loads",
    label="spread of the error over motions",
    kind="table",
)
def shape_cv(errors: np.ndarray) -> float:
    """Spread of the logarithm of the error over the motions: a factor between motions, whatever their level.

    Args:
        errors: A row for each load, shape (loads, motions), any unit.

    Returns:
        The standard deviation [1]; NaN if an entry is not finite or not positive, or there is one motion.

    Raises:
        EmptyWindow: If there is no load.
    """
    if errors.shape[1] < 2 or not (errors > 0.0).all():
        return UNDEFINED
    return float(np.log(errors).std(axis=1, ddof=1).mean())


@metric(
    unit="-",
    better="lower",
    family="adaptation",
    needs=("slow", "fast"),
    source="paper, Obs. 3: geometric mean of the fast group / of the slow group",
    label="error of the fast motions by that of the slow",
    kind="table",
)
def speed_group_ratio(slow: np.ndarray, fast: np.ndarray) -> float:
    """How much larger the error is on the fast motions; the groups differ in shape and place, too.

    Args:
        slow: Errors of the slow motions, shape (loads, motions), any unit.
        fast: Errors of the fast motions with the same loads, shape (loads, motions), the same unit.

    Returns:
        The ratio [1]; NaN if an entry is not finite or not positive.

    Raises:
        EmptyWindow: If there is no load.
        UnequalLengths: If the tables hold different numbers of loads.
    """
    return math.exp(_mean_log(fast) - _mean_log(slow))


@metric(
    unit="-",
    better="none",
    family="adaptation",
    needs=("slower", "faster", "speed_ratios"),
    source="mean of ln(faster / slower) / ln(speed ratio) over pairs of one path at two speeds",
    label="exponent of the error in the speed",
    kind="table",
)
def speed_exponent(slower: np.ndarray, faster: np.ndarray, speed_ratios: np.ndarray) -> float:
    """Power of the speed that the error grows with: 0 friction or statics, 1 lag or viscosity, 2 inertia.

    The clean contrast of speeds: T3 and T6 are one path in 4 s and 2 s, T4 and T5 one in 4 s and 3 s.

    Args:
        slower: Error of the slower motion of each pair, shape (pairs,), any unit.
        faster: Error of the faster one, shape (pairs,), the same unit.
        speed_ratios: Faster by slower speed of each pair, not 1, shape (pairs,) [1].

    Returns:
        The exponent [1]; NaN if an entry is not finite or not positive.

    Raises:
        EmptyWindow: If there is no pair.
        UnequalLengths: If the arrays hold different numbers of pairs.
    """
    if not all((values > 0.0).all() for values in (slower, faster, speed_ratios)) or (speed_ratios == 1.0).any():
        return UNDEFINED
    return float((np.log(faster / slower) / np.log(speed_ratios)).mean())


@metric(
    unit="m/kg",
    better="lower",
    family="adaptation",
    needs=("errors", "masses"),
    source="paper, Obs. 4: least-squares slope of the error on the mass, mean over motions",
    label="position error by load",
    kind="table",
)
def mass_slope_position(errors: np.ndarray, masses: np.ndarray) -> float:
    """How much the error grows with the load, averaged over the motions.

    Args:
        errors: A row for each load, shape (loads, motions) [m].
        masses: The loads, shape (loads,) [kg].

    Returns:
        The slope [m/kg]; NaN if an entry is not finite or there is one load.

    Raises:
        EmptyWindow: If there is no load.
        UnequalLengths: If the arrays hold different numbers of loads.
    """
    return _slope(errors, masses)


mass_slope_orientation = variant(
    mass_slope_position, "mass_slope_orientation", "orientation error by load", quantity=("m", "rad")
)


@metric(
    unit="1/kg",
    better="lower",
    family="adaptation",
    needs=("errors", "masses"),
    source="least-squares slope of ln(error) on the mass, mean over motions",
    label="relative growth of the error by load",
    kind="table",
)
def mass_slope_log(errors: np.ndarray, masses: np.ndarray) -> float:
    """By which share the error grows with each kilogram, averaged over the motions.

    Args:
        errors: A row for each load, shape (loads, motions), any unit.
        masses: The loads, shape (loads,) [kg].

    Returns:
        The slope [1/kg]; NaN if an entry is not finite or not positive, or there is one load.

    Raises:
        EmptyWindow: If there is no load.
        UnequalLengths: If the arrays hold different numbers of loads.
    """
    return _slope(np.log(errors), masses) if (errors > 0.0).all() else UNDEFINED


@metric(
    unit="m",
    better="lower",
    family="adaptation",
    needs=("errors",),
    source="largest less smallest over the loads of the mean over motions",
    label="range of the position error over loads",
    kind="table",
)
def mass_range_position(errors: np.ndarray) -> float:
    """Range over the loads of the error averaged over the motions.

    Args:
        errors: A row for each load, shape (loads, motions) [m].

    Returns:
        The range [m]; NaN if an entry is not finite.

    Raises:
        EmptyWindow: If there is no load.
    """
    return float(np.ptp(errors.mean(axis=1)))


mass_range_orientation = variant(
    mass_range_position,
    "mass_range_orientation",
    "range of the orientation error over loads",
    quantity=("m", "rad"),
)


@metric(
    unit="m",
    better="lower",
    family="adaptation",
    needs=("errors",),
    source="largest over the loads of the mean over motions",
    label="position error with the worst load",
    kind="table",
)
def mass_worst_position(errors: np.ndarray) -> float:
    """Error averaged over the motions, with the load for which it is largest.

    Args:
        errors: A row for each load, shape (loads, motions) [m].

    Returns:
        The error [m]; NaN if an entry is not finite.

    Raises:
        EmptyWindow: If there is no load.
    """
    return float(errors.mean(axis=1).max())


mass_worst_orientation = variant(
    mass_worst_position,
    "mass_worst_orientation",
    "orientation error with the worst load",
    quantity=("m", "rad"),
)


@metric(
    unit="kg",
    better="none",
    family="adaptation",
    needs=("errors", "masses"),
    source="load of the smallest mean over motions",
    label="load with the smallest error",
    kind="table",
)
def mass_argmin(errors: np.ndarray, masses: np.ndarray) -> float:
    """Load at which the error, averaged over the motions, is smallest; the first of several.

    Args:
        errors: A row for each load, shape (loads, motions), any unit.
        masses: The loads, shape (loads,) [kg].

    Returns:
        The load [kg]; NaN if an entry is not finite.

    Raises:
        EmptyWindow: If there is no load.
        UnequalLengths: If the arrays hold different numbers of loads.
    """
    return float(masses[errors.mean(axis=1).argmin()])
