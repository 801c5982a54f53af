"""Load events of a world as data: what is gathered from which run, and why a controller has no curve."""

import math
from dataclasses import replace

import numpy as np
import pytest
from torquebench.evaluation.report.claim_evidence import rows_of_curves
from torquebench.evaluation.report.findings import find_all
from torquebench.evaluation.report.resilience import Event, MeanCurve, events_of, resilience_of
from torquebench.evaluation.report.resilience_figures import (
    HEAVIER_ZOOM,
    LIGHTER_ZOOM,
    MRAD,
    START_ZOOM,
    curve_charts,
    zoom_charts,
)
from torquebench.evaluation.report.resilience_tables import event_table, peak_table, rate_table, unjudged_table
from torquebench.evaluation.report.worlds import worlds_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.store import Store
from torquebench.scenarios.trace import encode_trace

LAP, LAPS, DT = 2.0, 6, 1e-2
LIGHT, HEAVY = Payload(mass=1.5), Payload(mass=3.5, material="sand")
STEP = LoadSchedule(entries=((0.0, LIGHT), (4.0, HEAVY), (8.0, LIGHT)))


def trace_of(level, laps=LAPS, dt=DT):
    """A joint error that is a level, doubled while the heavy load hangs there."""
    t = np.arange(-50, round(laps * LAP / dt)) * dt
    q = np.zeros((len(t), 7))
    q[:, 2] = level * np.where((t >= 4.0 - dt / 2) & (t < 8.0 - dt / 2), 2.0, 1.0)
    arrays = {"t": t, "q": q, "q_ref": np.zeros_like(q)}
    return encode_trace({name: array.astype(np.float32) for name, array in arrays.items()})


def window(**values):
    """Metrics of an event: numbers, or pairs of a number and its status."""
    return {
        name: dict(zip(("value", "status"), value if isinstance(value, tuple) else (value, "ok"), strict=True))
        for name, value in values.items()
    }


@pytest.fixture
def put(shelf):
    """Puts a run with its load events on the shelf."""

    def add(controller, trajectory="S1", *, level=0.02, schedule=STEP, laps=LAPS, trace=True, events=None, **changes):
        base = shelf.specification(controller, "none", trajectory)
        run = replace(base, schedule=schedule, laps=laps, **changes)
        result = shelf.result(run, 1e-2, "slow")
        kept = trace_of(level, laps) if trace is True else trace
        shelf.put(run, replace(result, metrics={**result.metrics, **(events or {})}, trace=kept or None))

    return add


@pytest.fixture
def read(shelf):
    """Closes the shelf and returns the first world's findings and what is known of its load events."""

    def open_again():
        shelf.campaign().store.close()
        with Store.read(shelf.folder) as store:
            (found, *_) = find_all(worlds_of(store.runs(), store.campaigns()))
            return found, resilience_of(found.world, store)

    return open_again


def test_a_world_has_its_start_and_then_every_change(put, read):
    """In words for people: what changed by how much, and until when it counts."""
    put("cbmc_v3")
    found, _ = read()
    assert events_of(found.world) == [
        Event(time=0.0, until=4.0, words="start", window=""),
        Event(time=4.0, until=8.0, words="+2 kg", window="event@4"),
        Event(time=8.0, until=math.inf, words="\N{MINUS SIGN}2 kg", window="event@8"),
    ]
    assert [event.title for event in events_of(found.world)] == [
        "Start-up at 0 s",
        "+2 kg at 4 s",
        "\N{MINUS SIGN}2 kg at 8 s",
    ]


def test_a_constant_load_has_no_events(put, read):
    """Not even a start: its figures are those of the comparison."""
    put("cbmc_v3", schedule=LoadSchedule.constant(LIGHT))
    found, resilience = read()
    assert events_of(found.world) == [] and resilience is None


def test_a_mean_curve_is_the_mean_over_motions_of_each_seed(put, read):
    """Two motions of 10 and 30 mrad make 20; two seeds stay two curves."""
    for seed, scale in enumerate((1.0, 2.0)):
        for path, level in (("S1", 0.01), ("S2", 0.03)):
            put("cbmc_v3", path, level=scale * level, repetition=seed)
    _, resilience = read()
    curve = resilience.curves["cbmc_v3 / none"]
    assert curve.seeds.shape == (2, round(LAPS * LAP / DT))
    assert (curve.paths, curve.dt) == (2, DT)
    before = curve.t < 4.0 - DT / 2
    assert pytest.approx(np.broadcast_to([0.02, 0.04], (before.sum(), 2)), rel=1e-6) == curve.seeds[:, before].T
    during = (curve.t > 4.0 - DT / 2) & (curve.t < 8.0 - DT / 2)
    assert curve.seeds[0, during] == pytest.approx(0.04, rel=1e-6)


def test_a_seed_keeps_its_number_though_another_is_lost(put, read):
    """The second seed has no curve; the third must not be taken for it, in none of its windows."""
    for seed in range(3):
        put("cbmc_v3", trace=None if seed == 1 else True, level=0.02 * (seed + 1), repetition=seed)
    found, resilience = read()
    assert tuple(resilience.curves["cbmc_v3 / none"].repetitions) == (0, 2)
    rows = rows_of_curves(resilience, found.world.runs[0].row, LAPS)
    assert {row.repetition: set(row.metrics) for row in rows} == {
        seed: {"event@0", "event@4", "event@8"} for seed in (0, 2)
    }


@pytest.mark.parametrize(
    ("traces", "reason"),
    [
        ((None, None), "no trace was kept"),
        ((True, None), "no seed finished on every trajectory with its trace kept"),
        ((trace_of(0.02), trace_of(0.02, laps=5)), "its trajectories last differently long"),
        ((trace_of(0.02), trace_of(0.02, dt=2 * DT)), "its trajectories last differently long"),
    ],
)
def test_a_controller_without_a_mean_curve_says_why(put, read, traces, reason):
    """A mean over what happens to be there would be compared with one over everything."""
    for path, trace in zip(("S1", "S2"), traces, strict=True):
        put("cbmc_v3", path, trace=trace)
    _, resilience = read()
    assert resilience.curves == {} and resilience.dt is None
    assert resilience.without == {"cbmc_v3 / none": reason}


def test_a_controller_that_never_finished_says_that(shelf, put, read):
    """There is nothing to keep a trace of."""
    put("cbmc_v3")
    shelf.fail(replace(shelf.specification("pid", "none", "S1"), schedule=STEP, laps=LAPS))
    _, resilience = read()
    assert resilience.without == {"pid / none": "no run finished"}


def test_figures_of_the_curves_are_those_of_the_levels(put, read):
    """20 mrad, 40 while the load is heavy, 20 again: the last lap before each event, and its largest value."""
    put("cbmc_v3")
    _, resilience = read()
    start, up, back = (resilience.found[event, "cbmc_v3 / none"] for event in resilience.events)
    for spreads, level in ((start, 0.02), (up, 0.04), (back, 0.02)):
        assert spreads["last_cycle_error"].median == pytest.approx(level, rel=1e-6)
        assert spreads["error_peak_raw"].median == pytest.approx(level, rel=1e-6)
    assert "excess_integral" not in start and "excess_integral" in up


def test_values_of_the_twins_come_from_the_runs_that_finished(shelf, put, read):
    """Each event from its own window; a run that fell has no part in a median of recoveries."""
    for seed, value in enumerate((1.0, 2.0, 6.0)):
        events = {"event@4": window(recovery_time_settled=value), "event@8": window(recovery_time_settled=10.0 * value)}
        put("cbmc_v3", repetition=seed, events=events)
    shelf.fail(replace(shelf.specification("cbmc_v3", "none", "S1"), schedule=STEP, laps=LAPS, repetition=3))
    _, resilience = read()
    _, up, back = (resilience.found[event, "cbmc_v3 / none"] for event in resilience.events)
    assert (up["recovery_time_settled"].values, up["recovery_time_settled"].missing) == ([1.0, 2.0, 6.0], 0)
    assert back["recovery_time_settled"].median == 20.0
    assert dict(up["excess_integral"].others) == {"missing": 3}


def test_an_event_that_no_twin_could_judge_is_listed_once_a_run(put, read):
    """With the reason that the run noted; one that has a single value is judged."""
    lost = window(recovery_time_settled=(math.nan, "undefined"), excess_peak=(math.nan, "undefined"))
    half = window(recovery_time_settled=(math.nan, "undefined"), excess_peak=0.1)
    put("cbmc_v3", events={"event@4": lost, "event@8": half})
    found, resilience = read()
    ((run, event, status, reason),) = resilience.unjudged
    assert (run.row.controller, event.time, status, reason) == (
        "cbmc_v3 / none",
        4.0,
        "undefined",
        "no reason on record",
    )
    (row,) = unjudged_table(found, resilience).rows
    assert [cell.text for cell in row] == [
        "cbmc_v3 / none", "S1", "0", "+2 kg at 4 s", "undefined", "no reason on record",
    ]  # fmt: skip


def test_a_reason_on_the_run_wins_over_one_on_a_value(shelf, put, read):
    """The note names the twin and why it failed; the value only says that there is none."""
    lost = {"excess_peak": {"value": None, "status": "undefined", "reason": "a twin is missing"}}
    run = replace(shelf.specification("cbmc_v3", "none", "S1"), schedule=STEP, laps=LAPS)
    result = shelf.result(run, 1e-2, "slow")
    notes = [{"time": 4.0, "reason": "twin 'constant 3.5 kg sand' failed: nan"}]
    metrics = {**result.metrics, "event@4": lost, "event@8": lost}
    shelf.put(run, replace(result, metrics=metrics, provenance={**result.provenance, "events": notes}))
    _, resilience = read()
    assert [reason for *_, reason in resilience.unjudged] == [notes[0]["reason"], "a twin is missing"]


@pytest.mark.parametrize(
    ("costs", "slope"), [((0.04, 0.02, 0.01), -math.log(2.0)), ((0.01, 0.03, 0.09), math.log(3.0))]
)
def test_the_same_change_three_times_has_a_rate(put, read, costs, slope):
    """Additions and removals are different changes; each has its own slope, or too few of them."""
    entries = tuple((2.0 * n, (LIGHT, HEAVY)[n % 2]) for n in range(6))
    windows = {f"event@{2 * n}": window(excess_integral=costs[n // 2] if n % 2 else 1.0) for n in range(1, 6)}
    put("cbmc_v3", schedule=LoadSchedule(entries=entries), events=windows)
    found, resilience = read()
    assert list(resilience.rates) == [("+2 kg", "cbmc_v3 / none")]
    assert resilience.rates["+2 kg", "cbmc_v3 / none"].median == pytest.approx(slope)
    assert [column.text for column in rate_table(found, resilience).columns[1:]] == ["+2 kg"]


def test_two_changes_are_no_trend(put, read):
    """A slope through two points fits whatever they are."""
    put("cbmc_v3")
    found, resilience = read()
    assert resilience.rates == {}
    assert rate_table(found, resilience).rows == []


def test_the_tables_have_a_row_for_each_controller_in_the_order_of_the_world(put, read):
    """The same order as in the comparison: a reader's eye keeps its place."""
    for controller in ("a_law", "cbmc_v3", "flexiv_factory"):
        put(controller)
    found, resilience = read()
    for event in resilience.events:
        tables = [event_table(found, resilience, event)]
        tables += [peak_table(found, resilience, event)] if event.window else []
        for table in tables:
            assert tuple(row[0].text for row in table.rows) == tuple(found.order)
            assert {len(row) for row in table.rows} == {len(table.columns)}


def test_columns_are_explained_below_the_first_table_that_has_them(put, read):
    """Once: the same note under every event hides what is new in it."""
    put("cbmc_v3")
    found, resilience = read()
    start, up, back = (event_table(found, resilience, event) for event in resilience.events)
    assert start.notes and up.notes and back.notes == []
    assert not set(start.notes) & set(up.notes)


def test_error_curves_share_their_axes(put, read):
    """A curve that looks half as high is half as high."""
    for controller, level in (("a_law", 0.01), ("b_law", 0.02), ("c_law", 0.03)):
        put(controller, level=level)
    found, resilience = read()
    charts = curve_charts(found, resilience)
    assert [chart.y.high for chart in charts] == pytest.approx([1.05 * 0.06 * MRAD] * 3, rel=1e-6)
    assert [chart.x.high for chart in charts] == pytest.approx([LAPS * LAP] * 3)
    assert {chart.x.low for chart in charts} == {chart.y.low for chart in charts} == {0.0}
    assert {tuple(chart.events) for chart in charts} == {((4.0, "+2 kg"), (8.0, "\N{MINUS SIGN}2 kg"))}


def test_one_controller_that_oscillates_does_not_flatten_the_others(put, read):
    """The axis ends at three times the middle one's peak; what goes beyond is said in words."""
    for controller, level in (("a_law", 0.01), ("b_law", 0.02), ("wild", 5.0)):
        put(controller, level=level)
    found, resilience = read()
    charts = {chart.title: chart for chart in curve_charts(found, resilience)}
    assert charts["wild / none"].y.high == pytest.approx(1.05 * 3.0 * 0.04 * MRAD, rel=1e-6)
    assert ", up to 10000 beyond the chart" in charts["wild / none"].y.title
    assert "beyond the chart" not in charts["a_law / none"].y.title


def test_zooms_show_the_spiking_controller_and_its_ablations_only(put, read):
    """As the paper's panels; a classical law in them would be another comparison."""
    for controller in ("flexiv_factory", "no_learning", "cbmc_v3"):
        put(controller)
    found, resilience = read()
    charts = zoom_charts(found, resilience)
    assert [[curve.label for curve in chart.curves] for chart in charts] == [
        ["cbmc_v3 / none", "no_learning / none"]
    ] * 3
    lengths = [chart.x.high - chart.x.low for chart in charts]
    assert lengths == [START_ZOOM, HEAVIER_ZOOM, LIGHTER_ZOOM]
    assert [chart.x.low for chart in charts] == [0.0, 4.0, 8.0]
    assert all(chart.y.low == 0.0 for chart in charts)


def test_without_the_spiking_controller_there_is_nothing_to_zoom_on(put, read):
    """The section is there, its panels are not."""
    put("flexiv_factory")
    found, resilience = read()
    assert zoom_charts(found, resilience) == []


def test_the_time_of_a_curve_is_its_samples_by_their_distance():
    """From time 0 on, the lead-in is gone."""
    curve = MeanCurve(dt=0.25, seeds=np.zeros((2, 4)), repetitions=(0, 1), paths=3)
    assert curve.t.tolist() == [0.0, 0.25, 0.5, 0.75]
