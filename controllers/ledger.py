"""Where a controller's settings come from: the part of a comparison that readers ask about first."""

from dataclasses import dataclass
from typing import Literal

Source = Literal["published", "rule", "tuned", "chosen"]


@dataclass(frozen=True, kw_only=True)
class LedgerEntry:
    """The origin of one setting.

    Attributes:
        setting: Name of the setting.
        value: Its value, JSON-serialisable.
        source: ``published`` (a document gives it), ``rule`` (computed from the model by a stated rule),
            ``tuned`` (searched, with the number of trials), ``chosen`` (decided by hand).
        note: The document, the rule or the reason.
        trials: How many trials a search spent on it.
        learnt_before: What was learnt before the run, and on what; empty if nothing was.
    """

    setting: str
    value: object
    source: Source
    note: str = ""
    trials: int = 0
    learnt_before: str = ""
