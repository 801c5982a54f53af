"""Bounds on a store's figures, from a TOML file: what a user's own continuous integration insists on."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from .controllers import InvalidInput
from .evaluation.comparison import compare
from .evaluation.errors import NothingToCompare
from .evaluation.metrics import Metric
from .evaluation.metrics.catalogue import KINDS
from .evaluation.report.findings import WINDOW
from .evaluation.report.worlds import Run, World, worlds_of
from .evaluation.rows import find_metric, read
from .evaluation.summary import summary
from .plug_in_metrics import all_metrics
from .scenarios.store import Store
from .scenarios.validation import Number, Record, as_tuple, read_toml, validate
from .selection import Selection, one_label


class Bound(Record):
    """One line that a figure must keep to.

    Attributes:
        metric: Id of the metric.
        window: Its window.
        controller: Label of the page, or the controller's name.
        knowledge: Its knowledge level, where it ran with several.
        trajectories: Names of motions; empty for all that ran.
        motions: Name of a set of motions, empty for all that ran.
        mass: Mass beyond the flange [kg]; None for all that ran.
        material: Content of the container, ``none`` for an empty one; empty for all that ran.
        of: ``mean``: over the cells, as on the page. ``worst``: the run that comes nearest to breaking the bound. Both
            are of magnitudes: an early lag is no small one.
        against: Label or name of a controller: the figure is then the geometric mean ratio to it, as on the page.
        at_most: Largest value that passes, in the metric's stored unit.
        at_least: Smallest value that passes.
    """

    metric: str
    controller: str
    window: str = WINDOW
    knowledge: str = ""
    trajectories: Annotated[tuple[str, ...], BeforeValidator(as_tuple)] = ()
    motions: str = ""
    mass: Number | None = None
    material: str = ""
    of: Literal["mean", "worst"] = "mean"
    against: str = ""
    at_most: Number | None = None
    at_least: Number | None = None

    @model_validator(mode="after")
    def _means_something(self) -> "Bound":
        if self.at_most is None and self.at_least is None:
            raise PydanticCustomError("no_limit", "give at_most, at_least, or both")
        if self.against and self.of == "worst":
            raise PydanticCustomError("no_worst_ratio", "a ratio is of means: leave out of = 'worst'")
        return self

    @property
    def selection(self) -> Selection:
        """The runs that it is about."""
        return Selection(
            controller=self.controller,
            knowledge=self.knowledge,
            trajectories=self.trajectories,
            motions=self.motions,
            mass=self.mass,
            material=self.material,
        )


class BoundsFile(Record):
    """A file of bounds.

    Attributes:
        version: Version of this form; the file calls it ``schema``.
        bound: The bounds, each a table ``[[bound]]``.
    """

    version: Annotated[int, Field(alias="schema", ge=1, le=1)] = 1
    bound: Annotated[tuple[Bound, ...], BeforeValidator(as_tuple), Field(min_length=1)]


@dataclass(frozen=True, kw_only=True)
class Checked:
    """A bound held against a store.

    Attributes:
        bound: The bound in words.
        value: The figure, in the metric's stored unit, or a ratio; None if there is none.
        unit: Its unit, empty for a ratio.
        passed: Whether it keeps to the bound.
        reason: Why there is no figure, empty if there is one.
    """

    bound: str
    value: float | None
    unit: str
    passed: bool
    reason: str


def read_bounds(file: Path) -> tuple[Bound, ...]:
    """Return the bounds of a file.

    Raises:
        InvalidInput: If it cannot be read, a key of it is wrong, or a metric is one that no single run has.
        UnknownMetric: If it names a metric that nobody registered.
    """
    bounds = validate(BoundsFile, read_toml(file), where=str(file)).bound
    for bound in bounds:
        kind = find_metric(bound.metric, all_metrics()).kind
        if kind in ("table", "timing"):
            came = f"{bound.metric} is computed from {KINDS[kind]}"
            raise InvalidInput(came, str(file), "bound a metric that each run has")
    return bounds


def check_bounds(bounds: Sequence[Bound], folder: Path) -> tuple[Checked, ...]:
    """Hold bounds against a results folder; one that has runs in several worlds must hold in each.

    Args:
        bounds: The bounds.
        folder: The folder.

    Raises:
        TorquebenchError: If the folder holds no store, or none of its runs has a name that a bound asks for.
    """
    with Store.read(folder) as store:
        worlds = worlds_of(store.runs(), store.campaigns())
    return tuple(checked for bound in bounds for checked in _checked(bound, worlds))


def _checked(bound: Bound, worlds: Sequence[World]) -> Iterator[Checked]:
    chosen = {id(run.stored) for run in bound.selection.of([run for world in worlds for run in world.runs])}
    metric = find_metric(bound.metric, all_metrics())
    for world in worlds:
        runs = [run for run in world.runs if id(run.stored) in chosen]
        if not runs:
            continue
        where = f" in {world.id}" if len(worlds) > 1 else ""
        value, reason = _figure(bound, metric, world, runs)
        yield Checked(
            bound=f"{_words(bound)}{where}",
            value=value,
            unit="" if bound.against else metric.unit,
            passed=value is not None and _keeps(bound, value),
            reason=reason,
        )


def _figure(bound: Bound, metric: Metric[...], world: World, runs: Sequence[Run]) -> tuple[float | None, str]:
    """Return the figure of a bound in one world, or why there is none: a gate never passes on survivors."""
    label = one_label(runs, bound.selection)
    if without := _without_value(runs, metric, bound.window):
        return None, f"{without} of {len(runs)} runs of {label} have no value"
    if not bound.against:
        return _own(bound, metric, runs, label), ""
    other = replace(bound.selection, controller=bound.against, knowledge="")
    against = other.of(world.runs)
    reference = one_label(against, other)
    if without := _without_value(against, metric, bound.window):
        return None, f"{without} of {len(against)} runs of {reference} have no value"
    try:
        rows = [run.row for run in (*runs, *against)]
        return compare(rows, label, reference, metric.id, bound.window, {metric.id: metric}).gmr, ""
    except NothingToCompare as error:
        return None, str(error)


def _own(bound: Bound, metric: Metric[...], runs: Sequence[Run], label: str) -> float | None:
    if bound.of == "mean":
        return summary([run.row for run in runs], metric.id, bound.window, {metric.id: metric})[label].mean
    values = [value for run in runs if (value := read(run.row, metric, bound.window).magnitude) is not None]
    return min(values, key=lambda value: _room(bound, value), default=None)


def _without_value(runs: Sequence[Run], metric: Metric[...], window: str) -> int:
    return sum(read(run.row, metric, window).status != "ok" for run in runs)


def _keeps(bound: Bound, value: float) -> bool:
    return _room(bound, value) >= 0.0


def _room(bound: Bound, value: float) -> float:
    """Return how far a figure is from the nearer limit, negative beyond it."""
    below = math.inf if bound.at_most is None else bound.at_most - value
    above = math.inf if bound.at_least is None else value - bound.at_least
    return min(below, above)


def _words(bound: Bound) -> str:
    """Return a bound in words: ``mean tcp_position_error_mean, controller pid, mass 1.5: at most 0.02``."""
    figure = f"ratio to {bound.against} in" if bound.against else bound.of
    window = "" if bound.window == WINDOW else f" in window {bound.window}"
    limits = [(word, limit) for word, limit in (("at least", bound.at_least), ("at most", bound.at_most))]
    said = " and ".join(f"{word} {limit:g}" for word, limit in limits if limit is not None)
    return f"{figure} {bound.metric}{window}, {bound.selection}: {said}"
