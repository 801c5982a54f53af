"""Estimates: prices times counts, labelled, with figures that can be worked out by hand."""

from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.controllers.operations import OperationCounts
from torquebench.evaluation.energy import LEARNING, energy_table, estimate

DEFINITIONS = {"dense", "effective_macs", "effective_acs", "touched"}
"""Counts that are no operations carried out, and so have no price."""


def test_nothing_in_the_table_was_measured_and_all_of_it_has_a_source():
    """A price that looks measured would make the estimates look measured."""
    table = energy_table()
    assert table.measured is False
    assert "Horowitz" in table.source and "45 nm" in table.technology
    assert all(price.assumed == ("assumed" in price.basis) for price in table.operations.values())


def test_every_operation_of_the_vocabulary_has_a_price():
    """A count without a price would be free of charge, in silence."""
    assert {field.name for field in fields(OperationCounts)} - DEFINITIONS == set(energy_table().operations)


def test_the_source_prints_a_multiplication_and_an_addition():
    prices = energy_table().operations
    assert (prices["multiplications"].picojoules, prices["additions"].picojoules) == (3.7, 0.9)
    assert prices["macs"].picojoules == pytest.approx(3.7 + 0.9)
    assert prices["acs"].picojoules == prices["additions"].picojoules


@pytest.mark.parametrize(("share", "microwatts"), [(0.02, 4.9), (0.10, 9.2), (1.0, 57.0)])
def test_a_cerebellum_of_the_papers_size_costs_by_its_spikes(share, microwatts):
    """59.2 M accumulates a second if all neurons fire, 0.84 M products: figures worked out apart from this code."""
    found = estimate({"acs": share * 59.2e6, "macs": 0.84e6}, touched=0.0, kept=0.0)
    assert found.inference == pytest.approx(microwatts, rel=0.01)


def test_inverse_dynamics_of_the_prototype_costs_what_was_worked_out():
    """516 products and 404 sums a thousand times a second."""
    found = estimate({"multiplications": 516e3, "additions": 404e3}, touched=0.0, kept=0.0)
    assert found.arithmetic == pytest.approx(2.27, abs=0.01)


@pytest.mark.parametrize(
    ("kept", "level", "picojoules"),
    [(2048, "8 kB", 10.0), (2049, "32 kB", 20.0), (262_144, "1 MB", 100.0), (301_480, "DRAM", 1300.0)],
)
def test_traffic_goes_to_the_smallest_memory_that_holds_everything(kept, level, picojoules):
    """Two numbers of 32 bits come with an access of 64; the paper's two networks do not fit a megabyte."""
    found = estimate({}, touched=2e6, kept=kept)
    assert found.level == level
    assert found.memory == pytest.approx(picojoules)
    assert found.with_memory == found.memory


def test_learning_stands_apart_from_inference():
    found = estimate({"macs": 1e6, **dict.fromkeys(LEARNING, 1e6)}, touched=0.0, kept=0.0)
    assert found.inference == pytest.approx(4.6)
    assert found.learning == pytest.approx(4.6 + 9.2)
    assert found.arithmetic == found.inference + found.learning


@given(st.dictionaries(st.sampled_from(sorted(energy_table().operations)), st.floats(0.0, 1e9)), st.floats(0.0, 10.0))
def test_twice_the_work_is_twice_the_estimate(counts, factor):
    once = estimate(counts, touched=1e6, kept=100.0)
    more = estimate({name: factor * count for name, count in counts.items()}, touched=factor * 1e6, kept=100.0)
    assert more.with_memory == pytest.approx(factor * once.with_memory)


def test_definitions_cost_nothing():
    """Synapses that would count if every neuron fired were not computed."""
    assert estimate(dict.fromkeys(DEFINITIONS, 1e9), touched=0.0, kept=0.0).with_memory == 0.0


counted = st.dictionaries(st.sampled_from(sorted(energy_table().operations)), st.floats(0.0, 1e9), max_size=6)


@given(counted, counted)
def test_two_jobs_cost_what_each_costs(one, other):
    """Nothing is cheaper by being counted together: an ablation's saving is the cost of what it leaves out."""
    both = {name: one.get(name, 0.0) + other.get(name, 0.0) for name in {*one, *other}}
    parts = [estimate(job, touched=1e6, kept=10.0) for job in (one, other)]
    whole = estimate(both, touched=2e6, kept=10.0)
    assert whole.inference == pytest.approx(sum(part.inference for part in parts))
    assert whole.learning == pytest.approx(sum(part.learning for part in parts))
    assert whole.with_memory == pytest.approx(sum(part.with_memory for part in parts))


@given(st.lists(st.floats(0.0, 1e7), min_size=2, max_size=6))
def test_who_keeps_more_never_reads_it_for_less(kept):
    """Memories get dearer as they grow; a table out of order would reward a larger network."""
    powers = [estimate({}, touched=1e6, kept=numbers).memory for numbers in sorted(kept)]
    assert powers == sorted(powers)


def test_every_memory_holds_exactly_what_it_is_said_to():
    """The last number that fits, and the first that does not; without bound only the last of them."""
    table = energy_table()
    *bounded, unbounded = table.memories
    assert unbounded.size is None and all(memory.size is not None for memory in bounded)
    for memory, larger in zip(bounded, [*bounded[1:], unbounded], strict=True):
        numbers = memory.size // table.bytes_per_number
        assert table.memory_for(numbers) == memory and table.memory_for(numbers + 1) == larger


def test_other_prices_make_another_estimate():
    """A reader with a table of her own hardware: twice the price, twice the power, the memory as it was."""
    table = energy_table()
    dearer = {name: replace(price, picojoules=2.0 * price.picojoules) for name, price in table.operations.items()}
    counts = {"macs": 1e6, "learning_macs": 1e6}
    plain, dear = (estimate(counts, touched=1e6, kept=1.0, table=t) for t in (table, replace(table, operations=dearer)))
    assert (dear.inference, dear.learning) == pytest.approx((2.0 * plain.inference, 2.0 * plain.learning))
    assert dear.memory == plain.memory > 0.0
