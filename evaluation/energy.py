"""Labelled estimates of what computing a control law costs: counts times energies from a table, never a measurement.

The table stands in ``data/energy_per_operation.toml`` with its source, its technology and what in it was assumed.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

LEARNING = ("learning_macs", "parameter_updates")
"""Operations that only learning does."""
BYTES_PER_ACCESS = 8
"""A memory of the table is read 64 bits at a time."""
MICRO, PICO = 1e6, 1e-12


@dataclass(frozen=True)
class Price:
    """Energy of one operation.

    Attributes:
        picojoules: Energy [pJ].
        basis: What it is made of.
        assumed: Whether the source does not print it.
    """

    picojoules: float
    basis: str
    assumed: bool


@dataclass(frozen=True)
class Memory:
    """A memory of the table.

    Attributes:
        name: For people.
        size: What it holds, None without bound [bytes].
        picojoules: Energy of an access of 64 bits [pJ].
    """

    name: str
    size: int | None
    picojoules: float


@dataclass(frozen=True, kw_only=True)
class EnergyTable:
    """Energies of single operations.

    Attributes:
        technology: Of the circuits that they stand for.
        number: Of which they are operations.
        bytes_per_number: Size of a number.
        source: Where they come from.
        measured: Whether this project measured them: never.
        operations: Price of each operation by its name.
        memories: Smallest first.
    """

    technology: str
    number: str
    bytes_per_number: int
    source: str
    measured: bool
    operations: Mapping[str, Price]
    memories: tuple[Memory, ...]

    def memory_for(self, numbers: float) -> Memory:
        """Return the smallest memory that holds so many numbers."""
        needed = numbers * self.bytes_per_number
        return next(memory for memory in self.memories if memory.size is None or needed <= memory.size)


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What computing is estimated to cost, as power: energy for a second of simulated time.

    Attributes:
        inference: Arithmetic without learning [uW].
        learning: Arithmetic of learning [uW].
        memory: Traffic alone [uW].
        level: Name of the memory that the traffic goes to.
    """

    inference: float
    learning: float
    memory: float
    level: str

    @property
    def arithmetic(self) -> float:
        """All arithmetic [uW]."""
        return self.inference + self.learning

    @property
    def with_memory(self) -> float:
        """Arithmetic and traffic [uW]."""
        return self.arithmetic + self.memory


@cache
def energy_table() -> EnergyTable:
    """Return the table that ships."""
    text = (files("torquebench.evaluation") / "data" / "energy_per_operation.toml").read_text(encoding="utf-8")
    read = tomllib.loads(text)
    prices = {
        name: Price(entry["picojoules"], entry["basis"], entry.get("assumed", False))
        for name, entry in read["operation"].items()
    }
    memories = [Memory(entry["name"], entry.get("bytes"), entry["picojoules"]) for entry in read["memory"]]
    return EnergyTable(
        technology=read["technology"],
        number=read["number"],
        bytes_per_number=read["bytes_per_number"],
        source=read["source"],
        measured=read["measured"],
        operations=prices,
        memories=tuple(memories),
    )


def estimate(counts: Mapping[str, float], *, touched: float, kept: float, table: EnergyTable | None = None) -> Estimate:
    r"""Return what counts are estimated to cost.

    .. math:: P = \sum_i n_i e_i, \quad P_\text{memory} = n_\text{touched} \, \frac{\text{bytes}}{8} \, e_\text{memory}

    Args:
        counts: Operations by name, for a second of simulated time; names without a price are definitions and cost
            nothing.
        touched: Numbers read from or written to memory in that second.
        kept: Numbers that the controller keeps, parameters and state: they decide which memory it needs.
        table: Prices; those that ship if None.
    """
    prices = table or energy_table()
    powers = {name: counts.get(name, 0.0) * price.picojoules for name, price in prices.operations.items()}
    memory = prices.memory_for(kept)
    accesses = touched * prices.bytes_per_number / BYTES_PER_ACCESS
    to_power = PICO * MICRO
    return Estimate(
        inference=to_power * sum(power for name, power in powers.items() if name not in LEARNING),
        learning=to_power * sum(powers[name] for name in LEARNING),
        memory=to_power * accesses * memory.picojoules,
        level=memory.name,
    )
