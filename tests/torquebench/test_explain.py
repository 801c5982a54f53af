"""``torquebench explain``: every number of a cell leads to its runs, and the worst of them can be had again."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.evaluation.errors import UnknownMetric
from torquebench.explaining import explain
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.store import Store
from torquebench.selection import Selection
from torquebench.terminal_plot import BLOCKS, plot

from .conftest import FULL, fill, run_of

POSITION = "tcp_position_error_mean"


def values_of(folder, controller):
    """Return address to stored position error, read from the rows themselves."""
    with Store.read(folder) as store:
        rows = [row for row in store.runs() if row.specification.controller == controller]
    return {row.address: row.result.metrics["run"][POSITION]["value"] for row in rows}


def test_a_cell_is_its_runs_their_mean_and_the_worst_of_them(kept):
    """The figures are those of the rows: nothing is computed twice in two ways."""
    expected = values_of(kept.folder, "cbmc_v3")
    found = explain(kept.folder, Selection(controller="cbmc_v3"), metric=POSITION)
    assert {run.address: run.values[POSITION] for run in found.runs} == expected
    assert found.mean == pytest.approx(np.mean(list(expected.values())), rel=1e-12)
    assert found.worst.address == max(expected, key=expected.get)


def test_the_worst_run_is_that_of_the_metric_that_was_asked_for(kept):
    """Another metric may have another worst case."""
    found = explain(kept.folder, Selection(controller="flexiv_factory"), metric="torque_rate_rms")
    values = {run.address: run.values["torque_rate_rms"] for run in found.runs}
    assert found.worst.address == max(values, key=values.get)


def test_the_curve_is_the_worst_runs_own_error(kept):
    """Its mean over the run is the metric, up to the decimation of the trace."""
    found = explain(kept.folder, Selection(controller="cbmc_v3", trajectories=("T6",), mass=1.5), metric=POSITION)
    t, error = found.curve
    assert error[t >= 0.0].mean() == pytest.approx(found.worst.values[POSITION], rel=0.01)


@pytest.mark.parametrize(
    ("conditions", "count"),
    [
        ({"controller": "cbmc_v3 / none"}, 4),
        ({"controller": "cbmc_v3", "trajectories": ("T6", "T7"), "mass": 2.5}, 2),
        ({"controller": "cbmc_v3", "material": "none"}, 2),
        ({"controller": "cbmc_v3", "trajectories": ("T7",), "material": "sand"}, 1),
        ({"controller": "cbmc_v3", "motions": "paper"}, 4),
    ],
)
def test_conditions_narrow_the_cell(kept, conditions, count):
    """Label or name, one motion or several, a set of them, mass, material."""
    assert len(explain(kept.folder, Selection(**conditions), metric=POSITION).runs) == count


@pytest.mark.parametrize(
    ("conditions", "line"),
    [
        ({"controller": "cbmc_v2"}, "unknown controller in this store 'cbmc_v2'; did you mean 'cbmc_v3'?"),
        ({"trajectories": ("T66",)}, "unknown trajectory in this store 'T66'; did you mean 'T6'?"),
        ({"mass": 3.5}, "unknown mass in this store '3.5'; did you mean '2.5'?"),
        ({"material": "snad"}, "did you mean 'sand'?"),
        ({"motions": "papers"}, "did you mean 'paper'?"),
    ],
)
def test_an_unknown_name_ends_in_one_line_with_the_nearest(kept, conditions, line):
    """What is valid is what the store holds, not what the program knows."""
    with pytest.raises(UnknownName) as caught:
        explain(kept.folder, Selection(**{"controller": "cbmc_v3", **conditions}), metric=POSITION)
    assert line in str(caught.value)


def test_known_names_that_never_met_are_said_to_be_that(kept):
    """1.5 kg has no material: every name is right and the cell is empty."""
    with pytest.raises(InvalidInput, match=r"no run has controller cbmc_v3, mass 1\.5, material sand"):
        explain(kept.folder, Selection(controller="cbmc_v3", mass=1.5, material="sand"), metric=POSITION)


def test_several_controllers_and_an_unknown_metric_are_refused(kept):
    """A mean over two laws is nobody's."""
    with pytest.raises(InvalidInput, match="name one of 'cbmc_v3 / none', 'flexiv_factory / none'"):
        explain(kept.folder, Selection(knowledge="none"), metric=POSITION)
    with pytest.raises(UnknownMetric, match=POSITION):
        explain(kept.folder, Selection(controller="cbmc_v3"), metric="tcp_position_eror_mean")


def test_of_several_worlds_one_must_be_named(tmp_path):
    """Runs of two tiers are never averaged."""
    run = run_of()
    fill(tmp_path / "store", run, replace(run, tier="actuated"))
    chosen = Selection(controller="flexiv_factory")
    with pytest.raises(InvalidInput, match=r"--world w1: tier .*; --world w2: tier"):
        explain(tmp_path / "store", chosen, metric=POSITION)
    assert len(explain(tmp_path / "store", chosen, metric=POSITION, world="w2").runs) == 1
    with pytest.raises(UnknownName, match="unknown world 'w3'"):
        explain(tmp_path / "store", chosen, metric=POSITION, world="w3")


def test_a_run_that_failed_is_the_worst_and_says_why(tmp_path, laws, line):
    """A worst case among survivors would be a lie; without a trace there is no curve, and that is said."""
    store = tmp_path / "store"
    fill(store, run_of(f"{laws}:Late"), run_of(f"{laws}:Late", load=FULL), traces="none")
    printed = line("explain", store, "--controller", "Late").output
    assert "too late" in printed and "no value" in printed and "no trace was kept" in printed


def test_the_command_is_given_only_where_it_repeats_the_run(tmp_path, line):
    """A row of other code or of measured wall times cannot be had again, and a command would pretend it could."""
    folder, run = tmp_path / "store", run_of()
    (address,) = fill(folder, run)
    found = explain(folder, Selection(controller="flexiv_factory"), metric=POSITION)
    assert found.command == f"torquebench replay {folder} {address[:12]} --again" and not found.obstacle
    result = line(*found.command.split()[1:])
    assert result.return_value == 0 and "every figure the same to the bit" in result.output
    with Store.write(folder) as store:
        other = replace(run, trajectory="T7")
        store.put(other.address("older code"), other, [RunResult(role="run", status="ok")])
    old = explain(folder, Selection(controller="flexiv_factory", trajectories=("T7",)), metric=POSITION)
    assert old.command == "" and "code, data or libraries are not those" in old.obstacle


def test_a_person_gets_a_table_and_a_plot_and_a_program_gets_json(kept, line):
    """The same figures in both."""
    shown = line("explain", kept.folder, "--controller", "cbmc_v3", "--mass", "1.5").output
    assert all(kept.addresses["cbmc_v3", path, 1.5][:12] in shown for path in ("T6", "T7"))
    assert "distance of the tool from its plan [mm]" in shown and BLOCKS[-1] in shown
    table = json.loads(line("explain", kept.folder, "--controller", "cbmc_v3", "--mass", "1.5", "--json").output)
    assert len(table["runs"]) == 2 and "curve" not in table
    assert f"{table['mean'] * 1e3:.1f} mm" in re.sub(r" +", " ", shown)


def test_a_plot_is_as_high_as_its_peaks_and_as_low_as_its_zeros():
    """One tall sample among thousands must not vanish between two columns."""
    y = np.zeros(6400)
    y[3210] = 2.0
    lines = plot(np.linspace(0.0, 6.4, 6400), y, title="t", width=64, height=4).splitlines()
    assert lines[0] == "t" and lines[1].startswith("2 ") and lines[-1].endswith("6.4 s")
    bodies = [text.partition("\N{BOX DRAWINGS LIGHT VERTICAL}")[2] for text in lines[1:-1]]
    assert [body.count(BLOCKS[-1]) for body in bodies] == [1, 1, 1, 1]
    assert {body.index(BLOCKS[-1]) for body in bodies} == {32}


def test_a_flat_zero_is_drawn_as_nothing():
    """A perfect run has no bar, and no division by zero."""
    text = plot(np.arange(3.0), np.zeros(3), title="t")
    assert not set(text) & set(BLOCKS[1:])


curves = st.lists(st.floats(0.0, 1e6), min_size=1, max_size=400)


@given(curves, st.integers(2, 80), st.integers(2, 12))
def test_a_plot_has_its_size_and_its_ends_whatever_the_curve(values, width, height):
    """A terminal is as wide as it is: title, rows, axis; never a column more than asked for."""
    y = np.array(values)
    title, *rows, axis = plot(np.arange(len(y)) * 0.5, y, title="t", width=width, height=height).splitlines()
    bodies = [row.partition("\N{BOX DRAWINGS LIGHT VERTICAL}")[2] for row in rows]
    assert title == "t" and len(rows) == height and axis.endswith(f"{0.5 * (len(y) - 1):g} s")
    assert {len(body) for body in bodies} == {min(width, len(y))}
    assert set("".join(bodies)) <= set(BLOCKS)


@given(curves, st.integers(2, 12))
def test_a_higher_sample_never_has_a_lower_bar(values, height):
    """With a column for each sample the bars stand in the order of the values, and every value but zero is seen."""
    y = np.array(values)
    rows = plot(np.arange(len(y)), y, title="t", width=len(y), height=height).splitlines()[1:-1]
    bodies = [row.partition("\N{BOX DRAWINGS LIGHT VERTICAL}")[2] for row in rows]
    bars = np.array([sum(BLOCKS.index(body[column]) for body in bodies) for column in range(len(y))])
    assert all(np.diff(bars[np.argsort(y, kind="stable")]) >= 0)
    assert bars.max() == (8 * height if y.max() > 0.0 else 0)
    assert all(bars[y > 1e-6 * y.max()] > 0)
