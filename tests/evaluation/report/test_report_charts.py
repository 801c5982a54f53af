"""Charts as data: no peak lost by thinning, ticks within the axis, text that is no markup."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.report.charts import Axis, Chart, Curve, around, thinned
from torquebench.evaluation.report.drawing import draw, draw_file
from torquebench.evaluation.report.spread import gathered, spread_cell


@given(st.integers(0, 2**32 - 1), st.integers(500, 5000))
def test_thinning_keeps_both_ends_and_every_peak(seed, rows):
    y = np.random.default_rng(seed).normal(size=rows)
    x, kept = thinned(np.arange(rows), y, 50)
    assert len(kept) <= 102
    assert (kept.max(), kept.min()) == (y.max(), y.min())
    assert (x[0], x[-1]) == (0, rows - 1)
    assert (np.diff(x) > 0).all()


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
def test_ticks_lie_on_the_axis_and_are_few(low, span):
    ticks = Axis("", low, low + span).ticks()
    assert 2 <= len(ticks) <= 8
    assert all(low - 1e-6 * span <= value <= low + 1.000001 * span for value, _ in ticks)


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=5))
def test_an_axis_shows_every_value(values):
    axis = around("", [np.array(values)])
    assert all(0.0 <= axis.place(value) <= 1.0 for value in values)


def test_an_axis_of_nothing_is_still_an_axis():
    assert len(around("", []).ticks()) >= 2
    assert len(around("", [np.array([np.nan])], log=True).ticks()) >= 1


def chart(label, **changes):
    line = Curve(label=label, x=np.arange(4.0), y=np.array([1.0, np.nan, 2.0, 3.0]), dots=True)
    settings = {"x": Axis("t [s]", 0.0, 3.0), "y": Axis("y", 0.0, 4.0), "events": [(1.0, "+2 kg")]}
    return Chart(id="w1-a", title=label, description=label, curves=[line, line], **{**settings, **changes})


@pytest.mark.parametrize("direct", [True, False])
@pytest.mark.parametrize("render", [draw, draw_file])
def test_what_a_user_types_is_text_in_a_drawing(render, direct):
    text = render(chart("<b>&x</b>", direct=direct))
    assert "<b>" not in text
    ET.fromstring(text)


def test_a_gap_is_no_point():
    assert draw(chart("a")).count("<circle") == 6


def test_labels_at_the_ends_of_curves_do_not_overlap():
    curves = [Curve(label=f"law {i}", x=np.arange(2.0), y=np.array([1.0, 1.0 + 1e-3 * i]), style=i) for i in range(8)]
    root = ET.fromstring(draw(chart_of(curves)))
    places = sorted(float(text.get("y")) for text in root.iter("text") if text.get("class") == "end")
    assert len(places) == 8
    assert min(np.diff(places)) >= 12.9
    assert places[-1] < 300


def chart_of(curves):
    return Chart(
        id="w1-b", title="b", description="b", x=Axis("", 0.0, 1.0), y=Axis("", 0.0, 2.0), curves=curves, direct=True,
        height=300,
    )  # fmt: skip


def test_a_spread_says_what_it_could_not_count():
    entries = [{"value": v, "status": "ok"} for v in (1.0, 3.0)]
    entries += [{"value": float("inf"), "status": "censored"}, {"value": None, "status": "undefined"}, None]
    spread = gathered(entries)
    assert spread.median == 3.0
    assert spread.missing == 2
    cell = spread_cell(spread, "s", 2)
    assert (cell.text, cell.note) == ("3.00", "[1.00..never] 1 of 3 never 1 missing 1 undefined")


def test_profiles_stand_beside_the_comparisons(quick):
    """A ratio hides what a failed run costs; the distribution shows it, and says how much is within the reference's."""
    assert (quick.files.figures / "w1-profile-position.svg").is_file()
    assert (quick.files.figures / "w1-profile-orientation.svg").is_file()
    assert "in the same cell: " in quick.html
    assert "flexiv_full_ff / none: 96 %" in quick.html


def test_a_figure_that_cannot_show_all_says_so_and_keeps_the_spiking_one(shelf):
    """Nine laws and the one that the comparison is about, last: five of nine, and it."""
    sizes = {(f"law_{number}", "none"): 1e-3 * (1 + number) for number in range(8)}
    shelf.grid(sizes | {("flexiv_factory", "none"): 2e-2, ("cbmc_v3", "none"): 5e-2}, masses=(1.5,))
    page = shelf.campaign().report()
    of_all = "of flexiv_factory / none: the first 5 of 9 and cbmc_v3 / none"
    assert f"Share of runs within a multiple of the position error {of_all}" in page.html


def test_a_figure_of_all_says_nothing_of_the_first(quick):
    assert ": the first " not in quick.html
