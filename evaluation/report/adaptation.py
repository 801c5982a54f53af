"""How the error of each controller depends on motion, speed and load: metrics of whole grids of mean errors."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..metrics import METRICS
from ..motion_sets import PAPER, rows_in
from ..rows import RunRow, read
from .findings import ORIENTATION, POSITION, WINDOW
from .numbers import counting

ENDINGS = {POSITION: "position", ORIENTATION: "orientation"}
"""Base metric to the end of the ids that have its unit."""
SPEEDS = (("T3", "T6", 2.0), ("T4", "T5", 4.0 / 3.0))
"""One path at two speeds: the slower motion, the faster, and the ratio of their speeds."""
SLOW, FAST = "slow", "fast"

Load = tuple[float, str]
"""Mass [kg] and content."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Mean errors of one controller in every cell of a grid.

    Attributes:
        errors: A row for each load, shape (loads, motions), in the base metric's unit.
        repeats: Errors of each cell's repetitions, shape (cells, repetitions); None where their number differs.
        loads: The loads, in the order of their masses.
        groups: Motion to its speed group, in the order of the columns.
    """

    errors: np.ndarray
    repeats: np.ndarray | None
    loads: tuple[Load, ...]
    groups: Mapping[str, str]

    def of(self, group: str) -> np.ndarray:
        """Return the columns of a speed group, shape (loads, motions)."""
        return self.errors[:, [found == group for found in self.groups.values()]]

    def at(self, motion: str) -> float:
        """Return a motion's mean over the loads."""
        return float(self.errors[:, list(self.groups).index(motion)].mean())


def compared_rows(rows: Sequence[RunRow]) -> list[RunRow]:
    """Return the runs on one set of motions with one content; empty if they are no grid to speak of.

    Of several sets of motions the paper's is taken, of several contents the one with most cells; the empty container
    belongs to every content. A grid has two loads at least, and slow and fast motions.

    Args:
        rows: Runs of one world.
    """
    chosen = rows_in(rows, PAPER) or list(rows)
    counted = Counter(material for _, _, material in {row.cell for row in chosen} if material)
    main = min(counted, key=lambda name: (-counted[name], name)) if counted else ""
    kept = [row for row in chosen if row.material in ("", main)]
    loads = {(row.mass, row.material) for row in kept}
    return kept if len(loads) > 1 and {row.group for row in kept} == {SLOW, FAST} else []


def adaptation_values(grid: Grid, base: str) -> dict[str, float]:
    """Return the value of every metric of a grid by id, in the order of the columns.

    Args:
        grid: The grid.
        base: Id of the metric that its errors are of.
    """
    end, masses = ENDINGS[base], np.array([mass for mass, _ in grid.loads])
    groups = {"slow": grid.of(SLOW), "fast": grid.of(FAST)}
    pairs = [pair for pair in SPEEDS if pair[0] in grid.groups and pair[1] in grid.groups]
    fields: dict[str, Mapping[str, object]] = {
        f"shape_range_{end}": groups,
        "shape_range_rel": groups,
        "shape_cv": {"errors": grid.errors},
        "speed_group_ratio": groups,
        f"mass_slope_{end}": {"errors": grid.errors, "masses": masses},
        "mass_slope_log": {"errors": grid.errors, "masses": masses},
        f"mass_range_{end}": {"errors": grid.errors},
        f"mass_worst_{end}": {"errors": grid.errors},
        "mass_argmin": {"errors": grid.errors, "masses": masses},
        f"worst_case_{end}": {"errors": grid.errors},
        "worst_to_mean": {"errors": grid.errors},
    }
    if pairs:
        fields["speed_exponent"] = {
            "slower": np.array([grid.at(slower) for slower, _, _ in pairs]),
            "faster": np.array([grid.at(faster) for _, faster, _ in pairs]),
            "speed_ratios": np.array([ratio for _, _, ratio in pairs]),
        }
    if grid.repeats is not None and grid.repeats.shape[1] > 1:
        fields[f"repeat_range_{end}"] = {"repeats": grid.repeats}
    return {name: METRICS[name].value_of(given).value for name, given in fields.items()}


def grids_of(rows: Sequence[RunRow], controllers: Sequence[str], base: str) -> dict[str, Grid | str]:
    """Return the grid of each controller over the cells of all, or why it has none.

    Args:
        rows: Runs of all controllers, one content.
        controllers: Their labels.
        base: Id of the metric.
    """
    groups = {row.trajectory: row.group for row in sorted(rows, key=lambda row: counting(row.trajectory))}
    loads = tuple(sorted({(row.mass, row.material) for row in rows}))
    own: dict[str, list[RunRow]] = {}
    for row in rows:
        own.setdefault(row.controller, []).append(row)
    return {label: _grid(own.get(label, ()), groups, loads, base) for label in controllers}


def _grid(rows: Sequence[RunRow], groups: Mapping[str, str], loads: tuple[Load, ...], base: str) -> Grid | str:
    """Return the grid of one controller, or why it has none."""
    cells: dict[tuple[str, Load], list[float]] = {}
    for row in rows:
        if row.status != "refused":
            found = read(row, METRICS[base], WINDOW)
            if found.status == "failed":
                return "a run failed"
            if found.magnitude is not None:
                cells.setdefault((row.trajectory, (row.mass, row.material)), []).append(found.magnitude)
    wanted = [(motion, load) for load in loads for motion in groups]
    if any(cell not in cells for cell in wanted):
        return "grid with gaps"
    errors = np.array([np.mean(cells[cell]) for cell in wanted]).reshape(len(loads), len(groups))
    listed = [cells[cell] for cell in wanted]
    alike = len({len(values) for values in listed}) == 1
    return Grid(errors=errors, repeats=np.array(listed) if alike else None, loads=loads, groups=groups)
