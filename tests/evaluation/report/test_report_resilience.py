"""Load events on the page: recovery beside its steady error, what never came, what could not be judged, curves."""

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from torquebench.evaluation.metrics import EVENT_METRICS
from torquebench.evaluation.report import write_report
from torquebench.evaluation.report.findings import find_all
from torquebench.evaluation.report.resilience import resilience_of
from torquebench.evaluation.report.resilience_figures import curve_charts
from torquebench.evaluation.report.worlds import worlds_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.store import Store
from torquebench.scenarios.trace import encode_trace

LAP, LAPS, DT = 3.0, 12, 1e-2
STEP = LoadSchedule(
    entries=((0.0, Payload(mass=1.5)), (12.0, Payload(mass=3.5, material="sand")), (24.0, Payload(mass=1.5)))
)
PATHS = ("S1", "S2", "S3")


def error_of(size, decay=0.4, level=0.02):
    """A level, an exponential at each event, on the grid of a kept trace with its lead-in."""
    t = np.arange(-100, round(LAPS * LAP / DT)) * DT
    error = np.full(len(t), level)
    for event in (12.0, 24.0):
        since = t - event
        error += np.where(since > -DT / 2, size * np.exp(-np.maximum(since, 0.0) / decay), 0.0)
    return t, error


def trace_of(size, **changes):
    t, error = error_of(size, **changes)
    q = np.zeros((len(t), 7))
    q[:, 2] = error
    arrays = {"t": t, "q": q, "q_ref": np.zeros_like(q)}
    return encode_trace({name: array.astype(np.float32) for name, array in arrays.items()})


def event_values(recovery, status="ok", reason=""):
    values = {
        name: {"value": recovery if "time" in name else 2.0, "unit": metric.unit, "status": "ok", "n": 5}
        for name, metric in EVENT_METRICS.items()
    }
    if status != "ok":
        values = {
            name: {**value, "value": math.nan, "status": status, "reason": reason} for name, value in values.items()
        }
    return values


def put(shelf, controller, trajectory, *, recovery=1.0, size=0.05, repetition=0, events=None, trace=True, **changes):
    run = replace(
        shelf.specification(controller, "none", trajectory), schedule=STEP, twins=True, laps=LAPS, repetition=repetition
    )
    result = shelf.result(run, 1e-2, "slow")
    windows = events or {"event@12": event_values(recovery), "event@24": event_values(recovery)}
    result = replace(
        result,
        metrics={**result.metrics, **windows},
        repetition=repetition,
        trace=trace_of(size, **changes) if trace else None,
    )
    twins = ("constant 1.5 kg", "constant 3.5 kg sand", "3.5 kg sand stays")
    shelf.put(run, result, *(replace(result, role=role, trace=None) for role in twins))


def text_of(page):
    return re.sub(r"<[^>]+>", " ", re.sub(r"<(style|script)>.*?</\1>", "", page.html, flags=re.DOTALL))


@pytest.fixture
def events(shelf):
    for repetition in range(2):
        for path in PATHS:
            put(shelf, "cbmc_v3", path, repetition=repetition)
            put(shelf, "flexiv_factory", path, repetition=repetition, recovery=0.25, size=0.01, level=0.08)
    return shelf.campaign()


def row_of(page, table, label):
    found = re.search(rf'<table id="{table}">.*?</table>', page.html, re.DOTALL)
    rows = re.findall(r"<tr>.*?</tr>", found.group(), re.DOTALL)
    plain = [re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", row)) for row in rows]
    return next(row for row in plain if label in row)


def test_a_store_without_load_events_has_no_such_section(quick):
    assert "w1-resilience" not in quick.html
    assert "resilience" not in quick.summary["worlds"][0]


def test_recovery_stands_beside_the_error_that_it_arrives_at(events):
    """A wide band recovers at once: the steady error comes first in the row."""
    page = events.report()
    spiking, factory = (row_of(page, "w1-event-12", label) for label in ("v3", "factory"))
    assert re.search(r"0 / 6 20\.0 \[20\.0\.\.20\.0\] 1\.00 \[1\.00\.\.1\.00\]", spiking)
    assert re.search(r"0 / 6 80\.0 .*? 0\.25 ", factory)


def test_recovery_from_the_curves_is_the_closed_form(events):
    """50 mrad that decay are at a fifth after tau ln 5, at a tenth of the 20 mrad below them after tau ln 25."""
    world = events.report().summary["worlds"][0]["resilience"]
    assert world["curve_period_s"] == pytest.approx(DT)
    for event in world["events"][1:]:
        found = event["controllers"]["cbmc_v3 / none"]
        assert found["recovery_time_cycle_band"]["median"] == pytest.approx(0.4 * math.log(5.0), abs=0.06)
        assert found["recovery_time_paper_style"]["median"] == pytest.approx(0.4 * math.log(25.0), abs=0.06)
        assert found["last_cycle_error"]["median"] == pytest.approx(0.02, rel=1e-3)
        assert found["recovery_time_cycle_band"]["n"] == 2


def test_the_start_is_judged_by_the_curves_only(events):
    page = events.report()
    assert "Start-up at 0 s: median over seeds, from the mean curves: a start has no twin" in text_of(page)
    assert "recovery_time_settled" not in page.summary["worlds"][0]["resilience"]["events"][0]["controllers"][
        "cbmc_v3 / none"
    ]  # fmt: skip


def test_a_recovery_that_never_came_is_a_word_and_ranks_worst(events):
    never = event_values(1.0)
    never["recovery_time_settled"] |= {"value": math.inf, "status": "censored"}
    for path in PATHS:
        put(events, "pid", path, events={"event@12": never, "event@24": event_values(1.0)})
    put(events, "pid", "S1", repetition=1)
    page = events.report()
    row = row_of(page, "w1-event-12", "pid")
    assert "never [1.00..never] 3 of 4 never" in row
    assert not re.search(r"\b(nan|None|inf|Infinity)\b", text_of(page))
    found = page.summary["worlds"][0]["resilience"]["events"][1]["controllers"]["pid / none"]["recovery_time_settled"]
    assert (found["median"], found["never"], found["n"], found["high"]) == (None, 3, 4, 1.0)


def test_a_failed_twin_is_listed_with_its_reason(events):
    reason = "twin 'constant 3.5 kg sand' failed: joint 4 is 1.02 rad from its plan"
    for path in PATHS:
        put(events, "pid", path, events={
            "event@12": event_values(1.0, "undefined", reason), "event@24": event_values(1.0, "failed", "seed leaked"),
        })  # fmt: skip
    page = events.report()
    assert "\N{EMPTY SET} undefined" in row_of(page, "w1-event-12", "pid")
    assert "\N{EMPTY SET} failed" in row_of(page, "w1-event-24", "pid")
    unjudged = row_of(page, "w1-unjudged", "+2 kg at 12 s")
    assert "joint 4 is 1.02 rad from its plan" in unjudged
    assert page.summary["worlds"][0]["resilience"]["not_judged"] == 6


def test_a_run_that_failed_is_counted_and_has_no_part_in_a_median(events):
    run = replace(events.specification("cbmc_v3", "none", "S1"), schedule=STEP, twins=True, laps=LAPS, repetition=2)
    events.fail(run)
    page = events.report()
    assert "1 / 7" in row_of(page, "w1-event-12", "v3")
    curve = page.summary["worlds"][0]["resilience"]["events"][1]["controllers"]["cbmc_v3 / none"]["last_cycle_error"]
    assert curve["n"] == 2


def test_runs_without_a_trace_cost_their_curve_not_their_row(shelf):
    for path in PATHS:
        put(shelf, "cbmc_v3", path)
        put(shelf, "pid", path, trace=False)
    page = shelf.campaign().report()
    assert "pid / none has no curve: no trace was kept." in text_of(page)
    row = row_of(page, "w1-event-12", "pid")
    assert "1.00 [1.00..1.00]" in row
    assert "not computed" in row
    assert len(re.findall('<figure id="w1-curve-', page.html)) == 1


def test_a_damaged_trace_costs_its_curve_not_the_page(events):
    for file in sorted((events.folder / "traces").rglob("*.npz")):
        file.write_bytes(b"broken")
    page = events.report()
    assert "cbmc_v3 / none has no curve" in text_of(page)


def test_a_seed_with_a_missing_path_is_no_mean_over_paths(events):
    """A mean over the easy two of three paths is no better than one over all."""
    put(events, "cbmc_v3", "S1", repetition=2, size=0.5)
    page = events.report()
    found = page.summary["worlds"][0]["resilience"]["events"][1]["controllers"]["cbmc_v3 / none"]
    assert found["error_peak_raw"]["n"] == 2
    assert found["recovery_time_settled"]["n"] == 7


def test_without_twins_the_page_says_that_curves_are_all_there_is(shelf):
    for path in PATHS:
        run = replace(shelf.specification("cbmc_v3", "none", path), schedule=STEP, laps=LAPS)
        shelf.put(run, replace(shelf.result(run, 1e-2, "slow"), trace=trace_of(0.05)))
    text = text_of(shelf.campaign().report())
    assert "No twins ran: recovery can be read from the curves only." in text


def test_unstable_counts_of_peaks_are_called_so(events):
    shaky = event_values(1.0)
    shaky["recovery_peaks_stable"] |= {"value": math.nan, "status": "undefined"}
    for path in PATHS:
        put(events, "pid", path, events={"event@12": shaky, "event@24": event_values(1.0)})
    page = events.report()
    assert "unstable in 3 of 3" in row_of(page, "w1-peaks-12", "pid")
    assert "stable" in row_of(page, "w1-peaks-24", "pid")


def test_the_same_event_again_and_again_has_a_rate_of_improvement(shelf):
    """Each addition costs half of the one before; two removals are too few to say."""
    loads = [Payload(mass=1.5), Payload(mass=3.5, material="sand")]
    entries = tuple((6.0 * n, loads[n % 2]) for n in range(6))
    run = replace(shelf.specification("cbmc_v3", "none", "S1"), schedule=LoadSchedule(entries=entries), laps=LAPS)
    windows = {f"event@{6 * n}": event_values(1.0) for n in range(1, 6)}
    for n in (1, 3, 5):
        windows[f"event@{6 * n}"]["excess_integral"] |= {"value": 0.02 * 0.5 ** ((n - 1) // 2)}
    result = shelf.result(run, 1e-2, "slow")
    shelf.put(run, replace(result, metrics={**result.metrics, **windows}))
    page = shelf.campaign().report()
    rates = page.summary["worlds"][0]["resilience"]["improvement_rate"]
    assert list(rates) == ["+2 kg, cbmc_v3 / none"]
    assert rates["+2 kg, cbmc_v3 / none"]["median"] == pytest.approx(-math.log(2.0))
    assert "\N{MINUS SIGN}0.693" in row_of(page, "w1-improvement", "v3")


def test_every_chart_is_a_file_of_its_own_and_linked(events):
    page = events.report()
    ids = re.findall(r'<figure id="([^"]+)"', page.html)
    assert {"w1-curve-1", "w1-curve-2", "w1-zoom-0", "w1-zoom-12", "w1-zoom-24"} <= set(ids)
    assert {file.stem for file in page.files.figures.glob("*.svg")} == set(ids)
    for file in page.files.figures.glob("*.svg"):
        root = ET.fromstring(file.read_text(encoding="utf-8"))
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        assert "var(--" not in file.read_text(encoding="utf-8")
    for name in ids:
        assert f'href="figures/{name}.svg"' in page.html


def test_figures_that_a_page_no_longer_has_are_removed(events):
    page = events.report()
    stale = page.files.figures / "w9-curve-1.svg"
    stale.write_text("old", encoding="utf-8")
    own = page.files.figures / "notes.svg"
    own.write_text("mine", encoding="utf-8")
    write_report(events.folder)
    assert not stale.exists()
    assert own.exists()


def test_two_reports_of_load_events_are_equal_to_the_byte(events):
    page = events.report()
    assert write_report(events.folder).index.read_text(encoding="utf-8") == page.html


def test_a_page_with_many_controllers_stays_below_two_megabytes(shelf):
    rng = np.random.default_rng(0)
    for number in range(16):
        for path in PATHS:
            put(shelf, f"law_{number}", path, size=0.05 + 0.001 * rng.normal(), level=0.02 + 0.001 * number)
    assert len(shelf.campaign().report().html.encode()) < 2e6


def test_the_twins_of_constant_loads_stand_beside_the_curve(shelf):
    """Recovery is judged against them; the one whose event never ends judges no recovery and stays away."""
    run = replace(shelf.specification("cbmc_v3", "none", "S1"), schedule=STEP, twins=True, laps=LAPS)
    kept = replace(shelf.result(run, 1e-2, "slow"), trace=trace_of(0.05))
    twins = ("constant 1.5 kg", "constant 3.5 kg sand", "3.5 kg sand stays")
    shelf.put(run, kept, *(replace(kept, role=role, trace=trace_of(0.0)) for role in twins))
    shelf.store.close()
    with Store.read(shelf.folder) as store:
        (found,) = find_all(worlds_of(store.runs(), store.campaigns()))
        (chart,) = curve_charts(found, resilience_of(found.world, store))
    assert [curve.label for curve in chart.curves] == [
        "twin, constant 1.5 kg", "twin, constant 3.5 kg sand", "cbmc_v3 / none",
    ]  # fmt: skip
    assert chart.curves[-1].y.max() > chart.curves[0].y.max()
