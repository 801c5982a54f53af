"""Tables of comparisons with the reference, with what is known of their certainty."""

from dataclasses import replace

from ..comparison import Comparison
from ..metrics import METRICS
from ..statistics import EXACT_FLIPS
from .cells import controller_column, interval_cell, verdict_cell
from .findings import COMPARED, Findings
from .numbers import capitalised, p_value, ratio_text
from .table import Cell, Column, Table

OTHER = "Other intervals, 95 %"


def comparison_table(findings: Findings, metric: str) -> Table:
    """Return the comparisons of one metric: one family.

    Args:
        findings: The world's findings.
        metric: Id of the metric; the columns are explained below the table of the first one only.
    """
    columns = [
        controller_column(),
        Column("Ratio", note="geometric mean of controller / reference over trajectories; below, its t interval"),
        Column("This suite", group=OTHER, note="over repetitions, trajectories fixed; none with one repetition"),
        Column("Bootstrap", group=OTHER, note="BCa over trajectories, narrower than it should be; none below five"),
        Column("Ratio of means", note="the paper's percentage; large errors dominate it"),
        Column("P(better)", note="probability that a run beats a run of the reference"),
        Column("p", note=f"sign-flip test over trajectories, exact up to {EXACT_FLIPS} of them"),
        Column("p, Holm", note="corrected for all opponents of the reference"),
        Column("n", note="trajectories; below, pairs of runs"),
        Column("Verdict", numeric=False, note="as if it had been the only comparison; below, as one of its family"),
        Column("Remarks", numeric=False),
    ]
    found = findings.comparisons[metric]
    label = METRICS[metric].label
    return Table(
        id=f"{findings.world.id}-pairs-{metric}",
        caption=f"{capitalised(label)}: each controller against {findings.world.reference}",
        columns=columns if metric == COMPARED[0] else [replace(column, note="") for column in columns],
        rows=[_row(findings, found[name]) for name in findings.order if name in found],
        name=f"{findings.world.id}-comparisons-{metric}",
    )


def _row(findings: Findings, comparison: Comparison) -> tuple[Cell, ...]:
    alone, holm = findings.verdict_alone(comparison), comparison.p_holm
    family = f"of {comparison.family}: {comparison.verdict}"
    return (
        Cell(comparison.controller, href=f"#{findings.runs_anchor(comparison.controller)}", kind="head"),
        verdict_cell(comparison, alone),
        interval_cell(comparison.interval_suite),
        interval_cell(comparison.bca),
        Cell(ratio_text(comparison.ratio_of_means), comparison.ratio_of_means),
        Cell(f"{comparison.prob_improvement:.2f}", comparison.prob_improvement),
        Cell(p_value(comparison.p_sign_flip), comparison.p_sign_flip),
        Cell("none" if holm is None else p_value(holm), holm),
        Cell(str(comparison.n_trajectories), comparison.n_trajectories, note=f"{comparison.n_pairs} pairs"),
        Cell(alone, note=family),
        Cell("; ".join(comparison.remarks), kind="wide"),
    )
