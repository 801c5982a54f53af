"""What a controller shows of itself: rows in the trace, figures in the row, periods in the provenance."""

import numpy as np
import pytest
from torquebench.controllers import Controller
from torquebench.scenarios.diagnostics import LARGEST, figures
from torquebench.scenarios.execution import execute
from torquebench.scenarios.result import Scores
from torquebench.scenarios.store import Store
from torquebench.scenarios.trace import decode_trace


class Shows(Controller):
    """Computed torque that shows the time, and keeps the ticks at which joint 1 moved fast."""

    def reset(self, task):
        self.robot, self.clock, self.fast = task.robot, np.zeros(2), np.zeros(8)
        self.count = 0

    def compute(self, observation, target):
        self.clock[:] = observation.time, 1.0
        if self.count < 8 and observation.dq[0] > 0.1:
            self.fast[self.count], self.count = observation.time, self.count + 1
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        return self.robot.inverse_dynamics(observation.q, observation.dq, target.ddq + 400 * error + 40 * error_rate)

    def diagnostics(self):
        return {"clock": (self.clock, 10)}

    def events(self):
        return {"fast": self.fast[: self.count]}


def shown(specification, law=Shows, **options):
    """Return the row of a run."""
    (row,) = execute(specification, evaluate=lambda _: Scores(metrics={}), plug_ins={"mine": law}, **options)
    return row


def test_figures_are_means_over_the_run_and_its_laps():
    """A ramp of slope 1 over a lead-in and two laps of 1 s: 1 s in the mean, 0.5 and 1.5 s by lap."""
    t = np.round(np.arange(2500) * 1e-3 - 0.5, 9)
    (found,) = figures({"t": (t[::10], 10)}, t, 1.0).values()
    assert found["run_mean"] == pytest.approx([0.995])
    assert found["lap_means"] == [pytest.approx([0.495]), pytest.approx([1.495])]
    assert found["last_lap_mean"] == found["lap_means"][1]
    assert found["steady_std"] == pytest.approx([np.std(np.arange(1.0, 2.0, 0.01))])


def test_rows_that_miss_the_start_of_a_lap_belong_to_the_lap_of_their_own_time():
    """A period that does not divide the lead-in: row j is that of tick j times the period, wherever laps begin."""
    t = np.round(np.arange(2005) * 1e-3 - 0.005, 9)
    lap_of_row = np.floor(t[::10] + 1e-9)
    (found,) = figures({"lap": (lap_of_row, 10)}, t, 1.0).values()
    assert found["lap_means"] == [[0.0], [1.0]]


def test_a_window_without_a_row_has_no_number():
    """One lap only, and a period longer than it: nothing is invented."""
    t = np.arange(1000) * 1e-3
    (found,) = figures({"once": (np.ones((1, 2)), 1000)}, t, 1.0).values()
    assert found["run_mean"] == [1.0, 1.0]
    assert np.isnan(found["steady_std"]).all()


def test_large_diagnostics_have_no_figures():
    """A raster is a picture; its row would not fit into a table."""
    t = np.arange(1000) * 1e-3
    rows = {"small": (np.ones((100, LARGEST)), 10), "large": (np.ones((100, LARGEST + 1)), 10)}
    assert list(figures(rows, t, 1.0)) == ["small"]


def test_a_row_has_the_figures_and_the_periods(run_of, tmp_path):
    """From the row alone: which tick a row of the trace belongs to, and how the value went from lap to lap."""
    row = shown(run_of(laps=2))
    with Store.write(tmp_path / "out") as store:
        store.put("aa", run_of(laps=2), [row])
        (stored,) = store.runs()
    kept = stored.result
    assert kept.provenance["diagnostics"] == {"clock": 10}
    assert kept.provenance["tick_s"] == 0.001
    assert kept.diagnostics["clock"]["lap_means"] == [pytest.approx([0.995, 1.0]), pytest.approx([2.995, 1.0])]
    trace = decode_trace(row.trace)
    assert np.allclose(trace["diagnostics/clock"][:, 0], -0.2 + 0.01 * np.arange(420), atol=1e-9)


def test_a_failed_run_has_rows_but_no_figures(run_of):
    """What led to the failure can be seen; a mean over half a run cannot be compared."""
    broken = type("Broken", (Shows,), {"compute": lambda self, o, t: np.full(7, np.nan)})
    row = shown(run_of(), broken)
    assert (row.status, row.diagnostics) == ("failed", {})
    assert row.provenance["diagnostics"] == {"clock": 10}


def test_event_buffers_are_kept_with_full_traces_only(run_of):
    """A spike raster is large: on request."""
    full, plot = (decode_trace(shown(run_of(), traces=kind).trace) for kind in ("full", "plot"))
    assert full["events/fast"].shape == (8,)
    assert not any(name.startswith("events/") for name in plot)


@pytest.mark.parametrize(("hook", "traces"), [("events", "full"), ("diagnostics", "plot")])
def test_what_is_shown_has_to_be_numbers(run_of, hook, traces):
    """One line that names the hook; the campaign goes on."""
    odd = {"events": lambda _: {"x": ["a"]}, "diagnostics": lambda _: {"x": (np.array(["a"]), 1)}}
    row = shown(run_of(), type("Odd", (Shows,), {hook: odd[hook]}), traces=traces)
    assert (row.status, row.cause) == ("failed", "exception")
    assert row.reason.startswith(f"in {hook}: ")
