"""Motions with the error along them: the right lap, the right place, and nothing lost that is large."""

import numpy as np
import pytest
from torquebench.evaluation.report.paths import PARTS, PathDrawing, PathsPanel, _last_lap


def circle(laps=3, per_lap=400, lead_in=100):
    """Return a trace of laps on a unit circle; on lap i the tool is i mm too high, and once 20 mm on the last."""
    rows = np.arange(-lead_in, laps * per_lap)
    t = rows * 1e-2
    angle = 2 * np.pi * rows / per_lap
    p_ref = np.column_stack([np.cos(angle), np.sin(angle), np.full(len(rows), 0.4)])
    p = p_ref.copy()
    p[:, 2] += 1e-3 * np.where(rows < 0, 50, rows // per_lap)
    p[lead_in + (laps - 1) * per_lap + per_lap // 4, 2] = 0.42
    return {"t": t, "p": p, "p_ref": p_ref}


def test_only_the_last_lap_counts_and_its_worst_sample_is_kept():
    """The lead-in is off by 50 mm; a part is drawn by the largest error within it, not by one that it happens on."""
    points, errors = _last_lap(circle(), 3)
    assert points.shape == (PARTS + 1, 3)
    assert errors.max() == pytest.approx(20.0)
    assert int(errors.argmax()) == PARTS // 4
    assert np.median(errors) == pytest.approx(2.0)


def test_a_lap_closes_where_it_began():
    points, _ = _last_lap(circle(), 3)
    assert points[0] == pytest.approx(points[-1])


def drawing_of(points, errors):
    return PathDrawing(trajectory="T<1>", label="a & b", load="1.5 kg", points=points, errors=errors, href="#run")


def test_the_widest_plane_is_drawn_first_and_names_its_axes():
    """A circle in the plane of y and z looks like a line from above."""
    angle = np.linspace(0, 2 * np.pi, 9)
    points = np.column_stack([0.01 * np.cos(angle), np.cos(angle), 0.9 * np.sin(angle)])
    panel = PathsPanel(limits=(1.0, 2.0), motions=())
    text = panel.draw(drawing_of(points, np.array([0.5, 0.5, 1.5, 1.5, 3.0, 3.0, 0.5, 0.5])))
    first, second = text.split("<text")[1:]
    assert "y \N{RIGHTWARDS ARROW}, z \N{UPWARDS ARROW}" in first
    assert "x \N{RIGHTWARDS ARROW}, y \N{UPWARDS ARROW}" in second
    assert all(text.count(f'class="way-{width}"') == 2 for width in (0, 1, 2))
    assert "T&lt;1&gt;, a &amp; b" in text


def test_up_is_up():
    """Screens count downwards."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 0.0, 0.5]])
    text = PathsPanel(limits=(), motions=()).draw(drawing_of(points, np.array([1.0, 1.0])))
    start, end = text.partition('d="M')[2].partition("M")[0].rstrip('"').split("L")
    assert float(end.split()[0]) > float(start.split()[0])
    assert float(end.split()[1]) < float(start.split()[1])


def test_the_legend_has_a_word_for_each_width():
    """Limits are rounded, so two may fall together."""
    assert [meaning for _, meaning in PathsPanel(limits=(0.1, 2.0), motions=()).legend] == [
        "below 0.10 mm",
        "0.10 to 2.0 mm",
        "above 2.0 mm",
    ]
    assert PathsPanel(limits=(), motions=()).legend == [(0, "all")]


def test_the_largest_error_is_never_a_power_of_ten():
    """A run that lost its path stands beside one that kept it."""
    points = np.zeros((2, 3))
    assert drawing_of(points, np.array([1234.5])).most == "1234 mm"
    assert drawing_of(points, np.array([0.14])).most == "0.140 mm"
