"""Estimates that claims are judged by: ratios of means and of ranges, cell by cell, and slopes over the load."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product

import numpy as np

from ..intervals import Interval, suite_interval, t_interval
from ..pairing import Ratios
from ..rows import Key
from .book import Claim, RunSet
from .readings import NotEnough

Pairs = Mapping[Key, tuple[float, float]]


def magnitudes(readings: Mapping[Key, tuple[object, object]]) -> Pairs:
    """Return the pairs of magnitudes, see :meth:`.Ratios.of`."""
    return Ratios.of(readings).pairs  # type: ignore[arg-type]


def log_ratios(pairs: Pairs) -> dict[str, float]:
    """Return the mean log-ratio of each trajectory."""
    return dict(zip(dict.fromkeys(key[0] for key in pairs), Ratios(pairs).by_trajectory().tolist(), strict=True))


def pooled(parts: Sequence[Mapping[str, float]]) -> np.ndarray:
    """Return the mean over parts for each trajectory that all of them have, shape (n,)."""
    common = [path for path in parts[0] if all(path in part for part in parts)]
    return np.array([np.mean([part[path] for part in parts]) for path in common])


def log_ratio_of_means(pairs: Pairs) -> float:
    """Return the logarithm of mean over mean of the cells."""
    ratios = Ratios(pairs)
    return math.log(float(np.mean(ratios.cell_means(0))) / float(np.mean(ratios.cell_means(1))))


def log_ratio_of_ranges(pairs: Pairs, groups: Mapping[str, str]) -> tuple[float, dict[Key, float]]:
    """Return the logarithm of a ratio of shape ranges, and what each repetition adds to it.

    A range is the largest less the smallest path mean of a group at one load, averaged over loads and groups. The two
    extreme paths are taken as given, and the ratio is linearised around the means: each repetition then adds its part,
    and repetitions stay paired.

    Args:
        pairs: Magnitudes of both sides.
        groups: Trajectory to its group.

    Returns:
        The logarithm; key to the part of that repetition, which averages to zero over all of them together.

    Raises:
        NotEnough: If a side does not depend on the path.
    """
    cells: dict[tuple[str, float, str], dict[str, list[Key]]] = {}
    for key in pairs:
        cells.setdefault((groups[key[0]], key[1], key[2]), {}).setdefault(key[0], []).append(key)
    ranges, parts = np.zeros(2), (dict[Key, float](), dict[Key, float]())
    for side, paths in product((0, 1), cells.values()):
        means = {path: float(np.mean([pairs[key][side] for key in keys])) for path, keys in paths.items()}
        for path, sign in ((max(means, key=means.__getitem__), 1.0), (min(means, key=means.__getitem__), -1.0)):
            ranges[side] += sign * means[path] / len(cells)
            for key in paths[path]:
                parts[side][key] = parts[side].get(key, 0.0) + sign * pairs[key][side] / len(cells)
    if not (ranges > 0.0).all():
        raise NotEnough("one trajectory in each group has no range")
    ends = parts[0].keys() | parts[1].keys()
    added = {k: parts[0].get(k, 0.0) / ranges[0] - parts[1].get(k, 0.0) / ranges[1] for k in pairs if k in ends}
    return float(np.log(ranges[0] / ranges[1])), added


def range_interval(found: Sequence[tuple[float, Mapping[Key, float]]]) -> tuple[float, Interval | None]:
    """Return the mean of logarithms of ratios of ranges, with its interval for these trajectories.

    Args:
        found: Results of :func:`log_ratio_of_ranges`.
    """
    estimate = float(np.mean([value for value, _ in found]))
    cells: dict[tuple[int, object], list[float]] = {}
    for place, (_, added) in enumerate(found):
        for key, part in added.items():
            cells.setdefault((place, key[:3]), []).append(part)
    interval = suite_interval(list(cells.values()), [1.0 / len(found)] * len(cells))
    if interval is None:
        return estimate, None
    half = (interval.high - interval.low) / 2.0
    return estimate, Interval(estimate - half, estimate + half, interval.level, "suite", interval.status)


def split(pairs: Pairs, claim: Claim, groups: Mapping[str, str]) -> dict[str, dict[Key, tuple[float, float]]]:
    """Return the pairs of each cell of a claim; a load without content belongs to every material.

    Args:
        pairs: Magnitudes of both sides.
        claim: The claim with its axes.
        groups: Trajectory to its group.
    """
    apart = "material" in claim.cells and "mass" not in claim.cells
    materials = sorted({key[2] for key in pairs if key[2]})
    found: dict[str, dict[Key, tuple[float, float]]] = {}
    for key, pair in pairs.items():
        shared = materials if apart and not key[2] else [key[2]]
        for material in shared:
            found.setdefault(_cell(claim, groups[key[0]], key[1], material), {})[key] = pair
    return found


def expected_cells(claim: Claim, runs: RunSet, groups: Iterable[str]) -> list[str]:
    """Return the cells that a claim needs, metrics and controllers apart."""
    wanted = [m for m in runs.materials if claim.material in ("", m)]
    loads = [(mass, "") if mass == runs.masses[0] else (mass, m) for mass in runs.masses for m in wanted]
    if "material" in claim.cells and "mass" not in claim.cells:
        loads = [(0.0, m) for m in wanted]
    alike = loads or [(0.0, "")]
    return list(dict.fromkeys(_cell(claim, group, *load) for group in groups for load in alike))


def _cell(claim: Claim, group: str, mass: float, material: str) -> str:
    words = {"group": group, "mass": f"{mass:g} kg", "material": material}
    return " ".join(word for axis, word in words.items() if axis in claim.cells and word)


def slopes(values: Mapping[Key, float]) -> dict[str, float]:
    """Return the least-squares slope over the load of each trajectory, over the means at each load.

    Raises:
        NotEnough: If a trajectory ran with fewer than three loads.
    """
    paths: dict[str, dict[float, list[float]]] = {}
    for key, value in values.items():
        paths.setdefault(key[0], {}).setdefault(key[1], []).append(value)
    few = [path for path, loads in paths.items() if len(loads) < 3]
    if few:
        raise NotEnough(f"fewer than three loads on {', '.join(few)}")
    return {path: _slope(np.array(list(loads)), loads.values()) for path, loads in paths.items()}


def _slope(masses: np.ndarray, values: Iterable[Sequence[float]]) -> float:
    spread = masses - masses.mean()
    return float(spread @ np.array([np.mean(v) for v in values]) / (spread @ spread))


def by_path(values: Mapping[Key, float]) -> dict[str, float]:
    """Return the mean of each trajectory."""
    paths: dict[str, list[float]] = {}
    for key, value in values.items():
        paths.setdefault(key[0], []).append(value)
    return {path: float(np.mean(found)) for path, found in paths.items()}


def mean_over(values: Mapping[Key, float], label: Callable[[Key], float]) -> dict[float, float]:
    """Return the mean of the values that share a label."""
    found: dict[float, list[float]] = {}
    for key, value in values.items():
        found.setdefault(label(key), []).append(value)
    return {name: float(np.mean(parts)) for name, parts in sorted(found.items())}


def interval_of(values: Sequence[float] | np.ndarray) -> Interval | None:
    """Return the t interval over trajectories; None for a single one."""
    return t_interval(values) if len(values) > 1 else None
