"""The headline in sentences, built from verdicts and numbers only."""

from collections.abc import Sequence

from ..comparison import Comparison
from ..metrics import METRICS
from .findings import ORIENTATION, POSITION, Findings, Lead
from .numbers import counting, p_value, ratio_text, significant, times_lower, unit_on_page
from .worlds import CONSTANT

PRACTICALLY_EQUAL = "practically equal"
"""The remark of a comparison whose whole interval nobody would change a controller for."""

UNINFORMED = "none"
"""The knowledge level that is told of arm and gripper only."""

MEASURED = "measured"
"""The latency of runs whose commands are late by the wall time of their calls."""

SUBJECTS = {POSITION: "position", ORIENTATION: "orientation"}


def percent(level: float) -> str:
    """Return a confidence level: ``95 %``."""
    return f"{100 * level:g} %"


def value_in_words(value: float, unit: str) -> str:
    """Return a value with its unit on the page."""
    shown = unit_on_page(unit)
    return f"{significant(shown.of(value))} {shown.text}"


def ratio_in_words(comparison: Comparison) -> str:
    """Return a ratio with its interval over trajectories, or why there is none."""
    interval = comparison.interval_new_motions
    ratio = f"ratio {ratio_text(comparison.gmr)}"
    if interval is None:
        return f"{ratio}, one trajectory: no interval"
    limits = f"{ratio_text(interval.low)} to {ratio_text(interval.high)}"
    return f"{ratio}, {percent(interval.level)} interval over {comparison.n_trajectories} trajectories {limits}"


def failure_sentence(findings: Findings) -> str:
    """Say how many runs failed, and whose."""
    runs = [run for run in findings.world.runs if run.row.status != "refused"]
    failed = [run for run in runs if run.row.status == "failed"]
    refused = len(findings.world.runs) - len(runs)
    tail = f" {_count(refused, 'run was', 'runs were')} refused before the start." if refused else ""
    if not failed:
        return f"No run of {len(runs)} failed.{tail}"
    labels = [run.row.controller for run in failed]
    whose = ", ".join(f"{label} ({labels.count(label)})" for label in dict.fromkeys(labels))
    return f"{_count(len(failed), 'run', 'runs')} of {len(runs)} failed: {whose}.{tail}"


def unranked_sentence(findings: Findings) -> str:
    """Say which controllers cannot come first, empty if all can."""
    ranked = {label for lead in findings.leads for label in lead.ranked}
    others = [label for label in findings.order if label not in ranked]
    if not others or not ranked:
        return ""
    return f"Not ranked, for failures or a grid with gaps: {', '.join(others)}."


def common_sentence(findings: Findings) -> str:
    """Say over which runs the controllers are ranked, empty if over all."""
    rows, common = findings.world.rows, findings.common_rows
    if len(common) == len(rows):
        return ""
    cells = len({row.cell for row in common})
    return (
        f"Not all controllers ran all cells. They are ranked over the {cells} cells (trajectory and load) that more "
        "than half of them ran, and the means above are over these; means in the table of all controllers are over all "
        "runs of each, and ratios over the runs that both have."
    )


def machine_sentence(findings: Findings) -> str:
    """Say that measured latency makes results one machine's own, empty where latency is not measured."""
    machines = {run.stored.machine for run in findings.world.runs if run.stored.specification.latency == MEASURED}
    if not machines:
        return ""
    return (
        "Latency was measured: every command acts late by the wall time of its own call, so these figures belong to "
        f"one machine ({', '.join(sorted(machines))}) and to what else it did, and stand apart from all "
        "others."
    )


def lead_sentences(findings: Findings, lead: Lead) -> list[str]:
    """Say who tracked best on a headline metric, and how sure that is.

    Args:
        findings: The world's findings.
        lead: Who comes first.

    Returns:
        One sentence about the first, one about the second if there is one, one about the first with no knowledge of
        the load, and one about the family if it changes what can be decided.
    """
    subject = SUBJECTS[lead.metric]
    if not lead.ranked:
        return [f"Nothing to rank in {subject}: no controller finished the grid with at most 5 % of its runs failed."]
    return [_first(findings, lead), *_next(findings, lead), *_uninformed(findings, lead), *_family(lead)]


def _first(findings: Findings, lead: Lead) -> str:
    """Say who comes first, and how far from the reference."""
    world, subject, first = findings.world, SUBJECTS[lead.metric], lead.ranked[0]
    mean = _mean(findings, lead.metric, first)
    if len(world.labels) == 1:
        return f"{first} ran alone: mean {subject} error {mean}; there is nothing to compare it with."
    claim = f"{first} has the lowest mean {subject} error: {mean}"
    if lead.against_next is not None and _ahead(lead.against_next):
        claim = f"{first} tracked best in {subject}: mean error {mean}"
    if first == world.reference:
        return f"{claim}; it is the declared reference."
    against = lead.against_reference
    if against is None:
        return f"{claim}; {_no_reference(findings)}."
    if against.headline != "gmr":
        chance = f"it beats {world.reference} with probability {against.prob_improvement:.2f}"
        return f"{claim}; the reference failed too often for a ratio, {chance}."
    if against.verdict != "better":
        return f"{claim}, but against {world.reference} {_undecided(against)}."
    return f"{claim}, {times_lower(against.gmr)} than {world.reference} ({ratio_in_words(against)})."


def _next(findings: Findings, lead: Lead) -> list[str]:
    """Say how far the second is behind the first."""
    pair = lead.against_next
    if pair is None or pair.reference == findings.world.reference:
        return []
    second = f"{pair.reference} ({_mean(findings, lead.metric, pair.reference)})"
    if _ahead(pair):
        return [f"Next comes {second}: {pair.controller} is {times_lower(pair.gmr)} ({ratio_in_words(pair)})."]
    if pair.verdict == "better":
        return [f"The next, {second}, is practically equal ({ratio_in_words(pair)})."]
    return [f"Between it and the next, {second}, {_undecided(pair)}."]


def _uninformed(findings: Findings, lead: Lead) -> list[str]:
    """Say who comes first of those that are told nothing of the load, if the first of all is told something."""
    levels = {run.row.controller: run.stored.specification.knowledge for run in findings.world.runs}
    uninformed = [label for label in lead.ranked if levels[label] == UNINFORMED]
    if not uninformed or uninformed[0] == lead.ranked[0]:
        return []
    label, against = uninformed[0], findings.comparisons[lead.metric].get(uninformed[0])
    claim = f"Of those told nothing of the load {label} comes first: {_mean(findings, lead.metric, label)}"
    if against is None or against.headline != "gmr" or findings.verdict_alone(against) != "better":
        return [f"{claim}."]
    return [f"{claim}, {times_lower(against.gmr)} than {findings.world.reference} ({ratio_in_words(against)})."]


def _ahead(pair: Comparison) -> bool:
    """Return whether the first is ahead of the second by more than nobody would care about."""
    return pair.verdict == "better" and PRACTICALLY_EQUAL not in pair.remarks


def _family(lead: Lead) -> list[str]:
    """Say if the correction for all opponents takes the verdict back."""
    alone, family = lead.against_reference, lead.in_family
    if alone is None or family is None or alone.verdict == family.verdict:
        return []
    corrected = "" if family.p_holm is None else f" (corrected p = {p_value(family.p_holm)})"
    return [
        f"Exploratory: on {family.n_trajectories} trajectories there is not enough to decide it as one of "
        f"{family.family} comparisons with the reference{corrected}."
    ]


def _undecided(comparison: Comparison) -> str:
    """Say what keeps the first of a ranking from being ahead: doubt, or the runs outside of the common cells."""
    if comparison.verdict == "worse":
        return f"it is {times_lower(comparison.gmr)} over all runs that both have ({ratio_in_words(comparison)})"
    reasons = [remark for remark in comparison.remarks if remark in (PRACTICALLY_EQUAL, "depends on the average used")]
    if comparison.interval_new_motions is not None and "too few trajectories" in comparison.remarks:
        reasons.append("too few trajectories")
    return f"there is not enough to decide ({'; '.join([ratio_in_words(comparison), *reasons])})"


def _no_reference(findings: Findings) -> str:
    world = findings.world
    if not world.reference:
        return "no reference was declared, so there is no ratio"
    if not world.has_reference:
        return f"the declared reference {world.reference} did not run here, so there is no ratio"
    return f"no run pairs with one of the reference {world.reference}, so there is no ratio"


def _mean(findings: Findings, metric: str, label: str) -> str:
    return value_in_words(findings.ranking[metric][label], METRICS[metric].unit)


def _count(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}"


def facts_in_words(findings: Findings) -> list[tuple[str, str]]:
    """Return what was compared: what all runs share, and over what they range."""
    world = findings.world
    runs = world.runs
    loads = list(dict.fromkeys(run.load for run in sorted(runs, key=lambda run: (run.row.mass, run.row.material))))
    repetitions = len({run.row.repetition for run in runs})
    groups = {run.row.trajectory: run.row.group for run in runs}
    return [
        *((name, value) for name, value in world.facts.items() if value != CONSTANT),
        ("Trajectories", f"{len(groups)}: {_grouped(groups)}"),
        ("Loads", f"{', '.join(loads)} (all beyond the flange, gripper included)" if loads else "none"),
        ("Controllers", f"{len(world.labels)}, each knowledge level a row of its own"),
        ("Repetitions", str(repetitions)),
        ("Runs", f"{len(runs)}" + (f" and {len(world.twins)} twins, listed apart" if world.twins else "")),
        (
            "Reference",
            world.reference + ("" if world.has_reference else " (no runs here)")
            if world.reference
            else "none declared",
        ),
    ]


def _grouped(groups: dict[str, str]) -> str:
    """Return the trajectories, group by group if they have groups."""
    kinds: dict[str, list[str]] = {}
    for trajectory, group in sorted(groups.items(), key=lambda item: counting(item[0])):
        kinds.setdefault(group, []).append(trajectory)
    ordered: Sequence[str] = sorted(kinds, reverse=True)
    return "; ".join(", ".join(kinds[kind]) + (f" ({kind})" if kind else "") for kind in ordered)
