"""What one run leaves behind: a row of plain values, and a trace."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

OK, FAILED, REFUSED = "ok", "failed", "refused"


@dataclass(frozen=True, kw_only=True)
class RunResult:
    """One load history of one run specification.

    Attributes:
        role: ``"run"``, or the name of a twin's load history.
        repetition: Number of the repetition; a chain of protocol ``carried`` has a row for each.
        status: ``"ok"``, ``"failed"`` or ``"refused"``.
        cause: Short word for what ended it: ``"nan torque"``, ``"exception"``, ``"divergence"``,
            ``"limit violation"``, ``"time-out"``, ``"wrong shape"``, ``"crash"``, ``"refused"``, ``"carried"`` (an
            earlier repetition of its chain ended early); empty if it is ok.
        reason: One line for a person.
        failed_at: Time at which it ended early, None otherwise [s].
        metrics: Window to metric id to value, status, unit and number of samples; a load event is a window of its own,
            named by :func:`~.events.event_window`.
        laps: Metric id to one value per whole lap.
        diagnostics: Name to figures of what the controller showed, see :func:`~.diagnostics.figures`.
        ledger: Where the controller's settings come from.
        counts: Ticks, clipped ticks by cause and joint, operations.
        timing: Wall times and the machine they belong to; no part of the result.
        provenance: Plant, payload, draws, the periods of the diagnostics, the events and what they were judged against.
        trace: Bytes of :func:`~.trace.encode_trace`, None if none is kept.
    """

    role: str
    status: str
    repetition: int = 0
    cause: str = ""
    reason: str = ""
    failed_at: float | None = None
    metrics: Mapping[str, Mapping[str, Mapping[str, object]]] = field(default_factory=dict)
    laps: Mapping[str, Sequence[float]] = field(default_factory=dict)
    diagnostics: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    ledger: Sequence[Mapping[str, object]] = ()
    counts: Mapping[str, object] = field(default_factory=dict)
    timing: Mapping[str, float | str] = field(default_factory=dict)
    provenance: Mapping[str, object] = field(default_factory=dict)
    trace: bytes | None = None


@dataclass(frozen=True, kw_only=True)
class Scores:
    """What an ``evaluate`` callable returns for one log.

    Attributes:
        metrics: Window to metric id to value, status, unit and number of samples.
        laps: Metric id to one value per whole lap.
        timing: Metric id to a figure about wall times; they belong to the machine, not to the result.
    """

    metrics: Mapping[str, Mapping[str, Mapping[str, object]]]
    laps: Mapping[str, Sequence[float]] = field(default_factory=dict)
    timing: Mapping[str, float] = field(default_factory=dict)
