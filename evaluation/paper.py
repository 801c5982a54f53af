"""The paper's own arithmetic, recomputed from the means that it prints."""

import math
from dataclasses import dataclass

ROUNDING = 0.06
"""Largest difference of a printed percentage that the rounding of the printed means explains [points]."""
MEAN_SPEED = 0.322
"""Mean speed of the eight paths [m/s]."""
GROUP_SPEEDS = (0.260, 0.426)
"""Mean speed of T1 to T5 and of T6 to T8 [m/s]."""


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """A printed percentage and the two printed means that it should follow from.

    Attributes:
        place: Where it stands.
        ours: Mean of CBMC-V3, in ``unit``.
        theirs: Mean of the factory controller.
        unit: Their unit.
        printed: The printed reduction [%].
    """

    place: str
    ours: float
    theirs: float
    unit: str
    printed: float

    @property
    def recomputed(self) -> float:
        """The reduction that the means give [%]."""
        return 100.0 * (1.0 - self.ours / self.theirs)

    @property
    def agrees(self) -> bool:
        """Whether rounding explains the difference."""
        return abs(self.recomputed - self.printed) <= ROUNDING


def reductions() -> tuple[Reduction, ...]:
    """Return the percentages of section V whose two means are printed."""
    printed = [
        ("Obs. 1, sand, position", 0.01430, 0.01800, "m", 20.6),
        ("Obs. 1, sand, orientation", 0.01489, 0.01694, "rad", 12.1),
        ("Obs. 1, water, position", 0.01442, 0.01779, "m", 18.9),
        ("Obs. 1, water, orientation", 0.01519, 0.01681, "rad", 9.6),
        ("Obs. 2, sand, position", 0.00146, 0.00441, "m", 66.9),
        ("Obs. 2, sand, orientation", 0.00393, 0.00596, "rad", 34.1),
        ("Obs. 2, water, position", 0.00157, 0.00455, "m", 65.5),
        ("Obs. 2, water, orientation", 0.00338, 0.00588, "rad", 39.4),
    ]
    return tuple(
        Reduction(place=place, ours=a, theirs=b, unit=unit, printed=percent) for place, a, b, unit, percent in printed
    )


def water_over_sand() -> dict[str, float]:
    """Return the ratio of the printed means with water and with sand: above 1, water is the harder load."""
    found = {reduction.place: reduction for reduction in reductions()}
    ratios = {}
    for quantity in ("position", "orientation"):
        sand, water = (found[f"Obs. 1, {material}, {quantity}"] for material in ("sand", "water"))
        ratios[f"factory, {quantity}"] = water.theirs / sand.theirs
        ratios[f"CBMC-V3, {quantity}"] = water.ours / sand.ours
    return ratios


def equivalent_lag(error: float, speed: float = MEAN_SPEED) -> float:
    """Return the time lag that alone would make a mean position error.

    Args:
        error: Mean position error [m].
        speed: Mean speed of the path [m/s].

    Returns:
        The lag [s].
    """
    return error / speed


def slow_reduction(overall: float, fast: float, fast_share: float, fast_to_slow: float = math.nan) -> float:
    """Return what a reduction over all paths and one over the fast ones leave for the slow ones.

    Args:
        overall: Reduction over all paths, as a share.
        fast: Reduction over the fast paths, as a share.
        fast_share: Share of the paths that are fast: 3/8 in the text, 5/8 in the caption.
        fast_to_slow: Error of the reference on fast paths over that on slow ones; the ratio of their speeds if NaN.

    Returns:
        The reduction on the slow paths, as a share; negative if they would have become worse.
    """
    ratio = GROUP_SPEEDS[1] / GROUP_SPEEDS[0] if math.isnan(fast_to_slow) else fast_to_slow
    weight = fast_share * ratio + 1.0 - fast_share
    return (overall * weight - fast_share * ratio * fast) / (1.0 - fast_share)
