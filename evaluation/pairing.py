"""Paired values of two controllers and their log-ratios, cell by cell and trajectory by trajectory."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .intervals import Interval, suite_bootstrap, suite_interval
from .rows import Cell, Key, Reading

FLOOR = 1e-9
"""Smallest magnitude in a ratio; a zero has no logarithm."""


@dataclass(frozen=True)
class Ratios:
    """The pairs of runs that have a ratio.

    Attributes:
        pairs: Magnitude of the controller and of the reference, by cell and repetition.
    """

    pairs: Mapping[Key, tuple[float, float]]

    @classmethod
    def of(cls, readings: Mapping[Key, tuple[Reading, Reading]]) -> "Ratios":
        """Take the pairs in which both sides have a magnitude.

        Args:
            readings: Reading of the controller and of the reference, by cell and repetition.
        """
        magnitudes = {key: (a.magnitude, b.magnitude) for key, (a, b) in readings.items()}
        return cls({key: (a, b) for key, (a, b) in magnitudes.items() if a is not None and b is not None})

    def by_trajectory(self) -> np.ndarray:
        """Return each trajectory's mean log-ratio: over its cells, of the mean over repetitions, shape (n,)."""
        logs, paths = self._logs(), self._paths()
        return np.array([np.mean([np.mean(logs[cell]) for cell in cells]) for cells in paths.values()])

    def suite_interval(self) -> Interval | None:
        """Return the interval over repetitions of the same mean, as a ratio; None without repetitions."""
        interval = suite_interval(*self._weighted_cells())
        return interval.exponentiated() if interval else None

    def suite_bootstrap(self) -> Interval | None:
        """Return the bootstrap interval beside :meth:`suite_interval`."""
        interval = suite_bootstrap(*self._weighted_cells())
        return interval.exponentiated() if interval else None

    def cell_means(self, side: Literal[0, 1]) -> list[float]:
        """Return the mean magnitude of each cell.

        Args:
            side: 0 for the controller, 1 for the reference.
        """
        cells: dict[Cell, list[float]] = {}
        for key, pair in self.pairs.items():
            cells.setdefault(key[:3], []).append(pair[side])
        return [float(np.mean(values)) for values in cells.values()]

    def differences_by_trajectory(self) -> np.ndarray:
        """Return each trajectory's mean of controller less reference over its cells, shape (n,) [the metric's unit]."""
        cells = self._cells(lambda a, b: a - b)
        return np.array([np.mean([np.mean(cells[cell]) for cell in path]) for path in self._paths().values()])

    def _weighted_cells(self) -> tuple[list[list[float]], list[float]]:
        """Return each cell's log-ratios and its weight in the mean over trajectories."""
        logs, paths = self._logs(), self._paths()
        return list(logs.values()), [1.0 / (len(paths) * len(paths[cell[0]])) for cell in logs]

    def _logs(self) -> dict[Cell, list[float]]:
        """Return the log-ratios of each cell's repetitions."""
        return self._cells(lambda a, b: math.log(max(a, FLOOR) / max(b, FLOOR)))

    def _cells(self, value: Callable[[float, float], float]) -> dict[Cell, list[float]]:
        """Return what is computed of both sides, for each cell's repetitions."""
        cells: dict[Cell, list[float]] = {}
        for key, (a, b) in self.pairs.items():
            cells.setdefault(key[:3], []).append(value(a, b))
        return cells

    def _paths(self) -> dict[str, list[Cell]]:
        """Return the cells of each trajectory."""
        paths: dict[str, list[Cell]] = {}
        for cell in dict.fromkeys(key[:3] for key in self.pairs):
            paths.setdefault(cell[0], []).append(cell)
        return paths
