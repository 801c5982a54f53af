"""Spreads and tables: medians with their range, words where there is no number, and one CSV behind each table."""

import csv
import io
import math
from urllib.parse import unquote

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.report.numbers import MINUS, p_value, significant, times_lower, unit_on_page
from torquebench.evaluation.report.panel_exports import _spread as exported
from torquebench.evaluation.report.spread import Spread, gathered, spread_cell
from torquebench.evaluation.report.table import (
    Cell,
    Column,
    Reading,
    Table,
    columns_to_rows,
    head_cells,
    number_cells,
    stored_reading,
    word_cell,
)

NEVER = (math.inf, "censored")


def spread(*values):
    """Return a spread of numbers, or of pairs of a number and its status."""
    found = Spread()
    for value in values:
        found.add(*(value if isinstance(value, tuple) else (value, "ok")))
    return found


@pytest.mark.parametrize(
    ("values", "median"),
    [
        ((3.0,), 3.0),
        ((1.0, 2.0), 1.5),
        ((5.0, 1.0, 2.0), 2.0),
        ((1.0, NEVER), math.inf),
        ((1.0, 2.0, NEVER), 2.0),
        ((1.0, 2.0, NEVER, NEVER), math.inf),
        ((NEVER,), math.inf),
    ],
)
def test_the_median_is_never_where_half_never_came(values, median):
    """The mean of 2 s and never is never; a median that looked measured would hide half of the runs."""
    assert spread(*values).median == median


def test_nothing_has_no_median():
    """Not zero."""
    assert math.isnan(Spread().median)
    assert exported(Spread())["low"] is None


@given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=9))
def test_the_order_of_runs_does_not_matter(values):
    """Workers finish in any order."""
    assert spread(*values).median == spread(*reversed(values)).median


@pytest.mark.parametrize(
    ("value", "status", "word"),
    [
        (None, "ok", "undefined"),
        (math.nan, "ok", "undefined"),
        (math.inf, "ok", "undefined"),
        (math.nan, "censored", "undefined"),
        (1.0, "failed", "failed"),
        (1.0, "undefined", "undefined"),
        ("3", "ok", "undefined"),
        (None, "missing", "missing"),
    ],
)
def test_what_is_no_number_is_counted_under_its_word(value, status, word):
    """An infinity that nobody called censored is a slip, not a recovery that never came."""
    found = spread((value, status))
    assert (found.values, dict(found.others), found.missing) == ([], {word: 1}, 1)


def test_a_bound_that_is_finite_is_a_number():
    """At least 3 s is 3 s in a median."""
    assert spread((3.0, "censored")).values == [3.0]


def test_a_reason_that_all_share_stands_in_the_cell():
    """Two reasons do not fit; one explains the whole row."""
    entries = [{"value": None, "status": "undefined", "reason": "twin failed"}] * 3
    cell = spread_cell(gathered(entries), "s", 2)
    assert (cell.text, cell.note, cell.value, cell.kind) == ("\N{EMPTY SET} undefined", "twin failed", None, "missing")
    two = [*entries, {"value": None, "status": "undefined", "reason": "the run ends at 5 s"}]
    assert spread_cell(gathered(two), "s", 2).note == ""


@pytest.mark.parametrize(
    ("values", "unit", "decimals", "text", "note"),
    [
        ((0.0123, 0.0125), "rad", 1, "12.4", "[12.3..12.5]"),
        ((0.92, 0.94), "s", 2, "0.93", "[0.92..0.94]"),
        ((0.25,), "1", 1, "25.0", ""),
        ((2.0, 3.0), "", 0, "2.5", "[2..3]"),
        ((2.0, 4.0), "", 0, "3", "[2..4]"),
        ((-0.5, -0.7), "", 3, f"{MINUS}0.600", f"[{MINUS}0.700..{MINUS}0.500]"),
        ((1.0, NEVER, NEVER), "s", 2, "never", "[1.00..never] 2 of 3 never"),
        ((NEVER, NEVER), "s", 2, "never", "2 of 2 never"),
    ],
)
def test_a_median_stands_with_its_range_in_the_pages_unit(values, unit, decimals, text, note):
    """Radians as milliradians, shares as per cent; times of recovery stay in seconds."""
    cell = spread_cell(spread(*values), unit, decimals)
    assert (cell.text, cell.note) == (text, note)
    assert (cell.kind == "bad") == (text == "never")


def test_the_number_behind_a_cell_sorts_as_it_reads():
    """Sorting by a stored unit under a header in another would shuffle mixed columns."""
    assert spread_cell(spread(0.0123), "rad", 1).value == pytest.approx(12.3)
    assert spread_cell(spread(NEVER), "s", 1).value is None


def test_an_export_is_in_stored_units_and_counts_what_never_came():
    """Programs get radians and seconds, and null instead of a word."""
    found = exported(spread(0.01, 0.03, NEVER, (None, "failed")))
    assert found == {
        "median": 0.03,
        "low": 0.01,
        "high": 0.03,
        "n": 3,
        "never": 1,
        "without_value": {"failed": 1},
    }


def table(*columns, rows=(), **changes):
    """Return a table of a few columns."""
    return Table(**{"id": "t", "caption": "c", "columns": list(columns), "rows": list(rows)} | changes)


def test_columns_that_share_a_header_stand_under_one():
    """Neighbours only: two groups of one name apart are two headers."""
    names = ("", "Size", "Size", "", "Size")
    assert table(*(Column("x", group=name) for name in names)).groups == [("", 1), ("Size", 2), ("", 1), ("Size", 1)]
    assert table(Column("x"), Column("y")).groups == []


def test_a_note_names_its_column_as_a_reader_sees_it():
    """The same word may stand under two headers; TCP stays TCP."""
    notes = table(
        Column("Peak", group="Size", note="a"),
        Column("TCP", group="Size", note="b"),
        Column("n", note="c"),
        Column("m"),
    ).notes
    assert notes == [("Size, peak", "a"), ("Size, TCP", "b"), ("n", "c")]


def test_the_csv_behind_a_table_has_its_numbers_and_its_words():
    """Six digits instead of the three on the page; a cell without a number keeps its word."""
    rows = [(Cell('law, "mine"', kind="head"), Cell("12.3", 12.345678)), (Cell("b"), word_cell("refused"))]
    link = table(Column("Controller"), Column("Error", "mm"), rows=rows).data_link
    head, _, content = link.partition(",")
    assert head == "data:text/csv;charset=utf-8"
    assert list(csv.reader(io.StringIO(unquote(content)))) == [
        ["Controller", "Error [mm]"],
        ['law, "mine"', "12.3457"],
        ["b", "\N{EMPTY SET} refused"],
    ]
    assert not set(' "\n<>') & set(link)


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        (None, Reading(None, "missing")),
        ({"value": 1, "status": "ok"}, Reading(1.0, "ok")),
        ({"value": 0.5, "status": "censored"}, Reading(0.5, "censored")),
        ({"value": math.nan, "status": "failed"}, Reading(None, "failed")),
        ({"value": math.inf, "status": "censored"}, Reading(None, "undefined")),
        ({"value": None}, Reading(None, "undefined")),
        ({"value": "fast", "status": "ok"}, Reading(None, "undefined")),
    ],
)
def test_a_stored_value_is_a_number_or_a_word(entry, expected):
    """What a store holds may be of another version; nothing but a finite number is shown as one."""
    metrics = {"run": {"m": entry}} if entry is not None else {}
    assert stored_reading(metrics, "run", "m") == expected


def test_a_column_has_one_number_of_decimals_and_bounds_are_marked():
    """Numbers can be compared down a column; a bound never reads as a measurement."""
    cells = number_cells([Reading(0.0174), Reading(0.00043), Reading(0.02, "censored"), Reading(None, "failed")], "m")
    assert [cell.text for cell in cells] == [
        "17.40",
        "0.43",
        "\N{GREATER-THAN OR EQUAL TO} 20.00",
        "\N{EMPTY SET} failed",
    ]
    assert [cell.value for cell in cells] == [pytest.approx(17.4), pytest.approx(0.43), pytest.approx(20.0), None]


def test_a_cell_keeps_what_it_had_besides_its_number():
    """Links and notes survive where there is no number too: that is where they explain something."""
    dressed = Cell("", href="#run-1", note="1 failed")
    (number, word) = number_cells([Reading(1.0, cell=dressed), Reading(None, "failed", cell=dressed)], "")
    assert {(cell.href, cell.note) for cell in (number, word)} == {("#run-1", "1 failed")}


def test_columns_of_different_length_make_no_table():
    """A row that slipped by one would put every number beside the wrong name."""
    assert columns_to_rows([head_cells(["a", "b"]), [Cell("1"), Cell("2")]])[1][0].text == "b"
    with pytest.raises(ValueError, match="shorter"):
        columns_to_rows([head_cells(["a", "b"]), [Cell("1")]])


@pytest.mark.parametrize(
    ("unit", "text", "factor"),
    [("m", "mm", 1e3), ("rad", "mrad", 1e3), ("1", "%", 1e2), ("s", "ms", 1e3), ("N m/s", "N m/s", 1.0)],
)
def test_units_on_the_page_are_those_of_the_field(unit, text, factor):
    """A factor and a word that belong together: a change of one alone is wrong by a thousand."""
    shown = unit_on_page(unit)
    assert (shown.text, shown.of(2.0)) == (text, 2.0 * factor)


@pytest.mark.parametrize(
    ("p", "text"), [(0.00005, "< 0.0001"), (0.0001, "0.0001"), (0.0078, "0.0078"), (0.0312, "0.031")]
)
def test_a_p_value_is_never_zero(p, text):
    """An exact test over eight paths cannot go below 1/256; nothing else can go to nothing either."""
    assert p_value(p) == text


@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.8, 0.95])
def test_words_of_a_ratio_and_of_its_inverse_are_opposites(ratio):
    """Whichever of the two is the reference, the sentence tells the same."""
    here, there = times_lower(ratio), times_lower(1.0 / ratio)
    assert here.endswith("lower") and there.endswith("higher")
    if ratio < 0.6:
        assert here.split()[0] == there.split()[0]


def test_a_ratio_to_nothing_is_no_number():
    """No error at all is infinitely better, and no figure says so."""
    assert times_lower(0.0) == "incomparably lower"
    assert times_lower(math.inf) == "incomparably higher"


@given(st.floats(1e-6, 1e6), st.integers(1, 4))
def test_significant_digits_lose_no_more_than_half_of_the_last(value, digits):
    """Read back, the text is the number within its own precision."""
    shown = float(significant(value, digits))
    assert abs(shown - value) <= 0.5 * 10.0 ** (math.floor(math.log10(value)) - digits + 1) * 1.0001
