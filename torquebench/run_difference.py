"""In what two runs differ: their specifications and every metric."""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from .evaluation.metrics import METRICS
from .repeating import differing_fields
from .scenarios.store import StoredRun

PLACE = {name: place for place, name in enumerate(METRICS)}
"""Where a metric stands in tables."""


@dataclass(frozen=True, kw_only=True)
class Moved:
    """A metric that is not the same in two runs.

    Attributes:
        window: Its window.
        metric: Its id.
        unit: Its stored unit.
        first: Value in the first run, None if it has none.
        second: Value in the second.
    """

    window: str
    metric: str
    unit: str
    first: float | None
    second: float | None


@dataclass(frozen=True, kw_only=True)
class RunDifference:
    """In what two runs differ.

    Attributes:
        addresses: Their addresses.
        specification: Field and values of what was asked for differently.
        fields: What they left behind that is not the same to the bit.
        metrics: Every metric that moved, window by window in the registry's order, those of plug-ins last.
    """

    addresses: tuple[str, str]
    specification: tuple[tuple[str, object, object], ...]
    fields: tuple[str, ...]
    metrics: tuple[Moved, ...]

    @property
    def broken(self) -> bool:
        """Whether one address has two results."""
        return self.addresses[0] == self.addresses[1] and bool(self.fields)


def run_difference(first: StoredRun, second: StoredRun) -> RunDifference:
    """Return in what two rows differ."""
    one, other = (_flat(json.loads(row.specification.as_json())) for row in (first, second))
    return RunDifference(
        addresses=(first.address, second.address),
        specification=tuple(
            (name, one.get(name), other.get(name))
            for name in dict.fromkeys((*one, *other))
            if one.get(name) != other.get(name)
        ),
        fields=tuple(differing_fields(first.result, second.result)),
        metrics=tuple(_moved(first, second)),
    )


def _moved(first: StoredRun, second: StoredRun) -> Iterator[Moved]:
    one, other = first.result.metrics, second.result.metrics
    for window in dict.fromkeys((*one, *other)):
        here, there = one.get(window, {}), other.get(window, {})
        for metric in sorted({*here, *there}, key=lambda name: (PLACE.get(name, len(PLACE)), name)):
            values = [_number(entries.get(metric, {}).get("value")) for entries in (here, there)]
            if values[0] != values[1]:
                unit = str((here.get(metric) or there[metric]).get("unit", ""))
                yield Moved(window=window, metric=metric, unit=unit, first=values[0], second=values[1])


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _flat(table: Mapping[str, object]) -> dict[str, object]:
    found: dict[str, object] = {}
    for name, value in table.items():
        nested = isinstance(value, Mapping) and bool(value)
        found |= {f"{name}.{key}": entry for key, entry in value.items()} if nested else {name: value}  # type: ignore[attr-defined]
    return found
