"""In what two results folders differ: rows, code and machine, metrics beyond the noise, order of the controllers."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from .evaluation.comparison import Comparison, compare
from .evaluation.errors import NothingToCompare
from .evaluation.report.findings import COMPARED, HEADLINES, WINDOW, Findings
from .evaluation.report.worlds import World, history_in_words, told_apart, worlds_of
from .repeating import differing_fields
from .scenarios.store import Store, StoredRun

SET_UP = ("benchmark", "versions", "commit", "machine", "seed")
"""What of a campaign's record can differ between two that should agree."""


@dataclass(frozen=True, kw_only=True)
class UnequalRow:
    """A row that both folders have under one address, and that is not the same to the bit.

    Attributes:
        address: Its address.
        run: Controller, motion, load, arm and draw in words.
        fields: What differs.
    """

    address: str
    run: str
    fields: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Shift:
    """How one metric of one controller moved.

    Attributes:
        world: What the runs share, as far as the worlds of the folders differ in it.
        comparison: The second folder's runs over the first's.
    """

    world: str
    comparison: Comparison

    @property
    def beyond_noise(self) -> bool:
        """Whether the interval over motions leaves no doubt about the direction."""
        return self.comparison.verdict != "not enough to decide"


@dataclass(frozen=True, kw_only=True)
class Order:
    """A ranking that is not the same in both.

    Attributes:
        world: What the runs share, as far as the worlds of the folders differ in it.
        metric: Id of the metric.
        first: Controllers that both rank, best first, in the first folder.
        second: The same in the second.
    """

    world: str
    metric: str
    first: tuple[str, ...]
    second: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Difference:
    """In what two results folders differ.

    Attributes:
        same: Rows that both have under one address.
        unequal: Those of them that are not the same to the bit.
        other_code: Runs that both have, under different addresses: by other code, data or libraries.
        only: Runs that only the first, and only the second has, in words.
        set_up: Name and values of what the newest campaigns note differently.
        shifts: Every metric that moved.
        orders: Every ranking that changed.
    """

    same: int
    unequal: tuple[UnequalRow, ...]
    other_code: int
    only: tuple[tuple[str, ...], tuple[str, ...]]
    set_up: tuple[tuple[str, object, object], ...]
    shifts: tuple[Shift, ...]
    orders: tuple[Order, ...]


def difference(first: Path, second: Path) -> Difference:
    """Return in what two results folders differ.

    Rows of one address must be equal to the bit, whatever the machine. Runs of one specification by other code are
    compared as the report compares controllers: a ratio with an interval over motions.

    Args:
        first: A folder.
        second: Another.

    Raises:
        InvalidInput: If one holds no store.
    """
    one, other = _Side.read(first), _Side.read(second)
    shared = one.rows.keys() & other.rows.keys()
    fields = {key: differing_fields(one.rows[key].result, other.rows[key].result) for key in sorted(shared)}
    pairs = list(_pairs(one.worlds, other.worlds))
    specifications = [{row.specification.as_json(): row for row in side.rows.values()} for side in (one, other)]
    return Difference(
        same=len(shared),
        unequal=tuple(
            UnequalRow(address=key[0], run=in_words(one.rows[key]), fields=tuple(found))
            for key, found in fields.items()
            if found
        ),
        other_code=sum(
            specifications[0][text].address != specifications[1][text].address
            for text in specifications[0].keys() & specifications[1].keys()
        ),
        only=(_only(*specifications), _only(*reversed(specifications))),
        set_up=tuple(_set_up(one.campaigns, other.campaigns)),
        shifts=tuple(shift for name, *pair in pairs for shift in _shifts(name, *pair)),
        orders=tuple(order for name, *pair in pairs for order in _orders(name, *pair)),
    )


def in_words(row: StoredRun) -> str:
    """Return a row's controller, motion, load, arm and draw."""
    run = row.specification
    role = "" if row.result.role == "run" else f", {row.result.role}"
    study = f", study {run.study}" if run.study else ""
    world = f"{run.robot} {run.tier} on {run.plant}, seed {run.campaign}, repetition {row.repetition}"
    return f"{run.label}, {run.trajectory}, {history_in_words(row)}, {world}{role}{study}"


@dataclass(frozen=True, kw_only=True)
class _Side:
    """One folder: its rows by address, role and repetition, its worlds, its campaigns."""

    rows: Mapping[tuple[str, str, int], StoredRun]
    worlds: tuple[World, ...]
    campaigns: Sequence[Mapping[str, object]]

    @classmethod
    def read(cls, folder: Path) -> "_Side":
        with Store.read(folder) as store:
            stored, campaigns = store.runs(), store.campaigns()
        rows = {(row.address, row.result.role, row.result.repetition): row for row in stored}
        return cls(rows=rows, worlds=worlds_of(stored, campaigns), campaigns=campaigns)


def _only(here: Mapping[str, StoredRun], there: Mapping[str, StoredRun]) -> tuple[str, ...]:
    return tuple(sorted(in_words(row) for text, row in here.items() if text not in there))


def _set_up(
    first: Sequence[Mapping[str, object]], second: Sequence[Mapping[str, object]]
) -> Iterator[tuple[str, object, object]]:
    """Yield what the newest campaigns note differently, entry by entry."""
    one, other = (_flat(campaigns[-1]) if campaigns else {} for campaigns in (first, second))
    for name in dict.fromkeys((*one, *other)):
        if one.get(name) != other.get(name):
            yield name, one.get(name), other.get(name)


def _flat(record: Mapping[str, object]) -> dict[str, object]:
    found: dict[str, object] = {}
    for name in SET_UP:
        value = record.get(name)
        found |= (
            {f"{name}.{key}": entry for key, entry in value.items()} if isinstance(value, Mapping) else {name: value}
        )
    return found


def _pairs(first: Sequence[World], second: Sequence[World]) -> Iterator[tuple[str, World, World]]:
    """Yield the worlds that both have, with what tells them apart; another seed is another draw of the same world."""
    for world in first:
        exact = [other for other in second if other.facts == world.facts]
        alike = [other for other in second if _without_seed(other) == _without_seed(world)]
        for other in (exact or alike)[:1]:
            yield told_apart(world, first), world, other


def _without_seed(world: World) -> dict[str, str]:
    return {name: value for name, value in world.facts.items() if name != "Seed"}


def _shifts(name: str, first: World, second: World) -> Iterator[Shift]:
    """Yield every metric of every controller of both worlds that moved."""
    for label in [label for label in first.labels if label in second.labels]:
        rows = [replace(row, controller=side) for side, world in (("A", first), ("B", second))
                for row in world.rows if row.controller == label]  # fmt: skip
        for metric in COMPARED:
            try:
                found = compare(rows, "B", "A", metric, WINDOW)
            except NothingToCompare:
                continue
            if found.gmr != 1.0:
                yield Shift(world=name, comparison=replace(found, controller=label, reference=label))


def _orders(name: str, first: World, second: World) -> Iterator[Order]:
    """Yield every headline ranking of the controllers that both rank, if it changed."""
    sides = [Findings(world) for world in (first, second)]
    for metric in HEADLINES:
        ranked = [side.ranked(metric) for side in sides]
        common = set(ranked[0]) & set(ranked[1])
        kept = [tuple(label for label in order if label in common) for order in ranked]
        if kept[0] != kept[1]:
            yield Order(world=name, metric=metric, first=kept[0], second=kept[1])
