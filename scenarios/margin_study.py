"""One margin of one controller: runs in ever worse worlds until the first that it does not come through."""

import math
from dataclasses import replace

from .margins import MARGINS, Margin
from .result import OK, RunResult
from .search import Found, search
from .specification import RunSpecification
from .studies import Judges, Play, study_timing
from .tiers import Tier
from .world import cached_robot, tier_of

WINDOW = "margin"
"""Window of a margin in its row."""


def margin_study(specification: RunSpecification, play: Play, judges: Judges) -> RunResult:
    """Return the row of a margin: its value, and every run that led to it with its outcome.

    It keeps no trace: any of its runs can be run again.

    Args:
        specification: The study.
        play: Runs one specification.
        judges: Judge the runs.
    """
    margin = MARGINS[specification.study]
    results: list[RunResult] = []
    objections: list[str] = []

    def passes(step: int) -> bool:
        trial = play(probe_of(specification, margin, step))
        objection = trial.result.reason
        if trial.result.status == OK and trial.log is not None:
            objection = judges.objection(trial.log)
        results.append(trial.result)
        objections.append(objection)
        return trial.result.status == OK and not objection

    found = search(passes, len(margin.grid) - 1)
    nominal = results[0]
    probes = [
        {
            "perturbation": probe_of(specification, margin, step).perturbation.as_table(),
            "passed": passed,
            "status": result.status,
            "cause": result.cause or ("" if passed else "objection"),
            "reason": objection,
            "failed_at": result.failed_at,
        }
        for (step, passed), result, objection in zip(found.probes, results, objections, strict=True)
    ]
    return replace(
        nominal,
        metrics={WINDOW: {margin.id: _value(margin, found, specification, objections[0])}},
        timing=study_timing(results),
        provenance={
            **nominal.provenance,
            "resolution": margin.resolution,
            "monotone": found.monotone,
            "first_failure": None if found.failed is None else margin.of(found.failed, _period(specification)),
            "probes": probes,
        },
        trace=None,
    )


def probe_of(specification: RunSpecification, margin: Margin, step: int) -> RunSpecification:
    """Return the ordinary run that a study tries at a step of its grid.

    Args:
        specification: The study.
        margin: Its margin.
        step: Place on the grid.
    """
    perturbation = replace(specification.perturbation, **margin.change(step))  # type: ignore[arg-type]
    return replace(specification, study="", perturbation=perturbation)


def _value(margin: Margin, found: Found, specification: RunSpecification, nominal_objection: str) -> dict[str, object]:
    """Return the margin as a stored metric: ``censored`` where nothing failed up to the end of the grid."""
    entry: dict[str, object] = {"unit": margin.unit, "n": len(found.probes)}
    if found.passed is None:
        reason = f"the nominal run does not pass: {nominal_objection}"
        return entry | {"value": math.nan, "status": "undefined", "reason": reason}
    if margin.field == "friction" and not _has_friction(specification):
        return entry | {"value": math.nan, "status": "undefined", "reason": "the tier has no friction to scale"}
    status = "censored" if found.failed is None else "ok"
    return entry | {"value": margin.of(found.passed, _period(specification)), "status": status}


def _tier(specification: RunSpecification) -> Tier:
    robot = cached_robot(specification.robot, specification.tool)
    return tier_of(specification, robot)


def _period(specification: RunSpecification) -> float:
    return _tier(specification).period


def _has_friction(specification: RunSpecification) -> bool:
    tier = _tier(specification)
    return bool(tier.coulomb.any() or tier.viscous.any())
