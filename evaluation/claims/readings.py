"""What claims read from runs beside the metrics: figures of a run that a metric of several runs is made of."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..metrics import METRICS
from ..rows import Key, Reading, RunRow, read, runs_by_key
from .book import Claim, RunSet

READINGS = {
    "heavy_weight": "thalamus_weight_slope",
    **{f"gain_correlation_j{joint}": "gain_correlation" for joint in range(1, 8)},
}
"""Figure of a run to the metric that it is a part of."""
EVENT = "event@"


class NotEnough(Exception):
    """What a claim lacks to be decided, in words."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """The runs of one set.

    Attributes:
        runs: The set.
        rows: Its runs; figures of :data:`READINGS` and of curves stand among their metrics.
        gains: Controller to stiffness and damping of each run at its updates, and the updates of one lap.
    """

    runs: RunSet
    rows: Sequence[RunRow]
    gains: Mapping[str, Sequence[tuple[np.ndarray, np.ndarray, int]]] = field(default_factory=dict)

    def of(self, controller: str, claim: Claim, material: str = "") -> dict[Key, RunRow]:
        """Return the runs of a controller that a claim is about, refused ones left out.

        Args:
            controller: Its label.
            claim: The claim.
            material: Content that the runs must have; else that of the claim, which loads without any belong to.

        Raises:
            NotEnough: If there is none.
        """
        fitting = [
            row
            for row in self.rows
            if row.status != "refused"
            and (row.material == material if material else not claim.material or row.material in ("", claim.material))
            and claim.only in ("", row.group)
        ]
        found = runs_by_key(fitting, controller)
        # A load without content belongs to every material, but alone it says nothing of any.
        if not found or (claim.material and all(row.material != claim.material for row in found.values())):
            what = ", ".join(word for word in (material or claim.material, claim.only) if word)
            raise NotEnough(f"no run of {controller} {f'with {what} ' if what else ''}in {self.runs.id}")
        return found

    def pairs(self, claim: Claim, a: str, b: str, metric: str) -> dict[Key, tuple[Reading, Reading]]:
        """Return one metric of both sides by cell and repetition; a material that is compared is no part of the cell.

        Raises:
            NotEnough: If a side has no run, or no run has the metric on both.
        """
        ours, theirs = (self._side(claim, label, side, metric) for label, side in ((a, claim.a_is), (b, claim.b_is)))
        both = {key: (ours[key], theirs[key]) for key in ours if key in theirs}
        able = {key: pair for key, pair in both.items() if all(side.magnitude is not None for side in pair)}
        if not able:
            raise NotEnough(f"no pair of runs of {a} and {b} has a value of {metric}")
        return able

    def _side(self, claim: Claim, controller: str, side: str, metric: str) -> dict[Key, Reading]:
        window = side if side.startswith(EVENT) else claim.window
        material = "" if side.startswith(EVENT) else side
        rows = self.of(controller, claim, material)
        return {
            (key[0], key[1], "" if material else key[2], key[3]): reading(row, metric, window)
            for key, row in rows.items()
        }


def reading(row: RunRow, metric: str, window: str) -> Reading:
    """Return the magnitude of a metric or of a figure of :data:`READINGS`."""
    if metric in METRICS:
        return read(row, METRICS[metric], window)
    value = number(row, metric, window)
    return Reading(None if value is None else abs(value), "missing" if value is None else "ok")


def number(row: RunRow, metric: str, window: str) -> float | None:
    """Return a value with its sign, infinite for what never came; None for a failed run or without a value."""
    entry = row.metrics.get(window, {}).get(metric) if row.status == "ok" else None
    if entry is None:
        return None
    value = entry.get("value")
    if entry.get("status") == "censored" and (value is None or math.isinf(value)):
        return math.inf
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def numbers(rows: Mapping[Key, RunRow], metric: str, window: str) -> dict[Key, float]:
    """Return the values of all runs that have one."""
    found = {key: number(row, metric, window) for key, row in rows.items()}
    return {key: value for key, value in found.items() if value is not None}
