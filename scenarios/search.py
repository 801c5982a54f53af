"""Where a response first fails: rungs over the whole range, then bisection below the first that fails."""

from collections.abc import Callable
from dataclasses import dataclass

RUNGS = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0)
"""Shares of a grid that are always tried, so that a response that recovers further out is seen."""


@dataclass(frozen=True, kw_only=True)
class Found:
    """What a search saw.

    Attributes:
        passed: Last step before the first failure; None if step 0 fails.
        failed: The first failure; None if no step that was tried failed.
        monotone: Whether nothing passed beyond the first failure.
        probes: Steps in the order in which they were tried, each with whether it passed.
    """

    passed: int | None
    failed: int | None
    monotone: bool
    probes: tuple[tuple[int, bool], ...]


def search(passes: Callable[[int], bool], last: int) -> Found:
    """Return the first failure, to one step below the first rung that fails; a gap between two rungs may hide another.

    Args:
        passes: Tries a step; called once for each.
        last: The last step, at least 1.
    """
    seen: dict[int, bool] = {}

    def probe(step: int) -> bool:
        if step not in seen:
            seen[step] = bool(passes(step))
        return seen[step]

    if probe(0):
        for share in RUNGS:
            probe(max(1, round(share * last)))
    failed = min((step for step, passed in seen.items() if not passed), default=None)
    passed = max((step for step in seen if failed is None or step < failed), default=None)
    while passed is not None and failed is not None and failed - passed > 1:
        middle = (passed + failed) // 2
        passed, failed = (middle, failed) if probe(middle) else (passed, middle)
    beyond = any(passed for step, passed in seen.items() if failed is not None and step > failed)
    return Found(passed=passed, failed=failed, monotone=not beyond, probes=tuple(seen.items()))
