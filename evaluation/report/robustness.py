"""Robustness of the controllers of a world: margins by bisection, and margins of measured loops."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .findings import Findings
from .numbers import counting
from .worlds import Run

MARGIN, LOOPS, LOOP = "margin", "loops", "loop "
"""Windows: of a margin by bisection, of all loops together, and the beginning of that of one joint's loop."""

Entry = Mapping[str, object]
"""A stored metric: value, unit, status, number of samples; of a margin also what its search noted."""


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """The margins of one world.

    Attributes:
        order: Controllers as tables list them.
        margins: By controller and trajectory, margin id to its entry.
        loops: By controller, window to metric id to entry.
        without: What could not be measured.
    """

    order: Sequence[str]
    margins: Mapping[tuple[str, str], Mapping[str, Entry]]
    loops: Mapping[str, Mapping[str, Mapping[str, Entry]]]
    without: Sequence[Run]


def robustness_of(findings: Findings) -> Robustness | None:
    """Return the margins of a world, None if nobody measured any.

    Args:
        findings: The world's findings.
    """
    studies = findings.world.studies
    if not studies:
        return None
    known = list(findings.order)
    order = [*known, *dict.fromkeys(run.row.controller for run in studies if run.row.controller not in known)]
    margins: dict[tuple[str, str], dict[str, Entry]] = {}
    loops: dict[str, Mapping[str, Mapping[str, Entry]]] = {}
    for run in sorted(studies, key=lambda run: (order.index(run.row.controller), counting(run.row.trajectory))):
        if MARGIN in run.row.metrics:
            margins.setdefault((run.row.controller, run.row.trajectory), {}).update(_margins(run))
        elif LOOPS in run.row.metrics:
            loops[run.row.controller] = run.row.metrics
    without = [run for run in studies if run.row.status != "ok"]
    return Robustness(order=order, margins=margins, loops=loops, without=without)


def joint_windows(windows: Mapping[str, object]) -> list[str]:
    """Return the windows of single joints, in the order of the joints."""
    return sorted((name for name in windows if name.startswith(LOOP)), key=lambda name: int(name.removeprefix(LOOP)))


def _margins(run: Run) -> dict[str, Entry]:
    """Return the margins of a row with what the search noted; a failed run has none."""
    notes = {name: run.stored.result.provenance.get(name) for name in ("resolution", "monotone", "first_failure")}
    return {name: {**entry, **notes, "anchor": run.anchor} for name, entry in run.row.metrics[MARGIN].items()}
