"""Which runs of a store are meant: by controller, knowledge, motion and load, in the words of the page."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .controllers import InvalidInput, UnknownName
from .evaluation.motion_sets import MOTION_SETS
from .evaluation.report.worlds import Run, World, told_apart

NO_MATERIAL = "none"
"""What stands for the material of an empty container."""


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Conditions on runs; an empty one lets every run pass.

    Attributes:
        controller: Label of the page, or name or door of the controller.
        knowledge: Its knowledge level.
        trajectories: Names of motions.
        motions: Name of a set of motions, see :data:`~.evaluation.motion_sets.MOTION_SETS`.
        mass: Mass beyond the flange at the start, gripper included [kg].
        material: Material at the start, ``none`` for an empty container.
    """

    controller: str = ""
    knowledge: str = ""
    trajectories: tuple[str, ...] = ()
    motions: str = ""
    mass: float | None = None
    material: str = ""

    def of(self, runs: Sequence[Run]) -> list[Run]:
        """Return the runs that are meant.

        Args:
            runs: Runs of any worlds.

        Raises:
            UnknownName: If none of them has a name that is asked for; it says the nearest.
            InvalidInput: If every name is known, but no run has them all.
        """
        found = list(runs)
        for kind, wanted, read in self._conditions():
            missing = [name for name in wanted if not any(name in read(run) for run in runs)]
            if missing:
                known = sorted({name for run in runs for name in read(run)})
                raise UnknownName(f"{kind} in this store", missing[0], known)
            found = [run for run in found if any(name in read(run) for name in wanted)]
        if not found:
            raise InvalidInput(f"no run has {self}", "store", "leave out one of the conditions")
        return found

    def __str__(self) -> str:
        """Return the conditions in words."""
        words = [f"{kind} {' or '.join(wanted)}" for kind, wanted, _ in self._conditions()]
        return ", ".join(words) or "any run"

    def _conditions(self) -> list[tuple[str, tuple[str, ...], Callable[[Run], Sequence[str]]]]:
        """Return kind, wanted names and how a run's own are read, for each condition that is set."""
        if self.motions and self.motions not in MOTION_SETS:
            raise UnknownName("set of motions", self.motions, tuple(MOTION_SETS))
        mass = "" if self.mass is None else f"{self.mass:g}"
        single: list[tuple[str, str, Callable[[Run], Sequence[str]]]] = [
            ("controller", self.controller, _names),
            ("knowledge level", self.knowledge, lambda run: (run.stored.specification.knowledge,)),
            ("mass", mass, lambda run: (f"{run.row.mass:g}",)),
            ("material", self.material, lambda run: (run.row.material or NO_MATERIAL,)),
        ]
        named = [(kind, (name,), read) for kind, name, read in single if name]
        paths = [("trajectory", self.trajectories, _trajectory)] if self.trajectories else []
        # A part of a set is enough: a benchmark of three of its motions still has runs in it.
        sets = [("set of motions", (self.motions,), _sets)] if self.motions else []
        return [*named, *paths, *sets]


def one_world(worlds: Sequence[World], name: str, selection: Selection) -> tuple[World, list[Run]]:
    """Return the world that is meant and its selected runs.

    Args:
        worlds: All worlds of a store.
        name: Id of a world on the page, empty if only one is in question.
        selection: Which of its runs.

    Raises:
        UnknownName: If there is no such world, or it does not know a name.
        InvalidInput: If several worlds have such runs.
    """
    ids = [world.id for world in worlds]
    if name and name not in ids:
        raise UnknownName("world", name, ids)
    chosen = {id(run.stored) for run in selection.of([run for world in worlds for run in world.runs])}
    able = [
        (world, runs)
        for world in worlds
        if name in ("", world.id) and (runs := [run for run in world.runs if id(run.stored) in chosen])
    ]
    if len(able) > 1:
        named = "; ".join(f"--world {world.id}: {told_apart(world, worlds)}" for world, _ in able)
        raise InvalidInput(f"runs of {len(able)} worlds", str(selection), f"name one, {named}")
    if not able:
        raise InvalidInput(f"no run has {selection}", f"world {name}", "leave out one of the conditions")
    return able[0]


def one_label(runs: Sequence[Run], selection: Selection) -> str:
    """Return the controller of runs as the page calls it.

    Raises:
        InvalidInput: If they belong to several.
    """
    labels = sorted({run.row.controller for run in runs})
    if len(labels) > 1:
        valid = f"name one of {', '.join(repr(label) for label in labels)}"
        raise InvalidInput(f"runs of {len(labels)} controllers", str(selection), valid)
    return labels[0]


def _names(run: Run) -> Sequence[str]:
    name = run.stored.specification.controller
    return (run.row.controller, name, name.rpartition(":")[2])


def _trajectory(run: Run) -> Sequence[str]:
    return (run.row.trajectory,)


def _sets(run: Run) -> Sequence[str]:
    return tuple(name for name, motions in MOTION_SETS.items() if run.row.trajectory in motions)
