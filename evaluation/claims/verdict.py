"""A verdict: a claim, what was measured, one word, and why it is no higher one."""

from dataclasses import dataclass

from ..intervals import Interval
from .book import Claim
from .rules import IN_PARTS, UNTESTABLE, Ruling, Word

STAND_IN = "against our approximation of the factory controller"
"""What every sentence says of a proxy."""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What was measured, signed as it is.

    Attributes:
        value: The value; None if there is none.
        unit: Its unit; ``ratio`` is A over B.
        interval: Its interval, None if it has none.
        n: Number of units.
        of: What the unit is: ``trajectories``, ``cells``, ``seeds``, ``runs``.
        test: The test beside the interval, with its p value; empty without one.
        notes: What a reader should see beside it.
    """

    value: float | None = None
    unit: str = ""
    interval: Interval | None = None
    n: int = 0
    of: str = ""
    test: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What the runs say about a claim.

    Attributes:
        claim: The claim.
        word: The word, for programs; people are shown :attr:`statement`.
        reason: Why the word is no higher one; empty if it is the highest.
        measured: What was measured.
        parts: Verdicts of its parts.
    """

    claim: Claim
    word: Word
    reason: str
    measured: Measured
    parts: tuple["Verdict", ...] = ()

    @property
    def statement(self) -> str:
        """The word as it may be printed: that of a proxy never stands without what it was judged against."""
        if self.word == IN_PARTS:
            return "; ".join(f"{part.claim.says.rstrip('.')}: {part.statement}" for part in self.parts)
        if self.claim.testable != "proxy" or self.word == UNTESTABLE:
            return self.word
        return f"{self.word}, {STAND_IN}"

    @property
    def sentence(self) -> str:
        """The claim with its verdict and the reason, in one sentence."""
        tail = " for these trajectories" if self.claim.rule == "range_ratio" else ""
        reason = f" ({self.reason})" if self.reason else ""
        return f"{self.claim.id}, {self.claim.says.rstrip('.')!r}: {self.statement}{tail}{reason}."


def verdict_of(claim: Claim, ruling: Ruling, measured: Measured) -> Verdict:
    """Return the verdict of a ruling."""
    return Verdict(claim=claim, word=ruling.word, reason=ruling.reason, measured=measured)
