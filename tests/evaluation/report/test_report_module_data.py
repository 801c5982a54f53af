"""Modules of a world as data: which runs, which rows, which unit; each figure recomputed from what a run showed."""

from dataclasses import replace

import numpy as np
import pytest
from torquebench.evaluation.intervals import t_interval
from torquebench.evaluation.report.findings import find_all
from torquebench.evaluation.report.module_figures import MRAD, gain_charts, load_charts
from torquebench.evaluation.report.module_tables import (
    correlation_table,
    module_operation_table,
    operation_table,
    spike_table,
)
from torquebench.evaluation.report.modules import LAYERS, MOST_TRACES, START_UP, modules_of
from torquebench.evaluation.report.panels import panels_of
from torquebench.evaluation.report.worlds import worlds_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.store import Store
from torquebench.scenarios.trace import encode_trace

LAP, LAPS, LEAD_IN, STEP = 2.0, 4, 1.0, 1e-2
GRIPPER = 1.186


def trace_of(stiffness, damping):
    """A trace of eight seconds with the gains of each joint as functions of time."""
    t = np.round(np.arange(round((LEAD_IN + LAPS * LAP) / STEP)) * STEP - LEAD_IN, 9)
    arrays = {"t": t, "q": np.zeros((len(t), 2)), "q_ref": np.zeros((len(t), 2))}
    arrays |= {"diagnostics/stiffness": stiffness(t), "diagnostics/damping": damping(t)}
    return encode_trace({name: array.astype(np.float32) for name, array in arrays.items()})


def columns(*functions):
    """Return what makes a column of each function of time."""
    return lambda t: np.stack([np.broadcast_to(function(t), t.shape) for function in functions], axis=1)


def wave(t):
    """A motion's own rhythm, twice a lap."""
    return np.sin(2.0 * np.pi * t)


@pytest.fixture
def put(shelf):
    """Puts a run of a spiking controller on the shelf, with what it showed."""

    def add(controller="cbmc_v3", trajectory="S1", mass=1.5, *, shown=None, trace=None, error=None, **changes):
        operations, timing = changes.pop("operations", {}), changes.pop("simulated", 9.0)
        run = replace(shelf.specification(controller, "none", trajectory, mass), laps=LAPS, **changes)
        result = shelf.result(run, 1e-2, "slow")
        if error is not None:
            found = {"value": error, "unit": "rad", "status": "ok", "n": 5}
            result = replace(result, metrics={**result.metrics, "steady": {"joint_error_mean": found}})
        load = (mass - GRIPPER) / 3.0
        weights = {"weights": {"run_mean": [1.0 - load, load], "last_lap_mean": [1.0 - load, load]}}
        shelf.put(
            run,
            replace(
                result,
                diagnostics=weights if shown is None else shown,
                counts={**result.counts, "operations": operations},
                timing={**result.timing, "simulated_s": timing},
                provenance={
                    **result.provenance,
                    "payload": [mass - GRIPPER] + [0.0] * 9,
                    "tick_s": 1e-3,
                    "diagnostics": {"stiffness": 10, "damping": 10},
                },
                trace=trace,
            ),
        )

    return add


@pytest.fixture
def read(shelf):
    """Closes the shelf and returns the first world's findings and what its modules did."""

    def open_again():
        shelf.campaign().store.close()
        with Store.read(shelf.folder) as store:
            (found, *_) = find_all(worlds_of(store.runs(), store.campaigns()))
            return found, modules_of(found.world, store)

    return open_again


def test_a_world_in_which_nobody_shows_anything_has_no_modules(put, read):
    """Classical laws have no weights to draw."""
    put("flexiv_factory", shown={})
    assert read()[1] is None


def test_a_seed_s_weight_is_the_mean_over_motions(put, read):
    """Two motions, two seeds: two numbers at each load, of the last lap and of the heavy pattern."""
    for seed, offset in enumerate((0.0, 0.2)):
        for path, weight in (("S1", 0.1), ("S2", 0.3)):
            last = [1.0 - weight - offset, weight + offset]
            put(trajectory=path, repetition=seed, shown={"weights": {"last_lap_mean": last, "run_mean": [0.5, 0.5]}})
    _, modules = read()
    assert modules.weights == {1.5: pytest.approx([0.2, 0.4])}


@pytest.mark.parametrize(
    "weights", [{}, {"last_lap_mean": [1.0]}, {"last_lap_mean": [np.nan, np.nan]}, {"last_lap_mean": []}]
)
def test_a_run_without_a_heavy_weight_has_no_point(put, read, weights):
    """One pattern alone has no choice; a run that ended in its first lap has no last one."""
    put(shown={"weights": weights})
    assert read()[1].weights == {}


def test_the_right_weight_is_the_load_beyond_the_gripper_by_three_kilograms(put, read):
    """As the run noted its payload, not as the table of masses would have it."""
    for mass in (1.5, 2.5, 3.5):
        put(mass=mass)
    _, modules = read()
    assert modules.right == {mass: pytest.approx((mass - GRIPPER) / 3.0) for mass in (1.5, 2.5, 3.5)}
    assert modules.slopes.values == [pytest.approx(1.0 / 3.0)]


def test_errors_by_load_are_of_the_steady_window_and_of_runs_that_have_it(put, read):
    """The start says how well a pattern fits by chance; what is left says how well it fits."""
    for mass, error in ((1.5, 0.01), (2.5, 0.02), (3.5, 0.06)):
        put(mass=mass, error=error)
        put("light_only", mass=mass, error=2.0 * error)
    _, modules = read()
    assert modules.errors["cbmc_v3 / none"] == {1.5: [0.01], 2.5: [0.02], 3.5: [0.06]}
    assert list(modules.errors) == ["light_only / none", "cbmc_v3 / none"]


def test_a_world_with_load_events_has_no_figures_by_load(put, read):
    """A mean over two loads belongs to neither."""
    heavier = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (4.0, Payload(mass=3.5, material="sand"))))
    put(schedule=heavier)
    _, modules = read()
    assert modules.errors == modules.weights == modules.right == {}
    assert modules.slopes.values == []


def test_gains_are_correlated_in_three_cuts(put, read):
    """A common ramp from lap to lap with waves in opposition: together as a whole, against each other within laps."""

    def drift(t):
        return 40.0 * np.floor(t / LAP)

    stiff = columns(lambda t: 200.0 + drift(t) + wave(t), lambda t: 200.0 + wave(t))
    damp = columns(lambda t: 20.0 + drift(t) - wave(t), lambda t: 20.0 + np.where(t < START_UP, 0.0, 1.0) * wave(t))
    put(trace=trace_of(stiff, damp))
    _, modules = read()
    found = modules.gains["cbmc_v3 / none"].correlations
    assert found["raw"][0].median > 0.99
    assert found["laps"][0].median == pytest.approx(-1.0, abs=1e-3)
    assert found["raw"][1].median < 0.95
    assert found["late"][1].median == pytest.approx(1.0, abs=1e-4)


def test_gains_that_stand_still_are_no_gains_of_a_learner(put, read):
    """An ablation with fixed gains shows them too; it has no curve and no correlation."""
    put("no_brainstem_learning", trace=trace_of(columns(lambda t: 200.0), columns(lambda t: 20.0)))
    put(trace=trace_of(columns(lambda t: 200.0 + wave(t)), columns(lambda t: 20.0 + wave(t))))
    _, modules = read()
    assert list(modules.gains) == ["cbmc_v3 / none"]


def test_the_curves_are_of_the_run_nearest_to_the_middle_load(put, read):
    """One run is drawn: of equally long ones the load that the paper draws."""
    moving = trace_of(columns(lambda t: 200.0 + wave(t)), columns(lambda t: 20.0 + wave(t)))
    for mass in (1.5, 2.5, 3.5):
        put(mass=mass, trace=moving)
    found, modules = read()
    gains = modules.gains["cbmc_v3 / none"]
    assert (gains.run.row.mass, gains.runs) == (2.5, 3)
    stiffness, damping = gain_charts(found, "cbmc_v3 / none", gains)
    assert stiffness.title == "Stiffness of cbmc_v3 / none, S1, 2.5 kg sand"
    assert (damping.x.low, damping.x.high) == (0.0, pytest.approx(LAPS * LAP))
    assert [curve.label for curve in damping.curves] == ["joint 1"]


def test_many_runs_are_sampled_evenly(put, read):
    """Reading every trace of a large campaign would take minutes; the first of them would be one motion only."""
    moving = trace_of(columns(lambda t: 200.0 + wave(t)), columns(lambda t: 20.0 + wave(t)))
    for path in ("S1", "S2", "S3"):
        for repetition in range(MOST_TRACES // 2):
            put(trajectory=path, repetition=repetition, trace=moving)
    _, modules = read()
    assert modules.gains["cbmc_v3 / none"].runs == MOST_TRACES


@pytest.mark.parametrize(("layer", "entries"), [("spikes_granule", 2), ("spikes_purkinje", 2), ("spikes_thalamus", 8)])
def test_a_rate_is_spikes_by_neuron_and_step(put, read, layer, entries):
    """An entry of the cerebellum is a pattern's whole layer, one of the thalamus is a neuron."""
    _, behind, steps = LAYERS[layer]
    half = 0.5 * (behind or 1) * steps
    put(shown={layer: {"run_mean": [half] * entries}})
    found, modules = read()
    assert modules.spikes["cbmc_v3 / none"][layer].median == pytest.approx(0.5)
    table = spike_table(found, modules)
    assert [(column.text, column.unit) for column in table.columns[1:]] == [(LAYERS[layer][0], "%")]
    assert table.rows[0][1].text == "50.0"


def test_operations_of_all_modules_are_those_of_one_run(put, read):
    """Medians of two modules may come from different runs: their sum, 4 here, is then the count of no usual run."""
    for seed, (cerebellum, thalamus) in enumerate([(9, 1), (1, 9), (2, 2), (30, 1), (1, 30)]):
        counts = {"cerebellum_executed_macs": cerebellum, "thalamus_executed_macs": thalamus}
        put(operations=counts, simulated=1.0, repetition=seed)
    operations = read()[1].operations["cbmc_v3 / none"]
    assert sorted(operations["all_modules_executed_macs"].values) == [4, 10, 10, 31, 31]
    assert operations["cerebellum_executed_macs"].median + operations["thalamus_executed_macs"].median == 4


def test_operations_are_by_second_of_simulated_time(put, read):
    """Lead-in included, on any machine the same; modules add up, other counters are not summed with them."""
    counts = {"cerebellum_executed_macs": 18e6, "thalamus_executed_macs": 9e6, "calls": 5e6}
    put(operations=counts, simulated=9.0)
    found, modules = read()
    assert modules.operations["cbmc_v3 / none"]["cerebellum_executed_macs"].median == pytest.approx(2e6)
    place = [column.group + column.text for column in operation_table(found, modules).columns]
    (row,) = operation_table(found, modules).rows
    assert row[place.index("Forward, as executedMAC")].value == pytest.approx(3.0)
    assert row[place.index("Forward, as definedMAC")].text == "\N{EMPTY SET} not counted"
    single = module_operation_table(found, "cbmc_v3 / none", modules)
    assert [row[0].text for row in single.rows] == ["Cerebellum", "Thalamus"]


@pytest.mark.parametrize("simulated", [0.0, "long"])
def test_a_run_without_a_duration_has_no_rate(put, read, simulated):
    """Nothing is divided by nothing."""
    put(operations={"cerebellum_executed_macs": 5}, simulated=simulated)
    assert read()[1].operations == {}


def test_the_band_of_a_load_is_student_s_interval_over_seeds(put, read):
    """Three seeds at each of two loads; the means are the points, in milliradians."""
    errors = {1.5: [0.010, 0.012, 0.011], 3.5: [0.03, 0.05, 0.04]}
    for mass, values in errors.items():
        for seed, error in enumerate(values):
            put(mass=mass, repetition=seed, error=error)
    found, modules = read()
    chart = next(chart for chart in load_charts(found, modules) if chart.id.endswith("load-error"))
    (curve,) = chart.curves
    assert curve.x.tolist() == [1.5, 3.5]
    assert curve.y == pytest.approx([np.mean(values) * MRAD for values in errors.values()])
    limits = [t_interval(values) for values in errors.values()]
    assert curve.band[0] == pytest.approx([interval.low * MRAD for interval in limits])
    assert curve.band[1] == pytest.approx([interval.high * MRAD for interval in limits])
    assert all(0.0 <= chart.y.place(value) <= 1.0 for value in (*curve.y, *curve.band[1]))


def test_one_load_is_no_curve_and_one_seed_has_no_band(put, read):
    """A line through a point, and an interval of one, would both be inventions."""
    put(mass=1.5, error=0.01)
    put(mass=2.5, error=0.02)
    put("heavy_only", mass=2.5, error=0.03)
    found, modules = read()
    error, weight = load_charts(found, modules)
    assert [curve.label for curve in error.curves] == ["cbmc_v3 / none"]
    # A title that speaks of both patterns would leave the one curve without a name.
    assert error.title == "Joint error by load: cbmc_v3 / none"
    assert {curve.band for curve in (*error.curves, *weight.curves)} == {None}


def test_the_sentence_of_the_slope_has_its_range(shelf, put):
    """Median and extremes over motions and seeds, beside the slope that is right."""
    for path, factor in (("S1", 1.0), ("S2", 0.5)):
        for mass in (1.5, 2.5, 3.5):
            load = factor * (mass - GRIPPER) / 3.0
            put(
                trajectory=path, mass=mass, shown={"weights": {"run_mean": [1.0 - load, load], "last_lap_mean": [0, 0]}}
            )
    shelf.campaign().store.close()
    with Store.read(shelf.folder) as store:
        (found,) = find_all(worlds_of(store.runs(), store.campaigns()))
        panels = panels_of(found, store)
    assert "grows by 0.250 per kg" in panels.modules.slope
    assert "0.167 to 0.333); right is 1/3 per kg" in panels.modules.slope
    assert "thalamus_weight_slope" in panels.metrics
    assert {chart.id for chart in panels.charts} >= {"w1-load-weight"}


def test_a_correlation_table_has_a_row_for_each_joint(put, read):
    """Counted from one, as everywhere on the page; the caption says of how many runs."""
    moving = trace_of(columns(lambda t: 200.0 + wave(t), lambda t: 200.0 - wave(t)), columns(wave, wave))
    put(trace=moving)
    found, modules = read()
    table = correlation_table(found, "cbmc_v3 / none", modules.gains["cbmc_v3 / none"])
    assert [row[0].text for row in table.rows] == ["1", "2"]
    assert [row[1].text for row in table.rows] == ["1.00", "\N{MINUS SIGN}1.00"]
    assert "median of 1 run;" in table.caption
