"""One vocabulary for what a controller computes, whether it fires spikes or multiplies matrices."""

from dataclasses import dataclass, fields


@dataclass(frozen=True, kw_only=True)
class OperationCounts:
    """Operations of some event (a tick, a solve, an iteration) or of a second.

    Synaptic operations follow NeuroBench (Yik and others, 2025): dense counts every weight at every step; effective
    only products of a non-zero weight and a non-zero input, a multiply-accumulate where the input is analogue, an
    accumulate where it is spikes. They are definitions; all other counts are operations that are carried out.

    Attributes:
        dense: Synaptic operations if every weight and input counted.
        effective_macs: Multiply-accumulates as defined.
        effective_acs: Accumulates as defined.
        macs: Multiply-accumulates of networks and solvers as carried out: one multiplication and one addition each.
        acs: Accumulates of networks as carried out: one addition each.
        multiplications: Multiplications outside them.
        additions: Additions and subtractions outside them.
        comparisons: Comparisons, minima, maxima, magnitudes, signs.
        transcendentals: Sines, cosines and other transcendental functions.
        divisions: Divisions and square roots.
        membrane_updates: Membrane potentials moved.
        random_draws: Random numbers drawn.
        learning_macs: Multiply-accumulates of learning as carried out.
        parameter_updates: Parameters moved by learning.
        touched: Numbers read from or written to memory: weights, constants, inputs, outputs, states. What comes and
            goes within one computation stays in registers and counts nothing.
    """

    dense: float = 0.0
    effective_macs: float = 0.0
    effective_acs: float = 0.0
    macs: float = 0.0
    acs: float = 0.0
    multiplications: float = 0.0
    additions: float = 0.0
    comparisons: float = 0.0
    transcendentals: float = 0.0
    divisions: float = 0.0
    membrane_updates: float = 0.0
    random_draws: float = 0.0
    learning_macs: float = 0.0
    parameter_updates: float = 0.0
    touched: float = 0.0

    def __add__(self, other: "OperationCounts") -> "OperationCounts":
        """Return both together."""
        return OperationCounts(**{name: getattr(self, name) + getattr(other, name) for name in COUNTS})

    def times(self, factor: float) -> "OperationCounts":
        """Return what so many events cost."""
        return OperationCounts(**{name: factor * getattr(self, name) for name in COUNTS})

    @property
    def arithmetic(self) -> float:
        """Elementary operations without learning, a multiply-accumulate as two; draws and membranes as one each."""
        single = self.acs + self.multiplications + self.additions + self.comparisons
        return (
            2.0 * self.macs + single + self.transcendentals + self.divisions + self.membrane_updates + self.random_draws
        )


COUNTS = tuple(field.name for field in fields(OperationCounts))
"""Names of the counts."""


@dataclass(frozen=True, kw_only=True)
class OperationCosts:
    """What a controller computes, by the events that make it compute.

    Attributes:
        by_event: What one event costs: ``ticks`` for a call of the law, else a counter of its ``operations()`` hook.
        parameters: Numbers that it keeps and that do not change by themselves: weights, gains, constants of the model.
        state: Numbers that it reads, writes or remembers from tick to tick.
        how: In words, how the figures came about.
    """

    by_event: dict[str, OperationCounts]
    parameters: int
    state: int
    how: str
