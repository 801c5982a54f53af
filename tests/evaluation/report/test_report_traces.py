"""Traces on their way to the page: which rows are scored, when a diagnostic was shown, and what a lost trace costs."""

import numpy as np
import pytest
from torquebench.controllers import InvalidInput
from torquebench.evaluation.report.traces import TICK, read_curves
from torquebench.evaluation.report.worlds import Run
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.store import StoredRun

DT = 1e-2


def arrays_of(*, lead_in=1.0, seconds=4.0, dt=DT, error=0.03, **shown):
    """Return the arrays of a kept trace: an arm whose second joint is off by a constant, wild in its lead-in."""
    t = np.arange(round((lead_in + seconds) / dt)) * dt - lead_in
    q = np.zeros((len(t), 7))
    q[:, 1] = np.where(t > -dt / 2, error, 1.0)
    kept = {"t": t, "q": q, "q_ref": np.zeros_like(q), **{f"diagnostics/{name}": rows for name, rows in shown.items()}}
    return {name: array.astype(np.float32) for name, array in kept.items()}


class Shelf:
    """A store that holds one trace, or none."""

    def __init__(self, arrays):
        self.arrays = arrays

    def trace(self, address, names):
        assert address == "abc"
        if isinstance(self.arrays, Exception):
            raise self.arrays
        return {name: array for name, array in self.arrays.items() if name in names}


@pytest.fixture
def run_with():
    """Builds a run of the store: status, the periods that it noted [ticks], and the address of its trace."""

    def build(*, status="ok", trace="abc", **provenance):
        result = RunResult(role="run", status=status, provenance=provenance)
        stored = StoredRun(address="run", specification=None, result=result, trace=trace)
        return Run(row=None, stored=stored)

    return build


def test_the_error_is_the_norm_over_joints_from_time_0_on(run_with):
    """What the arm did in its lead-in is no part of any figure."""
    arrays = arrays_of()
    arrays["q"][:, 4] += 0.04
    curves = read_curves(Shelf(arrays), run_with())
    assert len(curves.error) == 400
    assert curves.error == pytest.approx(0.05)
    assert (curves.dt, curves.duration) == (DT, pytest.approx(4.0))


@pytest.mark.parametrize("dt", [1e-3, 1e-2, 2e-2])
def test_the_time_between_samples_survives_single_precision(run_with, dt):
    """A time of 36 s in single precision is off by microseconds; their mean distance is exact."""
    curves = read_curves(Shelf(arrays_of(dt=dt, seconds=36.0)), run_with())
    assert curves.dt == dt
    assert curves.duration == pytest.approx(36.0)


@pytest.mark.parametrize(
    ("period", "lead_in", "start"), [(10, 1.0, 0.0), (50, 1.0, 0.0), (30, 1.0, 0.02), (70, 0.2, 0.01)]
)
def test_a_diagnostic_begins_with_its_first_row_after_the_lead_in(run_with, period, lead_in, start):
    """Row j is that of tick j times the period; a period that does not divide the lead-in begins between."""
    rows = -(-round((lead_in + 4.0) / TICK) // period)
    times = np.arange(rows) * period * TICK - lead_in
    run = run_with(diagnostics={"clock": period}, tick_s=TICK)
    curves = read_curves(Shelf(arrays_of(lead_in=lead_in, clock=times[:, None])), run, ("clock",))
    assert curves.periods == {"clock": pytest.approx(period * TICK)}
    assert curves.starts["clock"] == pytest.approx(start, abs=1e-6)
    assert curves.shown["clock"][0, 0] == pytest.approx(start, abs=1e-6)
    expected = curves.starts["clock"] + np.arange(len(curves.shown["clock"])) * curves.periods["clock"]
    assert curves.shown["clock"][:, 0] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("tick", [None, "fast"])
def test_a_run_that_did_not_note_its_tick_had_a_millisecond(run_with, tick):
    """Stores of an earlier version have diagnostics without it."""
    run = run_with(diagnostics={"x": 10}, **({} if tick is None else {"tick_s": tick}))
    assert read_curves(Shelf(arrays_of(x=np.ones((500, 1)))), run, ("x",)).periods == {"x": pytest.approx(10 * TICK)}


@pytest.mark.parametrize("noted", [{"other": 10}, {"x": 0}, {"x": "often"}, {"x": 2.5}, [("x", 10)], "x", None])
def test_a_diagnostic_without_a_period_is_left_out(run_with, noted):
    """Without it nobody knows when its rows were: no curve is better than one at the wrong time."""
    curves = read_curves(Shelf(arrays_of(x=np.ones((500, 1)))), run_with(diagnostics=noted), ("x",))
    assert curves.shown == {}
    assert len(curves.error) == 400


def test_a_diagnostic_that_ended_in_the_lead_in_has_no_curve(run_with):
    """One row at the first tick, a second before time 0."""
    curves = read_curves(Shelf(arrays_of(once=np.ones((1, 3)))), run_with(diagnostics={"once": 10_000}), ("once",))
    assert curves.shown == {}


@pytest.mark.parametrize("changes", [{"status": "failed"}, {"status": "refused"}, {"trace": ""}])
def test_a_run_without_a_whole_trace_has_no_curve(run_with, changes):
    """A failed run's trace stops where it fell: its mean over laps would be one of fewer laps."""
    assert read_curves(Shelf(AssertionError("not asked for")), run_with(**changes)) is None


@pytest.mark.parametrize(
    "lost",
    [
        InvalidInput("trace abc is damaged"),
        {},
        {"t": np.arange(3.0)},
        {name: rows for name, rows in arrays_of().items() if name != "q_ref"},
        {**arrays_of(), "q": np.zeros((3, 7))},
        {name: rows[:0] for name, rows in arrays_of().items()},
    ],
    ids=["damaged", "empty", "times only", "no plan", "other length", "no tick"],
)
def test_a_trace_that_cannot_be_read_costs_its_curve_and_nothing_else(run_with, lost):
    """A page of two hundred runs must not fall for one broken file."""
    assert read_curves(Shelf(lost), run_with()) is None


def test_what_was_shown_comes_back_in_double_precision(run_with):
    """Correlations of gains near 200 that move by 1e-3 have no digits to lose twice."""
    curves = read_curves(Shelf(arrays_of(x=np.ones((500, 1)))), run_with(diagnostics={"x": 10}), ("x",))
    assert curves.shown["x"].dtype == np.float64
