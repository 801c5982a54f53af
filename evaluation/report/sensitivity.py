"""Does the order of the controllers hold in other worlds: the same runs with one thing of the plant changed."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from ..comparison import compare, decide
from ..errors import NothingToCompare
from ..metrics import METRICS
from .findings import POSITION, WINDOW, Findings
from .numbers import ratio_text, unit_on_page
from .sentences import SUBJECTS
from .table import Cell, Column, Reading, Table, columns_to_rows, head_cells, number_cells, word_cell
from .worlds import OWN_CONSTANTS

CHANGED = ("Robot", "Tool point", "Plant", "Tier", "Tier constants")
"""Facts that a sensitivity varies; worlds that differ in anything else are not set against each other."""

USUAL = "as usual"
"""What the page calls the world that the others vary."""


@dataclass(frozen=True, kw_only=True)
class Variant:
    """A world beside the usual one.

    Attributes:
        title: What is changed.
        findings: Its findings.
        changes: Sentences: which controllers change places, which no longer run.
    """

    title: str
    findings: Findings
    changes: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """A usual world and its variants.

    Attributes:
        base: The usual world: of all, the one from which the others differ least.
        variants: The others.
        metric: Id of the metric by which controllers are ordered.
    """

    base: Findings
    variants: Sequence[Variant]
    metric: str

    def title_of(self, findings: Findings) -> str:
        """Return what the page calls one of the worlds, empty for a world that is none of them."""
        titles = {id(self.base): USUAL, **{id(variant.findings): variant.title for variant in self.variants}}
        return titles.get(id(findings), "")

    @property
    def table(self) -> Table:
        """Mean error and place of each controller in each world."""
        order = self.base.order
        unit = METRICS[self.metric].unit
        columns, cells = [Column("Controller / knowledge", numeric=False)], [head_cells(order)]
        worlds = [(USUAL, self.base), *((variant.title, variant.findings) for variant in self.variants)]
        for title, findings in worlds:
            columns.append(Column(title, unit_on_page(unit).text))
            cells.append(_column(findings, order, self.metric, unit))
        return Table(
            id="sensitivity-table",
            caption=f"Mean {SUBJECTS[self.metric]} error and place in the order, world by world",
            columns=columns,
            rows=columns_to_rows(cells),
            name="sensitivity",
        )


def sensitivity_of(findings: Sequence[Findings], metric: str = POSITION) -> Sensitivity | None:
    """Return the sensitivity of a store, None if its worlds are no variants of one.

    Args:
        findings: Findings of all worlds.
        metric: Id of the metric by which controllers are ordered.
    """
    groups: dict[tuple[tuple[str, str], ...], list[Findings]] = {}
    for found in findings:
        if found.world.runs:
            groups.setdefault(_unchanged(found), []).append(found)
    alike = max(groups.values(), key=len, default=[])
    if len(alike) < 2 or not all(_share_controllers(alike[0], other) for other in alike[1:]):
        return None
    base = _most_usual(alike)
    others = sorted((found for found in alike if found is not base), key=lambda found: _title(base, found))
    variants = [
        Variant(title=_title(base, found), findings=found, changes=_changes(base, found, metric)) for found in others
    ]
    return Sensitivity(base=base, variants=variants, metric=metric)


def _unchanged(findings: Findings) -> tuple[tuple[str, str], ...]:
    """Return the facts that variants of one world share."""
    return tuple((name, fact) for name, fact in findings.world.facts.items() if name not in CHANGED)


def _share_controllers(one: Findings, other: Findings) -> bool:
    return len(set(one.world.labels) & set(other.world.labels)) > 1


def _most_usual(findings: Sequence[Findings]) -> Findings:
    """Return the world whose facts most others share."""
    counted = Counter((name, found.world.facts[name]) for found in findings for name in CHANGED)

    def usual(found: Findings) -> tuple[int, bool]:
        facts = found.world.facts
        return sum(counted[name, facts[name]] for name in CHANGED), facts["Tier constants"] == OWN_CONSTANTS

    return max(findings, key=usual)


def _title(base: Findings, other: Findings) -> str:
    """Return what is changed, in words."""
    facts, changed = base.world.facts, other.world.facts
    differing = [name for name in CHANGED if changed[name] != facts[name]]
    return ", ".join(
        changed[name] if name == "Tier constants" else f"{name.lower()} {changed[name]}" for name in differing
    )


def _column(findings: Findings, order: Sequence[str], metric: str, unit: str) -> list[Cell]:
    means, summaries = findings.ranking[metric], findings.summaries[metric]
    ranked = list(means)
    readings = []
    for label in order:
        found = summaries.get(label)
        href = f"#{findings.runs_anchor(label)}" if found else ""
        place = f"place {ranked.index(label) + 1}" if label in ranked else "no place"
        value = None if found is None else means.get(label, found.mean)
        readings.append(
            Reading(value, "missing" if found is None else _why(found.runs), Cell("", href=href, note=place))
        )
    cells = number_cells(readings, unit)
    return [
        cell if label in findings.world.labels else word_cell("missing")
        for label, cell in zip(order, cells, strict=True)
    ]


def _why(runs: int) -> str:
    return "failed" if runs else "refused"


def _changes(base: Findings, other: Findings, metric: str) -> list[str]:
    """Return sentences about every change in the order."""
    sentences = []
    swaps = _swaps(base, other, metric)
    decided = [text for text, sure in swaps if sure]
    if decided:
        sentences.append(f"Change places: {'; '.join(decided)}.")
    open_ones = [text for text, sure in swaps if not sure]
    if open_ones:
        sentences.append(f"Change places too, not surely in both worlds: {'; '.join(open_ones)}.")
    gone = _gone(base, other, metric)
    if gone:
        sentences.append(f"Without a place here: {', '.join(gone)}.")
    return sentences or ["The order is the same."]


def _swaps(base: Findings, other: Findings, metric: str) -> list[tuple[str, bool]]:
    """Return each pair that changes places, in words, and whether both orders are sure."""
    before, after = base.ranked(metric), other.ranked(metric)
    both = [label for label in before if label in after]
    found = []
    for first, second in combinations(both, 2):
        if after.index(first) > after.index(second):
            (was, sure_before), (now, sure_after) = (_ratio(world, first, second, metric) for world in (base, other))
            found.append((f"{first} and {second} (ratio {was}, here {now})", sure_before and sure_after))
    return found


def _ratio(findings: Findings, first: str, second: str, metric: str) -> tuple[str, bool]:
    """Return the ratio of two controllers in words, and whether it is sure which is ahead."""
    try:
        comparison = compare(findings.world.rows, first, second, metric, WINDOW)
    except NothingToCompare:
        return "none", False
    return ratio_text(comparison.gmr), decide(comparison) != "not enough to decide"


def _gone(base: Findings, other: Findings, metric: str) -> list[str]:
    """Return controllers that have a place in the usual world only, with what became of their runs."""
    after = set(other.ranked(metric))
    statuses: Mapping[str, Counter[str]] = {label: Counter() for label in other.world.labels}
    for run in other.world.runs:
        statuses[run.row.controller][run.row.status] += 1
    return [
        f"{label} ({_counted(statuses.get(label, Counter()))})" for label in base.ranked(metric) if label not in after
    ]


def _counted(statuses: Counter[str]) -> str:
    bad = [f"{statuses[word]} {word}" for word in ("failed", "refused") if statuses[word]]
    return f"{', '.join(bad)} of {statuses.total()}" if bad else "did not run the whole grid"
