"""How well the patterns of a spiking cerebellum know gravity, on motions that training did not see."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...scenarios.store import StoredRun
from .numbers import significant
from .table import Cell, Column, Table
from .worlds import SPIKING, World

Errors = Mapping[str, Mapping[float, float]]
"""Motion to load of a pattern [kg] to the error of its torque relative to gravity."""

GravityOf = Callable[[StoredRun], Errors | None]
"""Takes a run to the errors of its controller's patterns, None if it has none."""

GRAVITY = "gravity_torque_nrmse"


def no_gravity(run: StoredRun) -> None:
    """Know of no patterns."""


@dataclass(frozen=True, kw_only=True)
class GravityErrors:
    """Errors of the patterns of one controller.

    Attributes:
        controller: Its label.
        errors: Motion to load of a pattern [kg] to its error.
    """

    controller: str
    errors: Errors


def gravity_errors(world: World, gravity_of: GravityOf) -> GravityErrors | None:
    """Return how well the spiking controller of a world knows gravity; None if it did not run or has no patterns.

    Its ablations and null controls have the same patterns.

    Args:
        world: The world.
        gravity_of: Knows the patterns; asked with one run.
    """
    run = next((run for run in world.runs if run.stored.specification.controller == SPIKING), None)
    errors = None if run is None else gravity_of(run.stored)
    return None if run is None or not errors else GravityErrors(controller=run.row.controller, errors=errors)


def gravity_table(world: World, known: GravityErrors) -> Table:
    """Return a row for each motion, a column for each pattern."""
    loads = sorted({load for errors in known.errors.values() for load in errors})
    rows = [
        (Cell(motion, kind="head"), *(_share(errors.get(load)) for load in loads))
        for motion, errors in known.errors.items()
    ]
    return Table(
        id=f"{world.id}-gravity",
        caption=f"{known.controller}: error of each pattern's torque, of the gravity torque of its load",
        columns=[Column("Motion", numeric=False), *(Column(f"{load:g} kg beyond the gripper", "%") for load in loads)],
        rows=rows,
    )


def _share(error: float | None) -> Cell:
    return Cell("none", kind="missing") if error is None else Cell(significant(100.0 * error, 2), 100.0 * error)
