"""Drawings: where a value lies on the paper, which line is whose, and what a reader without eyes is told."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from torquebench.evaluation.report.charts import STYLES, Axis, Chart, Curve, around, at_ends, thinned
from torquebench.evaluation.report.drawing import draw, draw_file, swatch, wrap_file
from torquebench.evaluation.report.scale import LogScale

SVG = "{http://www.w3.org/2000/svg}"


def line(label="law", y=(0.0, 5.0, 10.0), **changes):
    """A curve over three seconds."""
    return Curve(label=label, x=np.arange(float(len(y))), y=np.array(y, dtype=float), **changes)


def chart(*curves, **changes):
    """A chart from 0 to 2 s and from 0 to 10 mrad."""
    settings = {"x": Axis("t [s]", 0.0, 2.0), "y": Axis("e [mrad]", 0.0, 10.0), "id": "w1-a", "title": "Error"}
    return Chart(curves=curves, description="An error over time.", **settings | changes)


def points(text, class_name):
    """Return the corners of the first path of a class, shape (K, 2)."""
    path = re.search(rf'<path (?:d="(?P<d1>[^"]+)" )?class="{class_name}[^"]*"(?: d="(?P<d2>[^"]+)")?', text)
    corners = (path["d1"] or path["d2"]).strip("MZ").split("L")
    return np.array([[float(number) for number in corner.split()] for corner in corners])


def test_a_larger_value_is_higher_and_a_later_one_further_right():
    """Pixels count downwards, errors do not: three points on a line stay on a line."""
    (x0, y0), (x1, y1), (x2, y2) = points(draw(chart(line())), "curve")
    assert x0 < x1 < x2 and y0 > y1 > y2
    assert x1 == pytest.approx((x0 + x2) / 2.0, abs=0.11)
    assert y1 == pytest.approx((y0 + y2) / 2.0, abs=0.11)


def test_ticks_and_values_agree_on_where_they_are():
    """The tick at 5 mrad and the sample of 5 mrad have one height."""
    text = draw(chart(line()))
    heights = {
        label: float(y) for y, label in re.findall(r'<text class="tick" x="[\d.]+" y="([\d.]+)"[^>]*>(\d+)<', text)
    }
    assert heights["4"] - 4.0 > points(text, "curve")[1, 1] > heights["6"] - 4.0


def test_what_is_beyond_the_chart_stays_at_its_edge():
    """A controller that oscillates must not draw over its neighbours: a fiftieth beyond, and no further."""
    low, inside, high = points(draw(chart(line(y=(-50.0, 5.0, 1e6)))), "curve")[:, 1]
    full = points(draw(chart(line())), "curve")[:, 1]
    assert low == full[0]
    assert 0.0 <= full[2] - high <= 0.03 * (full[0] - full[2])
    assert inside == full[1]


def test_the_band_goes_out_above_and_back_below():
    """A closed shape of twice as many corners, the curve within it at every place."""
    y = np.array([2.0, 5.0, 8.0])
    text = draw(chart(line(y=y, band=(y - 1.0, y + 1.0))))
    band, curve = points(text, "band"), points(text, "curve")
    assert len(band) == 2 * len(curve)
    upper, lower = band[: len(curve)], band[len(curve) :][::-1]
    assert np.array_equal(upper[:, 0], curve[:, 0]) and np.array_equal(lower[:, 0], curve[:, 0])
    assert (upper[:, 1] < curve[:, 1]).all() and (curve[:, 1] < lower[:, 1]).all()


@pytest.mark.parametrize("y", [(np.nan, np.nan, np.nan), ()])
def test_a_curve_of_nothing_draws_nothing_and_breaks_nothing(y):
    """A diagnostic that was never a number leaves an empty chart, with its axes and a title."""
    root = ET.fromstring(draw(chart(line(y=y, dots=True))))
    assert not [path for path in root.iter("path") if "curve" in path.get("class", "")]
    assert root.find("title").text == "Error"


def test_two_curves_have_a_legend_and_one_has_none():
    """One line needs no key: the title says whose it is."""
    assert chart(line("a")).legend == []
    assert chart(line("a"), line("b", style=1)).legend == [(0, False, "a"), (1, False, "b")]
    assert chart(line("a"), line("b", style=1), direct=True).legend == []


def test_a_guide_without_a_name_is_no_entry_of_the_legend():
    """A dashed line that says nothing of a controller."""
    assert chart(line("a"), line("", plain=True), line("b", plain=True)).legend == [(0, False, "a"), (0, True, "b")]


@pytest.mark.parametrize("style", range(3 * STYLES))
def test_eighteen_lines_can_be_told_apart(style):
    """Colours repeat after six; a dash tells the seventh from the first."""
    looks = [swatch(other, plain=False) for other in range(3 * STYLES)]
    assert looks.count(looks[style]) == 1


def test_a_guide_has_one_look_whatever_its_place():
    """It is no controller and takes no colour."""
    assert len({swatch(style, plain=True) for style in range(2 * STYLES)}) == 1


def test_a_file_carries_the_legend_that_the_page_has_beside_it():
    """On its own in somebody's slides it must still say which line is whose."""
    text = draw_file(chart(line("first"), line("second", style=1), line("third", style=2)))
    root = ET.fromstring(text)
    words = [element.text for element in root.iter(f"{SVG}text") if element.text]
    assert {"first", "second", "third", "Error"} <= {word.strip() for word in words}
    assert root.find(f"{SVG}desc").text == "An error over time."
    rows = [float(element.get("y")) for element in root.iter(f"{SVG}text") if (element.text or "").strip() == "third"]
    height = float(root.get("viewBox").split()[3])
    assert rows[0] == 58.0 and height == chart().height + 30 + 18 * 2


def test_a_long_title_of_a_file_goes_on_below_and_pushes_the_drawing_down():
    """Cut off at the edge, a title would lose the end that says what is left out."""
    title = "Share of runs within a multiple of the position error of flexiv_factory / none: the first 5 of 52"
    short, long = (ET.fromstring(draw_file(chart(line(), title=text))) for text in ("Error", title))
    rows = [text for text in long.iter(f"{SVG}text") if text.get("class") == "title"]
    assert " ".join(text.text for text in rows) == title
    assert max(len(text.text) for text in rows) * 8.0 <= 460 and len(rows) == 2
    lower = float(rows[1].get("y")) - float(rows[0].get("y"))
    height = [float(root.get("viewBox").split()[3]) for root in (short, long)]
    assert height[1] - height[0] == lower > 14.0


def test_marks_of_events_stand_at_their_time():
    """The step at 1 s is where the curve has its sample of 1 s."""
    text = draw(chart(line(), events=[(1.0, "+2 kg")]))
    (x,) = re.findall(r'<path class="event" d="M([\d.]+) ', text)
    assert float(x) == points(text, "curve")[1, 0]
    assert ">+2 kg</text>" in text


def test_a_figure_of_rows_links_back_to_the_page():
    """Its rows lead to runs; within its file the page is one folder up."""
    text = wrap_file('  <a href="#runs-1"><text>a</text></a>  ', "Ratios <1>", "ratio & more", 88)
    root = ET.fromstring(text)
    assert root.find(f".//{SVG}a").get("href") == "../index.html#runs-1"
    assert root.get("height") == "158"
    assert [element.text for element in root.iter(f"{SVG}text")][::2] == ["Ratios <1>", "ratio & more"]


def test_the_last_values_are_told_to_who_cannot_see_them():
    """A description that only names the axes describes nothing."""
    assert at_ends([line("a", y=(1.0, 0.25)), line("b", y=(3.0, 1234.5))], "mrad") == (
        "a ends at 0.250 mrad; b ends at 1234 mrad"
    )
    assert at_ends([line("", y=(1.0, 2.0)), line("c", y=())], "mrad") == ""


def test_short_curves_are_not_thinned():
    """Their samples are theirs, to the same arrays."""
    x, y = np.arange(100.0), np.arange(100.0)
    kept = thinned(x, y, 50)
    assert kept[0] is x and kept[1] is y


@pytest.mark.parametrize(("low", "high"), [(0.0, 10.0), (-3.0, 4.0), (20.0, 25.0)])
def test_the_ends_of_an_axis_are_nought_and_one(low, high):
    """Linear in between: the middle is a half."""
    axis = Axis("", low, high)
    assert [axis.place(value) for value in (low, (low + high) / 2.0, high)] == pytest.approx([0.0, 0.5, 1.0])


def test_on_a_logarithmic_axis_the_middle_is_the_geometric_mean():
    """Half-way between 1 and 100 is 10; nothing and less lie before the start, not at an error."""
    axis = Axis("", 1.0, 100.0, log=True)
    assert axis.place(10.0) == pytest.approx(0.5)
    assert axis.place(0.0) < 0.0 and axis.place(-5.0) < 0.0
    assert [text for _, text in axis.ticks()] == ["1", "3", "10", "30", "100"]


def test_an_axis_that_starts_at_zero_starts_there():
    """An error chart that starts at the smallest error makes small differences look large."""
    axis = around("", [np.array([40.0, 50.0])], zero=True)
    assert axis.low == 0.0 and axis.high == pytest.approx(52.5)
    assert around("", [np.array([40.0, 50.0])]).low == pytest.approx(39.5)


def test_values_that_are_alike_get_an_axis_around_them():
    """A joint that stands still is a line in the middle of its chart, not a division by zero."""
    axis = around("", [np.full(5, 8.0)])
    assert (axis.low, axis.high) == (4.0, 12.0)
    assert around("", [np.zeros(5)]).place(0.0) == pytest.approx(0.5)


def test_what_has_no_logarithm_has_no_part_in_a_logarithmic_axis():
    """A zero among errors of a metre must not stretch the axis to minus infinity."""
    with_zero, without = (around("", [np.array(values)], log=True) for values in ([0.0, -1.0, 1.0, 10.0], [1.0, 10.0]))
    assert (with_zero.low, with_zero.high) == (without.low, without.high)


@pytest.mark.parametrize(
    ("value", "place"), [(0.0, 0.0), (-1.0, 0.0), (1e-9, 0.0), (1e9, 100.0), (float("inf"), 100.0)]
)
def test_what_lies_beyond_a_scale_lies_on_its_end(value, place):
    """An interval that goes on for ever ends at the edge of the figure, where an arrow stands."""
    scale = LogScale(0.1, 10.0)
    assert scale.percent(value) == place
    assert not scale.holds(value)


def test_reciprocal_ratios_mirror_each_other():
    """Half as large and twice as large are equally far from 1."""
    scale = LogScale(0.1, 10.0)
    for ratio in (2.0, 3.0, 7.5):
        assert scale.percent(ratio) - 50.0 == pytest.approx(50.0 - scale.percent(1.0 / ratio), abs=0.011)


def test_one_is_on_every_axis_of_ratios():
    """All may be better than the reference: the line of the reference is still there."""
    scale = LogScale.around([0.02, 0.1, float("nan"), -1.0], include=1.0)
    assert scale.holds(1.0) and scale.holds(0.02)
    assert scale.high < 2.0
