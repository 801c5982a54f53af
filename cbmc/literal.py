"""The paper's equations as printed wherever they can be computed; most runs fail, and are shown failing."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..controllers import InvalidInput, LedgerEntry, Task
from .controller import CbmcV3
from .guard import Caps
from .learning import ConstantGradient, Rule, TorquePenalty
from .spinal_cord import SpinalCordTable

LEARNING = ("autograd", "constant_gradient", "none")


@dataclass(kw_only=True)
class CbmcV3Literal(CbmcV3):
    """CBMC-V3 as printed: the raw spike sum, no bounds on the gains, a cold start.

    On an arm with rotor inertia its bang-bang torque can track best of all: read it beside saturation and chatter.

    Attributes:
        literal_learning: ``"autograd"``, what the printed losses leave when differentiated through the graph that
            exists; ``"constant_gradient"``, the printed losses with a sensitivity of one in place of the plant;
            ``"none"``.
    """

    start: str = "cold"
    stiffness_range: tuple[float, float] = (-1e300, 1e300)
    damping_range: tuple[float, float] = (-1e300, 1e300)
    literal_learning: str = "autograd"

    def __post_init__(self) -> None:
        """Check what needs no robot."""
        super().__post_init__()
        if self.literal_learning not in LEARNING:
            what, where = f"literal_learning = {self.literal_learning!r}", "setting 'literal_learning'"
            raise InvalidInput(what, where, f"one of {', '.join(LEARNING)}")

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from; what this form prints differently says so."""
        inherited = {entry.setting: entry for entry in super().ledger()}
        # The printed losses have no sensitivity in them.
        del inherited["sensitivity"]
        learning = LedgerEntry(
            setting="literal_learning", value=self.literal_learning, source="chosen", note="how the losses are read"
        )
        sums = replace(inherited["spike gain"], value=1.0, source="published", note="the raw sum, as printed")
        free = {
            name: replace(inherited[name], source="published", note="the paper prints no bounds")
            for name in ("stiffness_range", "damping_range", "gain caps")
        }
        return tuple((inherited | free | {"spike gain": sums, "literal_learning": learning}).values())

    def _caps(self, task: Task) -> Caps:
        free = np.full(task.robot.n, np.inf)
        return Caps(limit=free, stiffness=free, damping=free)

    def _spinal_table(self) -> SpinalCordTable:
        return SpinalCordTable(spike_gain=1.0)

    def _rule(self) -> Rule | None:
        rules: dict[str, Rule | None] = {
            "autograd": TorquePenalty(),
            "constant_gradient": ConstantGradient(),
            "none": None,
        }
        return rules[self.literal_learning]
