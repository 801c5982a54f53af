"""Errors of the evaluation room: a sentence for a person, data for a program."""

import difflib
from collections.abc import Mapping, Sequence


class EvaluationError(Exception):
    """Root of every error that metrics, statistics and comparisons raise."""


class EmptyWindow(EvaluationError, ValueError):
    """A metric was asked about a window that holds no sample.

    Attributes:
        metric: The metric's id.
    """

    def __init__(self, metric: str) -> None:
        self.metric = metric
        super().__init__(f"{metric}: the window holds no sample")


class InvalidLog(EvaluationError, ValueError):
    """A log of one's own that cannot be what its field names say.

    Attributes:
        field: The field's name.
        what: What came.
        valid: What would have been valid.
    """

    def __init__(self, field: str, what: str, valid: str) -> None:
        self.field, self.what, self.valid = field, what, valid
        super().__init__(f"log, {field}: {what}; {valid}")


class MissingFields(EvaluationError, ValueError):
    """A metric was asked for by name, and the log lacks what it needs.

    Attributes:
        metric: The metric's id.
        missing: Names of the fields.
    """

    def __init__(self, metric: str, missing: Sequence[str]) -> None:
        self.metric, self.missing = metric, tuple(missing)
        super().__init__(f"{metric} needs {', '.join(missing)}, which the log does not have")


class UnequalLengths(EvaluationError, ValueError):
    """Arrays of one log that do not hold the same number of ticks.

    Attributes:
        metric: The metric's id.
        lengths: Number of ticks by argument name.
    """

    def __init__(self, metric: str, lengths: Mapping[str, int]) -> None:
        self.metric, self.lengths = metric, dict(lengths)
        counts = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        super().__init__(f"{metric}: arrays of unequal length: {counts} ticks")


class UnknownMetric(EvaluationError, KeyError):
    """A metric id that nobody registered.

    Attributes:
        name: The id that came.
        known: The ids that would have been valid.
    """

    def __init__(self, name: str, known: Sequence[str]) -> None:
        self.name, self.known = name, tuple(known)
        nearest = difflib.get_close_matches(name, known, n=1)
        hint = f"; did you mean {nearest[0]!r}?" if nearest else f"; known: {', '.join(sorted(known))}"
        super().__init__(f"unknown metric {name!r}{hint}")

    def __str__(self) -> str:
        # KeyError prints the repr of its argument, which would quote the whole sentence.
        return str(self.args[0])


class UnknownWindow(EvaluationError, ValueError):
    """A window name that has no definition.

    Attributes:
        name: The name that came.
        known: The names that would have been valid.
    """

    def __init__(self, name: str, known: Sequence[str]) -> None:
        self.name, self.known = name, tuple(known)
        super().__init__(f"unknown window {name!r}; known: {', '.join(known)}")


class UnknownMotionSet(EvaluationError, ValueError):
    """A set of motions that has no definition.

    Attributes:
        name: The name that came.
        known: The names that would have been valid.
    """

    def __init__(self, name: str, known: Sequence[str]) -> None:
        self.name, self.known = name, tuple(known)
        super().__init__(f"unknown set of motions {name!r}; known: {', '.join(known)}")


class TooFewUnits(EvaluationError, ValueError):
    """A statistic that would be misleading at this sample size.

    Attributes:
        statistic: What was asked for.
        n: How many values came.
        minimum: How many it takes.
    """

    def __init__(self, statistic: str, n: int, minimum: int) -> None:
        self.statistic, self.n, self.minimum = statistic, n, minimum
        super().__init__(f"{statistic} needs at least {minimum} values, got {n}")


class AmbiguousRuns(EvaluationError, ValueError):
    """Two runs of one controller claim the same cell and repetition, so pairing has no meaning.

    Attributes:
        controller: Whose runs they are.
        key: Trajectory, mass, material, repetition.
    """

    def __init__(self, controller: str, key: tuple[object, ...]) -> None:
        self.controller, self.key = controller, key
        super().__init__(
            f"{controller} has more than one run for {key}; compare one plant, tier and set of laps at a time"
        )


class NothingToCompare(EvaluationError, ValueError):
    """Two controllers that share no usable pair of runs.

    Attributes:
        controller: The first controller.
        reference: The reference controller.
        reason: Why nothing is left.
    """

    def __init__(self, controller: str, reference: str, reason: str) -> None:
        self.controller, self.reference, self.reason = controller, reference, reason
        super().__init__(f"{controller} against {reference}: {reason}")
