"""Claims that compare two sides: ratios, ranges, groups of trajectories, cells."""

import math
from collections.abc import Sequence
from itertools import product

import numpy as np

from ..comparison import PRACTICALLY_EQUAL
from ..intervals import Interval, welch_interval
from ..statistics import sign_flip_test
from .book import Claim
from .measures import (
    Pairs,
    by_path,
    expected_cells,
    interval_of,
    log_ratio_of_means,
    log_ratio_of_ranges,
    log_ratios,
    magnitudes,
    pooled,
    range_interval,
    split,
)
from .readings import Evidence, NotEnough, numbers
from .rules import Ruling, cells_rule, effect_rule, interaction_rule, ratio_rule
from .verdict import Measured

Logs = Sequence[float] | np.ndarray
SAME_PATH = (("T6", "T3"), ("T5", "T4"))
"""Pairs of one path at two speeds, the fast one first."""


def ratio(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge by the geometric mean ratio over trajectories."""
    pairs = _pairs(claim, evidence, claim.a[0], claim.b[0], claim.metrics[0])
    logs = np.array(list(log_ratios(pairs).values()))
    interval, mean, of_means = interval_of(logs), float(logs.mean()), log_ratio_of_means(pairs)
    ruling = ratio_rule(
        _side(claim) * mean,
        _signed(claim, interval),
        len(logs),
        _printed(claim),
        averages_agree=mean * of_means >= 0.0,
    )
    notes = (f"ratio of means {math.exp(of_means):.3f}", *_equal(interval), *_coverage(claim, evidence, pairs))
    return ruling, _ratio(mean, interval, logs, notes)


def range_ratio(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge by the ratio of shape ranges, averaged over the groups of trajectories, for these trajectories."""
    pairs = _pairs(claim, evidence, claim.a[0], claim.b[0], claim.metrics[0])
    _need_all_paths(evidence, pairs)
    estimate, interval = range_interval([log_ratio_of_ranges(pairs, _groups(evidence))])
    ruling = effect_rule(_side(claim) * estimate, _signed(claim, interval), _printed(claim))
    measured = Measured(
        value=math.exp(estimate), unit="ratio", interval=interval.exponentiated() if interval else None,
        n=len(pairs), of="pairs of runs", notes=_coverage(claim, evidence, pairs),
    )  # fmt: skip
    return ruling, measured


def interaction(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge by the mean log-ratio of the fast trajectories less that of the slow ones."""
    listed = [log_ratios(_pairs(claim, evidence, claim.a[0], claim.b[0], metric)) for metric in claim.metrics]
    common = {path: float(np.mean([part[path] for part in listed])) for path in listed[0]}
    groups = _groups(evidence)
    fast, slow = ([value for path, value in common.items() if groups[path] == group] for group in ("fast", "slow"))
    if not fast or not slow:
        raise NotEnough("one of the groups of trajectories did not run")
    interval = welch_interval(fast, slow)
    value = math.exp(float(np.mean(fast) - np.mean(slow)))
    notes = tuple(
        f"{a} against {b}, one path: {math.exp(common[a] - common[b]):.3f}"
        for a, b in SAME_PATH
        if a in common and b in common
    )
    measured = Measured(
        value=value, unit="ratio", interval=interval.exponentiated() if interval else None, n=len(common),
        of="trajectories", notes=notes,
    )  # fmt: skip
    return interaction_rule(_signed(claim, interval)), measured


def all_cells(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge by the sign in every cell and the pooled effect over trajectories, of ranges for these trajectories."""
    groups = _groups(evidence)
    effects: dict[str, float] = {}
    parts, ranges, absent = [], [], []
    for metric, a, b in product(claim.metrics, claim.a, claim.b):
        pairs = _pairs(claim, evidence, a, b, metric)
        _need_all_paths(evidence, pairs)
        words = {"metric": metric, "a": a, "b": b}
        before = ", ".join(words[axis] for axis in ("metric", "a", "b") if axis in claim.cells)
        cells = split(pairs, claim, groups)
        absent += [cell for cell in expected_cells(claim, evidence.runs, _order(groups)) if cell not in cells]
        for cell, inside in cells.items():
            effect = log_ratio_of_ranges(inside, groups)[0] if claim.of_range else log_ratio_of_means(inside)
            effects[" ".join(word for word in (before, cell) if word)] = effect
        parts.append(log_ratios(pairs))
        if claim.of_range:
            ranges.append(log_ratio_of_ranges(pairs, groups))
    if absent:
        raise NotEnough(f"missing: {_few(list(dict.fromkeys(absent)))}")
    logs = pooled(parts)
    estimate, interval = range_interval(ranges) if ranges else (float(logs.mean()), interval_of(logs))
    held = {cell: _side(claim) * effect < 0.0 for cell, effect in effects.items()}
    notes = (f"{sum(held.values())} of {len(held)} cells",)
    return cells_rule(held, _signed(claim, interval)), _ratio(estimate, interval, () if ranges else logs, notes)


def joints(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge by the sign of a figure of every joint, and its mean over joints and runs of each trajectory."""
    rows = evidence.of(claim.a[0], claim)
    found = {metric: numbers(rows, metric, claim.window) for metric in claim.metrics}
    lacking = [metric for metric, values in found.items() if not values]
    if lacking:
        raise NotEnough(f"no run of {claim.a[0]} has {_few(lacking)}")
    means = {metric: float(np.mean(list(values.values()))) for metric, values in found.items()}
    over = pooled([by_path(values) for values in found.values()])
    interval = interval_of(over)
    held = {metric: _side(claim) * mean < 0.0 for metric, mean in means.items()}
    measured = Measured(
        value=float(over.mean()), unit="r", interval=interval, n=len(over), of="trajectories",
        test=f"sign flips, p = {sign_flip_test(over):.3g}", notes=(f"{sum(held.values())} of {len(held)} joints",),
    )  # fmt: skip
    return cells_rule(held, _signed(claim, interval)), measured


def _pairs(claim: Claim, evidence: Evidence, a: str, b: str, metric: str) -> Pairs:
    return magnitudes(evidence.pairs(claim, a, b, metric))


def _groups(evidence: Evidence) -> dict[str, str]:
    return {row.trajectory: row.group for row in evidence.rows}


def _order(groups: dict[str, str]) -> list[str]:
    return sorted(set(groups.values()))


def _side(claim: Claim) -> float:
    """Return what makes the claimed side of an effect negative."""
    return -1.0 if claim.higher else 1.0


def _signed(claim: Claim, interval: Interval | None) -> Interval | None:
    if interval is None or not claim.higher:
        return interval
    return Interval(-interval.high, -interval.low, interval.level, interval.method, interval.status)


def _printed(claim: Claim) -> float | None:
    """Return the logarithm of the printed ratio, negative on the claimed side."""
    if claim.printed is None:
        return None
    return _side(claim) * math.log(1.0 - claim.printed / 100.0)


def _ratio(
    mean: float, interval: Interval | None, logs: Sequence[float] | np.ndarray, notes: tuple[str, ...]
) -> Measured:
    test = f"sign flips, p = {sign_flip_test(logs):.3g}" if len(logs) else ""
    shown = interval.exponentiated() if interval else None
    return Measured(
        value=math.exp(mean), unit="ratio", interval=shown, n=len(logs), of="trajectories" if len(logs) else "",
        test=test, notes=notes,
    )  # fmt: skip


def _need_all_paths(evidence: Evidence, pairs: Pairs) -> None:
    """Refuse to speak of every cell or of a range where paths are missing.

    Raises:
        NotEnough: Names them.
    """
    ran = {key[0] for key in pairs}
    absent = [path for path in evidence.runs.trajectories if path not in ran]
    if absent:
        raise NotEnough(f"missing: {_few(absent)}")


def _equal(interval: Interval | None) -> tuple[str, ...]:
    """Say if a whole interval of logarithms lies within what nobody would change a controller for."""
    low, high = (math.log(limit) for limit in PRACTICALLY_EQUAL)
    return ("practically equal",) if interval and low <= interval.low and interval.high <= high else ()


def _coverage(claim: Claim, evidence: Evidence, pairs: Pairs) -> tuple[str, ...]:
    """Say over how many of the set's loads an average was taken, where not all ran."""
    ran = {key[1] for key in pairs}
    masses = [mass for mass in evidence.runs.masses if mass not in ran]
    if not masses or not claim.metrics:
        return ()
    return (f"without {_few([f'{mass:g} kg' for mass in masses])}",)


def _few(names: Sequence[str]) -> str:
    """Return the first of many names."""
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
