"""Runs a row of a store again, and says whether every figure of it came out the same."""

import difflib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .controllers import InvalidInput, TorquebenchError
from .judging import JUDGES
from .scenarios.digest import run_digest
from .scenarios.execution import execute
from .scenarios.latency import MEASURED
from .scenarios.result import RunResult
from .scenarios.store import StoredRun
from .scoring import score, score_events

FIELDS = ("status", "cause", "reason", "failed_at", "metrics", "laps", "diagnostics", "ledger", "counts", "provenance")
"""What a run leaves behind that is no time of the machine and no trace."""

SHORTEST = 6
"""Fewest digits that may stand for an address."""


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """What came of running an address again.

    Attributes:
        address: The address.
        rows: Rows that were compared: the run, its twins, its repetitions.
        differences: Row and field of everything that is not the same to the bit.
    """

    address: str
    rows: int
    differences: tuple[str, ...]


def rows_at(stored: Sequence[StoredRun], text: str) -> list[StoredRun]:
    """Return the rows of an address, the run itself first.

    Args:
        stored: All rows of a store.
        text: The address, or as many of its first digits as tell it apart.

    Raises:
        InvalidInput: If no row has it, or several have.
    """
    addresses = sorted({row.address for row in stored})
    able = [address for address in addresses if address.startswith(text.lower()) and len(text) >= SHORTEST]
    if len(able) > 1:
        raise InvalidInput(f"{text!r} begins {len(able)} addresses", "address", "give more of its digits")
    if not able:
        # A store has thousands of addresses: the nearest, never all of them.
        nearest = difflib.get_close_matches(text.lower(), [address[: len(text)] for address in addresses], n=1)
        valid = f"did you mean {nearest[0]!r}?" if nearest and len(text) >= SHORTEST else f"{SHORTEST} digits or more"
        raise InvalidInput(f"no run has {text!r}", "address", valid)
    return [row for row in stored if row.address == able[0]]


def obstacle(row: StoredRun) -> str:
    """Return why a row cannot be had again here, empty if nothing stands against it."""
    run = row.specification
    if run.latency == MEASURED:
        return "its latency was measured, and a wall time does not come again"
    try:
        now = run.address(run_digest(run))
    except (TorquebenchError, OSError) as error:
        return " ".join(str(error).split())
    if now != row.address:
        return f"code, data or libraries are not those that it ran with (its address would be {now[:12]})"
    return ""


def repeat(rows: Sequence[StoredRun]) -> Repeated:
    """Run an address again, twins and repetitions included, and compare every figure.

    Args:
        rows: The rows of one address.
    """
    results = execute(rows[0].specification, evaluate=score, evaluate_events=score_events, judges=JUDGES, traces="none")
    again = {(result.role, result.repetition): result for result in results}
    differences = [
        f"{row.result.role}, repetition {row.result.repetition}: {field}"
        for row in rows
        for field in differing_fields(row.result, again[row.result.role, row.result.repetition])
    ]
    return Repeated(address=rows[0].address, rows=len(rows), differences=tuple(differences))


def differing_fields(one: RunResult, other: RunResult) -> list[str]:
    """Return the fields in which two results are not the same to the bit."""
    return [field for field in FIELDS if _text(getattr(one, field)) != _text(getattr(other, field))]


def _text(value: object) -> str:
    """Return a value as text: floats to the last bit, and NaN equal to itself."""
    if isinstance(value, Mapping):
        value = {name: entry for name, entry in value.items() if name != "machine"}
    return json.dumps(value, sort_keys=True)
