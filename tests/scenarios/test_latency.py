"""What may be said of latency, and what is answered to the rest."""

import pytest
from torquebench.controllers import InvalidInput
from torquebench.scenarios.latency import parse_latency


@pytest.mark.parametrize(("text", "latency"), [("0", 0), ("12", 12), ("measured", "measured")])
def test_a_latency_is_a_number_of_ticks_or_measured(text, latency):
    assert parse_latency(text) == latency


@pytest.mark.parametrize("text", ["soon", "-1", "--1", "1.5", "", "1e3", "\N{SUPERSCRIPT TWO}", "True"])
def test_anything_else_is_told_what_is_valid(text):
    """In one line, with what came and where."""
    with pytest.raises(InvalidInput, match=r"--latency: latency = .*; whole ticks from 0, or 'measured'"):
        parse_latency(text)


@pytest.mark.parametrize("text", ["mesured", "measure", "measured "])
def test_a_near_miss_is_told_the_word(text):
    with pytest.raises(InvalidInput, match="did you mean 'measured'"):
        parse_latency(text)
