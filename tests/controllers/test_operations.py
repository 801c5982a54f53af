"""The vocabulary of counts is linear: what events cost adds up."""

from torquebench.controllers.operations import COUNTS, OperationCounts


def test_counts_add_and_scale_name_by_name():
    one = OperationCounts(**{name: float(place) for place, name in enumerate(COUNTS)})
    assert one + one == one.times(2.0)
    assert one + OperationCounts() == one


def test_a_multiply_accumulate_is_two_operations_and_learning_and_definitions_are_none():
    assert OperationCounts(macs=3, acs=2, divisions=1).arithmetic == 9
    assert OperationCounts(dense=5, effective_acs=5, learning_macs=5, parameter_updates=5, touched=5).arithmetic == 0
