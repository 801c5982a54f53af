"""What makes a function of a log a metric: its record, and the checks that all metrics share."""

import inspect
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Generic, Literal, ParamSpec

import numpy as np

from ..errors import EmptyWindow, UnequalLengths
from .shared import is_finite

Arguments = ParamSpec("Arguments")
Better = Literal["lower", "higher", "none"]
Status = Literal["ok", "censored", "failed", "undefined"]
Kind = Literal["log", "table", "timing", "twins"]
"""What a metric is computed from: one log, values or curves of several runs, wall times, or a run with its twins."""

UNDEFINED = math.nan
"""What a metric returns where it has no meaning: the time lag of a reference that rests, the rate of one sample."""

CONSTANTS = frozenset({"dt", "lap", "effort", "torque_rate", "velocity", "lower", "upper", "mass"})
"""Fields of a log that hold one value for the whole run; all others have a row for each tick."""


class Censored(float):
    """A metric's value that is only a bound: the truth lies at it or beyond; infinite if it never came about."""


@dataclass(frozen=True)
class Value:
    """One metric of one window of one run.

    Attributes:
        value: The number, in ``unit``; NaN if failed or undefined.
        unit: Its unit.
        status: ``ok``; ``censored``, a bound only; ``failed``, a sample was not finite; ``undefined``, no meaning here.
        n: Number of ticks it was computed from.
        reason: Why there is no number, where the status alone does not say it.
    """

    value: float
    unit: str
    status: Status
    n: int
    reason: str = ""

    def as_dict(self) -> dict[str, float | str | int]:
        """Return the fields as plain numbers and words, ready for JSON (NaN and infinity stay what they are)."""
        plain: dict[str, float | str | int] = {"value": self.value, "unit": self.unit, "status": self.status}
        plain["n"] = self.n
        return plain | {"reason": self.reason} if self.reason else plain


@dataclass(frozen=True, eq=False)
class Metric(Generic[Arguments]):
    """A function of a log, with what tables and reports need to know of it; call it like the function.

    Attributes:
        id: The function's name; an id is forever.
        unit: Unit of the value.
        better: Which direction of the value is better.
        family: The file it lives in, for example ``"precision"``.
        needs: Names of its arguments, which are field names of a log.
        source: Where the definition comes from.
        label: Words for people.
        fail_value: What a failed run counts as in ratios, in ``unit``; None keeps failed runs out of ratios.
        version: Grows when the formula changes.
        function: The bare formula, without the shared checks.
        kind: What it is computed from; only metrics of a log are computed for every run.
        resolution: Smallest magnitude that it can tell from zero, in ``unit``: what a smaller one counts as in ratios.
    """

    id: str
    unit: str
    better: Better
    family: str
    needs: tuple[str, ...]
    source: str
    label: str
    fail_value: float | None
    version: int
    function: Callable[Arguments, float]
    kind: Kind = "log"
    resolution: float = 0.0

    def __post_init__(self) -> None:
        """Take over the function's name and docstring, so that help and documentation show them."""
        names = ("__module__", "__name__", "__qualname__", "__doc__")
        vars(self).update({name: getattr(self.function, name) for name in names}, __wrapped__=self.function)

    def __reduce__(self) -> str:
        # Pickled by name, like a function: worker processes import it.
        return self.id

    def __call__(self, *args: Arguments.args, **kwargs: Arguments.kwargs) -> float:
        """Check the arrays, then compute.

        Args:
            *args: As the function takes them.
            **kwargs: As the function takes them.

        Returns:
            The value; NaN if a sample is not finite or the metric has no meaning here; a :class:`Censored` number
            if it is only a bound.

        Raises:
            EmptyWindow: If there is no sample.
            UnequalLengths: If the arrays hold different numbers of ticks.
        """
        bound = inspect.signature(self.function).bind(*args, **kwargs)
        bound.apply_defaults()
        value = self.value_of(bound.arguments)
        return Censored(value.value) if value.status == "censored" else value.value

    def value_of(self, fields: Mapping[str, Any]) -> Value:
        """Compute the metric from the fields of a log, with its status.

        Args:
            fields: At least the fields in ``needs``.

        Returns:
            The value with unit, status and number of ticks.

        Raises:
            EmptyWindow: If there is no sample.
            UnequalLengths: If the arrays hold different numbers of ticks.
        """
        arguments = {name: fields[name] for name in self.needs}
        series = self._series(arguments)
        ticks = max((len(samples) for samples in series.values()), default=0)
        if not all(is_finite(samples) for samples in series.values()):
            return Value(math.nan, self.unit, "failed", ticks)
        number = self.function(**_as_arrays(arguments))  # type: ignore[call-arg]
        if isinstance(number, Censored):
            return Value(float(number), self.unit, "censored", ticks)
        if not math.isfinite(number):
            return Value(math.nan, self.unit, "undefined", ticks)
        return Value(float(number), self.unit, "ok", ticks)

    def _series(self, arguments: Mapping[str, Any]) -> dict[str, np.ndarray]:
        """Return the arguments with a row for each tick, after checking that they have equally many, and any."""
        series = {name: np.asarray(a) for name, a in arguments.items() if name not in CONSTANTS and np.ndim(a) > 0}
        lengths = {name: len(samples) for name, samples in series.items()}
        if len(set(lengths.values())) > 1:
            raise UnequalLengths(self.id, lengths)
        if 0 in lengths.values():
            raise EmptyWindow(self.id)
        return series


def _as_arrays(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments with lists turned into arrays; arrays are passed on as the same objects."""
    return {name: np.asarray(a, dtype=float) if np.ndim(a) > 0 else a for name, a in arguments.items()}


def metric(
    *,
    unit: str,
    better: Better,
    family: str,
    needs: tuple[str, ...],
    source: str,
    label: str,
    fail_value: float | None = None,
    version: int = 1,
    kind: Kind = "log",
    resolution: float = 0.0,
) -> Callable[[Callable[Arguments, float]], Metric[Arguments]]:
    """Make a metric of a function of bare arrays.

    The checks that all metrics share are done here once: no sample raises, unequal lengths raise, a sample that is
    not finite gives NaN. The function may count on finite arrays of equal length and at least one row.

    Args:
        unit: Unit of the value, for example ``"m"``; ``"1"`` for a share, which tables show as per cent, ``"-"`` for a
            number that is none.
        better: Which direction of the value is better; ``"none"`` if it only describes.
        family: The family's word, for example ``"precision"``.
        needs: The function's argument names, which are field names of a log.
        source: Where the definition comes from.
        label: Words for people.
        fail_value: What a failed run counts as in ratios, in ``unit``.
        version: Grows when the formula changes.
        kind: What it is computed from.
        resolution: Smallest magnitude that it can tell from zero, in ``unit``.

    Returns:
        A decorator that turns the function into a :class:`Metric`.

    Raises:
        TypeError: If ``needs`` differs from the function's argument names.
    """

    def decorate(function: Callable[Arguments, float]) -> Metric[Arguments]:
        names = tuple(inspect.signature(function).parameters)
        if names != needs:
            raise TypeError(f"{function.__name__} takes {names} but declares that it needs {needs}")
        words = (unit, better, family, needs, source, label)
        return Metric(function.__name__, *words, fail_value, version, function, kind, resolution)

    return decorate


def variant(
    base: Metric[...],
    name: str,
    label: str,
    *,
    function: Callable[..., float] | None = None,
    needs: tuple[str, ...] = (),
    quantity: tuple[str, str] = ("", ""),
) -> Metric[...]:
    """Make a metric that differs from another in one number or in the series it looks at.

    Args:
        base: The metric it is a variant of; assign the result in the same module, under its id.
        name: Its id.
        label: Words for people, also the first line of its docstring.
        function: The formula with the other number, taking the base's arguments by position; the base's if None.
        needs: Its arguments in the base's order; the base's if empty.
        quantity: Unit of the base's series and of its own, for example ``("rad", "m")``.
    """
    formula, names = function or base.function, needs or base.needs
    signature = inspect.Signature([inspect.Parameter(n, inspect.Parameter.POSITIONAL_OR_KEYWORD) for n in names])

    def call(*args: Any, **named: Any) -> float:
        return formula(*signature.bind(*args, **named).args)

    text = (base.__doc__ or "").partition("\n")[2]
    for old, new in zip(base.needs, names, strict=True):
        text = re.sub(rf"^( +){old}: ", rf"\g<1>{new}: ", text, flags=re.MULTILINE)
    old_unit, new_unit = quantity
    text = text.replace(f"[{old_unit}", f"[{new_unit}")
    call.__name__ = call.__qualname__ = name
    call.__module__, call.__doc__ = base.function.__module__, f"{label[0].upper()}{label[1:]}.\n{text}"
    call.__signature__ = signature  # type: ignore[attr-defined]
    unit = base.unit.replace(old_unit, new_unit)
    return replace(base, id=name, label=label, unit=unit, needs=names, function=call)
