"""Named sets of motions, so that a statement says over which it holds: the paper's eight, sixteen new ones, all."""

from collections.abc import Iterable, Sequence

from .errors import UnknownMotionSet
from .rows import RunRow

PAPER, FURTHER, EXTENDED = "paper", "further", "extended"

MOTION_SETS: dict[str, tuple[str, ...]] = {
    PAPER: tuple(f"T{number}" for number in range(1, 9)),
    FURTHER: tuple(f"M{number}" for number in range(1, 17)),
}
"""Trajectories by set. The sixteen were drawn by a rule, and nothing was fitted on them."""

MOTION_SETS[EXTENDED] = (*MOTION_SETS[PAPER], *MOTION_SETS[FURTHER])

TITLES = {PAPER: "T1 to T8", FURTHER: "M1 to M16", EXTENDED: "all 24 motions"}


def rows_in(rows: Iterable[RunRow], name: str) -> list[RunRow]:
    """Return the runs on the motions of a set, as comparisons take them.

    Args:
        rows: Runs on any motions.
        name: ``"paper"``, ``"further"`` or ``"extended"``.

    Raises:
        UnknownMotionSet: If there is no such set.
    """
    if name not in MOTION_SETS:
        raise UnknownMotionSet(name, tuple(MOTION_SETS))
    wanted = set(MOTION_SETS[name])
    return [row for row in rows if row.trajectory in wanted]


def sets_in(rows: Sequence[RunRow]) -> tuple[str, ...]:
    """Return the sets that runs have to be split by: all three if there are old and new motions, else none."""
    mixed = all(rows_in(rows, name) for name in (PAPER, FURTHER))
    return tuple(MOTION_SETS) if mixed else ()
