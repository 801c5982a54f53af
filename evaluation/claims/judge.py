"""Judges claims: reads what each needs from the runs of its set, and applies its rule."""

from collections.abc import Mapping, Sequence

from ..errors import EvaluationError
from .book import Book, Claim
from .contrasts import all_cells, interaction, joints, range_ratio, ratio
from .readings import Evidence, NotEnough
from .rules import IN_PARTS, REPRODUCED, UNDECIDED, UNTESTABLE, Ruling, agreement_rule
from .single import correlation, count, level, slope, time
from .verdict import Measured, Verdict, verdict_of

JUDGES = {
    "ratio": ratio,
    "range_ratio": range_ratio,
    "interaction": interaction,
    "slope_sign": slope,
    "time": time,
    "count": count,
    "correlation": correlation,
    "level": level,
}
"""Rule to what judges by it from the runs of one set."""


def judge_all(book: Book, evidence: Mapping[str, Evidence]) -> list[Verdict]:
    """Return a verdict on every claim, in the order of the book.

    Args:
        book: The claims.
        evidence: Set of runs to its runs; sets that nobody ran are missing.
    """
    return [judge(claim, book, evidence) for claim in book.claim]


def judge(claim: Claim, book: Book, evidence: Mapping[str, Evidence]) -> Verdict:
    """Return the verdict on one claim.

    Args:
        claim: The claim.
        book: All claims, for those that compare verdicts.
        evidence: Set of runs to its runs.
    """
    if claim.testable == "no":
        return verdict_of(claim, Ruling(UNTESTABLE, claim.why), Measured())
    if claim.rule == "profile":
        parts = tuple(judge(part, book, evidence) for part in claim.parts)
        return Verdict(claim=claim, word=IN_PARTS, reason=claim.why, measured=Measured(), parts=parts)
    if claim.runs not in evidence:
        return verdict_of(claim, Ruling(UNDECIDED, _not_run(claim, book)), Measured())
    try:
        if claim.rule == "agreement":
            ruling, measured = _agreement(claim, book, evidence)
        elif claim.rule == "all_cells":
            ruling, measured = (joints if "joint" in claim.cells else all_cells)(claim, evidence[claim.runs])
        else:
            ruling, measured = JUDGES[claim.rule](claim, evidence[claim.runs])
    except (NotEnough, EvaluationError) as lack:
        return verdict_of(claim, Ruling(UNDECIDED, str(lack)), Measured())
    return verdict_of(claim, ruling, measured)


def _not_run(claim: Claim, book: Book) -> str:
    """Say that nobody ran a set, and what does."""
    runs = book.set_of(claim)
    if runs is None or not runs.benchmarks:
        return claim.why or f"no benchmark runs {claim.runs}"
    verb = "runs" if len(runs.benchmarks) == 1 else "run"
    return f"no run of {runs.id} ({runs.title}); {' and '.join(runs.benchmarks)} {verb} it"


def _agreement(claim: Claim, book: Book, evidence: Mapping[str, Evidence]) -> tuple[Ruling, Measured]:
    """Compare verdicts of claims on two materials, or with what the paper says of them."""
    listed: Sequence[Claim] = [other for other in book.claim if other.id in claim.claims]

    def judged(material: str) -> list[Verdict]:
        return [judge(other.model_copy(update={"material": material}), book, evidence) for other in listed]

    if claim.a_is:
        pairs = {a.claim.id: (a.word, b.word) for a, b in zip(judged(claim.a_is), judged(claim.b_is), strict=True)}
    else:
        pairs = {other.id: (judge(other, book, evidence).word, REPRODUCED) for other in listed}
    ruling = agreement_rule(pairs)
    notes = tuple(
        f"{name}: {' / '.join(dict.fromkeys(pair if claim.a_is else pair[:1]))}" for name, pair in pairs.items()
    )
    return ruling, Measured(n=len(pairs), of="claims", notes=notes)
