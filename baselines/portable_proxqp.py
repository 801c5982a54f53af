"""ProxQP in the build that gives the same bits in every process and on every x86-64 processor.

proxsuite loads the widest vector instructions that a processor has. Their sums begin where the memory that the solver
happened to get is aligned, so one program has two answers that differ in their last digits, and by its place in memory
a run has one or the other; a processor without these instructions has a third. The build without them has one answer
everywhere, and takes no longer for programs of a few dozen unknowns. Where somebody has loaded proxsuite before, that
build stays: a process cannot hold two.
"""

import sys
from types import ModuleType

CHOICE = "proxsuite.instructionset"
"""What proxsuite asks which instructions there are."""


def _load() -> ModuleType:
    """Return proxsuite's solver, loaded as on a processor without vector instructions."""
    plain = ModuleType(CHOICE)
    plain.has_AVX512F = plain.has_AVX2 = lambda: False  # type: ignore[attr-defined]
    if "proxsuite" not in sys.modules:
        sys.modules[CHOICE] = plain
    try:
        from proxsuite import proxqp
    finally:
        if sys.modules.get(CHOICE) is plain:
            del sys.modules[CHOICE]
    return proxqp  # type: ignore[no-any-return]


proxqp = _load()
