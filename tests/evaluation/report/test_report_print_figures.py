"""Figures for print: what the store holds is drawn, in the same bytes each time, whatever names and settings come."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.evaluation.errors import UnknownMotionSet
from torquebench.evaluation.report.charts import Axis, Chart, Curve
from torquebench.evaluation.report.findings import POSITION, find_all
from torquebench.evaluation.report.worlds import worlds_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.store import Store
from torquebench.scenarios.trace import encode_trace

matplotlib = pytest.importorskip("matplotlib")

from torquebench.evaluation.report import print_drawing, print_figures, print_masses  # noqa: E402

NASTY = r"a_b & <script> $\frac{x}$ | \x"
SCALES = {("flexiv_factory", "none"): 17e-3, ("cbmc_v3", "none"): 19e-3, ("computed_torque", "oracle"): 1e-3}
STEP = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (6.0, Payload(mass=3.5, material="sand"))))


def drawn(shelf, out, controllers=()):
    """Close a shelf and draw its figures; name of each file to its bytes."""
    shelf.store.close()
    files = print_figures.print_figures(shelf.folder, out, controllers)
    return {file.name: file.read_bytes() for file in files}


def words_of(svg):
    """Return the texts of an SVG file."""
    return [element.text for element in ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]


def trace_of(size, seconds=12.0):
    """Return the trace of a run whose joint error is a sine of one size."""
    t = np.arange(-1.0, seconds, 0.01)
    q = np.zeros((len(t), 7))
    q[:, 0] = size * np.abs(np.sin(t))
    arrays = {"t": t, "q": q, "q_ref": np.zeros_like(q)}
    gains = {name: np.tile(100.0 * size + np.sin(t)[:, None], 7) for name in ("stiffness", "damping")}
    return encode_trace({name: rows.astype(np.float32) for name, rows in arrays.items()} | {
        f"diagnostics/{name}": rows for name, rows in gains.items()
    })  # fmt: skip


def test_the_headline_figures_are_there_as_svg_and_pdf(shelf, tmp_path):
    """Each with the labels of its controllers; a PDF is a PDF."""
    files = drawn(shelf.grid(SCALES).campaign(), tmp_path)
    assert {name.partition(".")[0] for name in files} == {
        "w1-intervals", "w1-errors-by-trajectory", "w1-errors-by-mass",
    }  # fmt: skip
    assert all(data.startswith(b"%PDF") for name, data in files.items() if name.endswith(".pdf"))
    assert "computed_torque / oracle" in words_of(files["w1-intervals.svg"])
    assert {"1.5", "2.5", "3.5"} <= set(words_of(files["w1-errors-by-mass.svg"]))


def test_the_same_store_gives_the_same_bytes_whatever_the_users_settings(shelf, tmp_path):
    """No date, no random identities, no matplotlibrc: a figure in version control changes when its data do."""
    first = drawn(shelf.grid(SCALES).campaign(), tmp_path / "a")
    with matplotlib.rc_context({"font.size": 20.0, "svg.hashsalt": None, "lines.linewidth": 5.0}):
        again = print_figures.print_figures(shelf.folder, tmp_path / "b")
        assert matplotlib.rcParams["font.size"] == 20.0
    assert {file.name: file.read_bytes() for file in again} == first
    assert not any(re.search(rb"dc:date|CreationDate", data) for data in first.values())


def test_a_name_with_every_special_sign_is_drawn_as_it_is(shelf, tmp_path):
    """A dollar opens a formula and a tag opens a tag, elsewhere."""
    for path in ("T1", "T2"):
        for mass in (1.5, 2.5):
            run = shelf.specification(NASTY, "none", path, mass)
            shelf.put(run, shelf.result(run, 1e-2, "slow"))
    files = drawn(
        shelf.grid({("flexiv_factory", "none"): 17e-3}, ("T1", "T2")).campaign(), tmp_path, (f"{NASTY} / none",)
    )
    assert f"{NASTY} / none" in words_of(files["w1-intervals.svg"])
    assert f"{NASTY} / none" in words_of(files["w1-errors-by-mass.svg"])


def test_load_events_and_gains_are_drawn_as_the_paper_draws_them(shelf, tmp_path):
    """The error over time with its events, a zoom on each, the gains of the spiking controller."""
    for controller, size in (("flexiv_factory", 0.1), ("cbmc_v3", 0.05), ("no_thalamus_learning", 0.07)):
        run = replace(shelf.specification(controller, "none", "T6"), schedule=STEP)
        result = shelf.result(run, 1e-2, "fast")
        noted = {**result.provenance, "tick_s": 1e-3, "diagnostics": {"stiffness": 10, "damping": 10}}
        shown = {"stiffness": {"run_mean": [1.0]}} if controller != "flexiv_factory" else {}
        shelf.put(run, replace(result, trace=trace_of(size), provenance=noted, diagnostics=shown))
    files = drawn(shelf.campaign(), tmp_path)
    words = words_of(files["w1-resilience.svg"])
    assert {"cbmc_v3 / none", "flexiv_factory / none", "no_thalamus_learning / none"} <= set(words)
    assert "Start-up at 0 s, ablations" in words and "+2 kg at 6 s, ablations" in words
    assert "joint 7" in words_of(files["w1-gains.svg"])


def test_by_mass_shows_the_range_over_motions_and_over_runs(shelf):
    """The bar is the paper's: means over repetitions; the line is every run."""
    runs = [
        (trajectory, repetition, size)
        for trajectory, sizes in {"T1": (1.0, 3.0), "T2": (4.0, 6.0)}.items()
        for repetition, size in enumerate(sizes)
    ]
    for trajectory, repetition, size in runs:
        run = shelf.specification("pid", "none", trajectory, repetition=repetition)
        result = shelf.result(run, 1e-2, "slow")
        entry = {"value": size, "unit": "m", "status": "ok", "n": 1}
        shelf.put(run, replace(result, metrics={"run": {**result.metrics["run"], POSITION: entry}}))
    shelf.store.close()
    with Store.read(shelf.folder) as store:
        (found,) = find_all(worlds_of(store.runs(), store.campaigns()))
    assert print_masses.mass_range(found.world.rows, POSITION) == print_masses.MassRange(2.0, 5.0, 1.0, 6.0)
    assert print_masses.mass_range([], POSITION) is None
    assert print_masses.mass_sheet(found, ["pid / none"]) is None


@pytest.mark.parametrize(
    ("scales", "asked", "expected"),
    [
        (SCALES, (), ["cbmc_v3 / none", "flexiv_factory / none"]),
        ({("pid", "none"): 1e-3, ("mpc", "none"): 2e-3}, (), ["pid / none", "mpc / none"]),
        (SCALES, ("computed_torque / oracle",), ["computed_torque / oracle"]),
    ],
)
def test_the_two_of_the_paper_are_shown_unless_others_are_asked_for(shelf, scales, asked, expected):
    """A panel of twenty controllers shows none of them."""
    shelf.grid(scales, ("T1",), (1.5,)).campaign().store.close()
    with Store.read(shelf.folder) as store:
        (found,) = find_all(worlds_of(store.runs(), store.campaigns()))
    assert print_figures.chosen(found, asked) == expected


def test_a_chart_keeps_its_axes_bands_and_events():
    """What the page draws is what print draws: the same limits, the same ticks."""
    x = np.linspace(1.0, 100.0, 50)
    curve = Curve(label="a", x=x, y=x, band=(0.5 * x, 2.0 * x))
    axis = Axis("lap", 1.0, 100.0, log=True)
    chart = Chart(id="c", title="t", description="d", x=axis, y=Axis("e", 0.0, 100.0), curves=[curve, curve],
                  events=[(10.0, "+2 kg")])  # fmt: skip
    with print_drawing.look():
        sheet = print_drawing.Sheet()
        axes = sheet.add_subplot()
        print_drawing.draw_chart(axes, chart)
    assert (axes.get_xscale(), axes.get_xlim(), axes.get_ylim()) == ("log", (1.0, 100.0), (0.0, 100.0))
    assert list(axes.get_xticks()) == [value for value, _ in axis.ticks()]
    assert len(axes.collections) == 2 and [text.get_text() for text in axes.texts] == ["+2 kg"]
    assert axes.get_legend() is not None


def test_what_cannot_be_drawn_or_written_ends_in_one_line(shelf, tmp_path):
    """A label that nobody has, a folder that is a file, a folder without a store."""
    shelf.grid(SCALES, ("T1", "T2"), (1.5,)).campaign().store.close()
    with pytest.raises(UnknownName, match="did you mean 'cbmc_v3 / none'"):
        print_figures.print_figures(shelf.folder, tmp_path, ["cbmc_v3 / non"])
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInput, match="cannot be written"):
        print_figures.print_figures(shelf.folder, tmp_path / "file")
    with pytest.raises(InvalidInput, match="holds no run store"):
        print_figures.print_figures(tmp_path, tmp_path)


def test_a_failed_run_is_named_and_not_drawn(shelf, tmp_path):
    """At its cost of half a metre it would leave room for nothing else, and without a word it would be hidden."""
    shelf.grid(SCALES, masses=(1.5, 2.5))
    shelf.fail(shelf.specification("cbmc_v3", "none", "T3", 2.5))
    files = drawn(shelf.campaign(), tmp_path)
    words = words_of(files["w1-errors-by-mass.svg"])
    assert "cbmc_v3 / none (1 of 16 runs failed, not drawn)" in words
    assert "flexiv_factory / none" in words
    ticks = [float(word) for word in words if re.fullmatch(r"\d+(\.\d+)?", word)]
    assert max(ticks) < 200.0


def test_of_several_sets_of_motions_one_is_drawn(shelf, tmp_path):
    """The paper's ranges are over its own eight motions; another set is asked for by name, and a wrong one refused."""
    shelf.grid({("cbmc_v3", "none"): 20e-3}, masses=(1.5, 2.5))
    shelf.grid({("cbmc_v3", "none"): 90e-3}, trajectories=("M1", "M2"), masses=(1.5, 2.5))
    shelf.store.close()
    with Store.read(shelf.folder) as store:
        (findings,) = find_all(worlds_of(store.runs(), store.campaigns()))
    tops = {}
    for motions in ("paper", "further"):
        sheet = print_masses.mass_sheet(findings, ["cbmc_v3 / none"], motions)
        tops[motions] = sheet.axes[0].dataLim.y1
    assert tops["further"] > 2.0 * tops["paper"]
    with pytest.raises(UnknownMotionSet, match="known: paper, further, extended"):
        print_figures.print_figures(shelf.folder, tmp_path, motions="papre")


def test_the_figure_by_mass_names_its_motions_and_its_marks(shelf, tmp_path):
    """A set that did not run is not drawn under its name, and bars and lines need a key."""
    shelf.grid({("cbmc_v3", "none"): 20e-3}, masses=(1.5, 2.5))
    shelf.store.close()
    for motions in ("paper", "further"):
        print_figures.print_figures(shelf.folder, tmp_path, motions=motions)
        words = " ".join(words_of((tmp_path / "w1-errors-by-mass.svg").read_bytes()))
        assert "T1 to T8. Bars: from the least to the largest mean of a motion; lines: of a single run" in words
