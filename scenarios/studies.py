"""What every study needs: runs played one after the other, judged by those who know metrics, and one row for all."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .log import RunLog
from .result import RunResult
from .specification import RunSpecification
from .trial import Trial
from .world import World

Prepare = Callable[[World], None]
"""Changes a world before its run."""

Metrics = Mapping[str, Mapping[str, Mapping[str, object]]]


class Play(Protocol):
    """Runs a specification with a controller of its own."""

    def __call__(self, probed: RunSpecification, prepare: Prepare | None = None) -> Trial:
        """Return the trial of an ordinary run."""
        ...


@dataclass(frozen=True, kw_only=True)
class LoopRecords:
    """Records of a posture held while a torque is injected at one joint after the other.

    Attributes:
        commands: What acted after the limiter less what was injected, one block for each joint, shape
            (n, periods, samples, n) [N m].
        injection: What was added to the command of the block's joint, one period, shape (n, samples) [N m].
        lines: Cycles within the period at which something was injected, shape (F,).
        period: Time between samples [s].
    """

    commands: np.ndarray
    injection: np.ndarray
    lines: np.ndarray
    period: float


@dataclass(frozen=True, kw_only=True)
class LoopScores:
    """What came out of loop records.

    Attributes:
        metrics: Window to metric id to value, status, unit and number of lines.
        arrays: What a trace keeps, by name.
    """

    metrics: Metrics
    arrays: Mapping[str, np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Judges:
    """Those who know metrics; picklable.

    Attributes:
        objection: Says in one line why a run that came to its end still counts as failed; empty if it does not.
        loops: Turns records into margins of the loops.
    """

    objection: Callable[[RunLog], str]
    loops: Callable[[LoopRecords], LoopScores]


def study_timing(results: Sequence[RunResult]) -> dict[str, float]:
    """Return the wall times of all runs of a study together.

    Args:
        results: Their rows.
    """
    names = ("reset_s", "loop_s", "simulated_s", "total_s")
    return {name: sum(float(result.timing.get(name, 0.0)) for result in results) for name in names}
