"""Numbers and axes of the page."""

import math

import pytest
from torquebench.evaluation.report.numbers import counting, decimals_for, fixed, ratio_text, significant, times_lower
from torquebench.evaluation.report.scale import LogScale


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.4369, "0.437"), (17.23, "17.2"), (1234.0, "1234"), (0.0, "0"), (0.99996, "1.00"), (-2.5, "−2.50")],
)
def test_three_digits_are_enough(value, text):
    assert significant(value) == text


def test_a_column_has_one_number_of_decimals():
    assert decimals_for([0.44, 17.2]) == 2
    assert decimals_for([17.2, 25.4]) == 1
    assert decimals_for([812.0, 13400.0]) == 0
    assert decimals_for([math.nan, 0.0]) == 0


def test_a_rounded_zero_has_no_sign():
    assert fixed(-0.001, 1) == "0.0"


@pytest.mark.parametrize(
    ("value", "text"), [(0.0264, "0.026"), (0.18, "0.18"), (0.997, "0.997"), (1.0, "1.00"), (39.4, "39")]
)
def test_a_ratio_never_hides_its_side_of_one(value, text):
    assert ratio_text(value) == text


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (1 / 39, "39 times lower"),
        (0.88, "12 % lower"),
        (1.12, "12 % higher"),
        (2.0, "2 times higher"),
        (99.6, "100 times higher"),
    ],
)
def test_ratios_in_words(ratio, words):
    assert times_lower(ratio) == words


@pytest.mark.parametrize("values", [[1.0], [0.9, 1.1], [0.02, 1.0], [1e-6, 1e6], [3.0, 3.2], [0.5, 200.0]])
def test_every_axis_has_a_few_round_ticks_within_its_ends(values):
    scale = LogScale.around(values)
    ticks = scale.ticks()
    assert 2 <= len(ticks) <= 9
    assert all(scale.holds(tick) for tick in ticks)
    assert all(0.0 < scale.percent(value) < 100.0 for value in values)


def test_names_are_sorted_as_people_count():
    names = ["M10", "T1", "M2", "lissajous", "M1", "S3"]
    assert sorted(names, key=counting) == ["M1", "M2", "M10", "S3", "T1", "lissajous"]
