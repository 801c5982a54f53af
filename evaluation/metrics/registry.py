"""What makes a function of a log a metric: its record, and the checks that all metrics share."""

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, Literal, ParamSpec

import numpy as np

from ..errors import EmptyWindow, UnequalLengths
from .shared import is_finite

Arguments = ParamSpec("Arguments")
Better = Literal["lower", "higher", "none"]
Status = Literal["ok", "censored", "failed", "undefined"]

UNDEFINED = math.nan
"""What a metric returns where it has no meaning: the time lag of a reference that rests, the rate of one sample."""

CONSTANTS = frozenset({"dt", "lap", "effort", "torque_rate", "velocity", "lower", "upper"})
"""Fields of a log that hold one value for the whole run; all others have a row for each tick."""


class Censored(float):
    """A metric's value that is only a bound: the truth lies at it or beyond."""


@dataclass(frozen=True)
class Value:
    """One metric of one window of one run.

    Attributes:
        value: The number, in ``unit``; NaN if failed or undefined.
        unit: Its unit.
        status: ``ok``; ``censored``, a bound only; ``failed``, a sample was not finite; ``undefined``, no meaning here.
        n: Number of ticks it was computed from.
    """

    value: float
    unit: str
    status: Status
    n: int

    def as_dict(self) -> dict[str, float | str | int]:
        """Return the fields as plain numbers and words, ready for JSON (NaN stays NaN)."""
        return {"value": self.value, "unit": self.unit, "status": self.status, "n": self.n}


@dataclass(frozen=True, eq=False)
class Metric(Generic[Arguments]):
    """A function of a log, with what tables and reports need to know of it; call it like the function.

    Attributes:
        id: The function's name; an id is forever.
        unit: Unit of the value.
        better: Which direction of the value's magnitude is better.
        family: The file it lives in, for example ``"precision"``.
        needs: Names of its arguments, which are field names of a log.
        source: Where the definition comes from.
        label: Words for people.
        fail_value: What a failed run counts as in ratios, in ``unit``; None keeps failed runs out of ratios.
        version: Grows when the formula changes.
        function: The bare formula, without the shared checks.
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
        if not math.isfinite(number):
            return Value(math.nan, self.unit, "undefined", ticks)
        return Value(float(number), self.unit, "censored" if isinstance(number, Censored) else "ok", ticks)

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
) -> Callable[[Callable[Arguments, float]], Metric[Arguments]]:
    """Make a metric of a function of bare arrays.

    The checks that all metrics share are done here once: no sample raises, unequal lengths raise, a sample that is
    not finite gives NaN. The function may count on finite arrays of equal length and at least one row.

    Args:
        unit: Unit of the value, for example ``"m"``.
        better: Which direction of the value's magnitude is better; ``"none"`` if it only describes.
        family: The family's word, for example ``"precision"``.
        needs: The function's argument names, which are field names of a log.
        source: Where the definition comes from.
        label: Words for people.
        fail_value: What a failed run counts as in ratios, in ``unit``.
        version: Grows when the formula changes.

    Returns:
        A decorator that turns the function into a :class:`Metric`.

    Raises:
        TypeError: If ``needs`` differs from the function's argument names.
    """

    def decorate(function: Callable[Arguments, float]) -> Metric[Arguments]:
        names = tuple(inspect.signature(function).parameters)
        if names != needs:
            raise TypeError(f"{function.__name__} takes {names} but declares that it needs {needs}")
        return Metric(function.__name__, unit, better, family, needs, source, label, fail_value, version, function)

    return decorate
