"""From a specification to rows: every failure is a row, every row the same to the bit."""

import numpy as np
import pytest
from torquebench.controllers import Controller, DesignInertia, LedgerEntry, UnknownName
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import Scores
from torquebench.scenarios.trace import decode_trace

HEAVY = Payload(mass=3.5, material="sand")
STEP = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.5, HEAVY), (1.0, Payload(mass=1.5))))


class Law(Controller):
    """Computed torque with a ledger and a counter."""

    def __init__(self, *, gain=400.0):
        self.gain, self.closed = gain, False

    def reset(self, task):
        self.robot, self.calls = task.robot, 0

    def compute(self, observation, target):
        self.calls += 1
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        acceleration = target.ddq + self.gain * error + 2 * np.sqrt(self.gain) * error_rate
        return self.robot.inverse_dynamics(observation.q, observation.dq, acceleration)

    def ledger(self):
        return (LedgerEntry(setting="gain", value=self.gain, source="chosen", note="by hand"),)

    def operations(self):
        return {"calls": self.calls}

    def close(self):
        self.closed = True


def mean_error(log):
    """Score a log by one number."""
    value = float(np.linalg.norm(log.p - log.p_ref, axis=1).mean())
    return Scores(metrics={"run": {"error": {"value": value, "status": "ok", "unit": "m", "n": len(log.t)}}})


def rows(specification, law=Law, **options):
    """Execute a specification with a law behind the name mine."""
    return execute(specification, evaluate=mean_error, plug_ins={"mine": law}, **options)


@pytest.fixture
def broken():
    """Builds a law with one method replaced."""

    def build(**methods):
        return type("Broken", (Law,), methods)

    return build


def test_a_sound_run_is_a_row_with_all_it_says_of_itself(run_of):
    """Status, score, ledger, counters, times, payload."""
    (row,) = rows(run_of(tier="actuated", settings={"gain": 500.0}))
    assert (row.role, row.status, row.cause, row.reason, row.failed_at) == ("run", "ok", "", "", None)
    assert row.metrics["run"]["error"]["value"] < 0.005
    assert row.ledger[0]["setting"] == "gain"
    assert row.ledger[0]["value"] == 500.0
    assert row.counts["ticks"] == row.counts["operations"]["calls"] == 2200
    assert row.timing["simulated_s"] == pytest.approx(2.2)
    assert 0 < row.timing["loop_s"] < row.timing["total_s"]
    assert row.provenance["plant"] == "pinocchio"


def test_the_same_run_twice_is_the_same_to_the_bit(run_of, plant_name):
    """One seed, one result: score and trace, noise and load steps in."""
    specification = run_of(tier="actuated", schedule=STEP, plant=plant_name)
    (one,), (two,) = rows(specification, traces="full"), rows(specification, traces="full")
    assert one.metrics == two.metrics
    assert one.trace == two.trace


def test_a_run_and_its_twins_are_rows_of_one_call(run_of):
    """The run, both constants, and the heavy load that stays."""
    found = rows(run_of(schedule=STEP, twins=True))
    assert [row.role for row in found] == ["run", "constant 1.5 kg", "constant 3.5 kg sand", "3.5 kg sand stays"]
    assert {row.status for row in found} == {"ok"}


def test_a_run_equals_its_twin_up_to_the_event(run_of):
    """Same draws, same controller seed: before 0.5 s to the bit, after it apart."""
    run, light, *_ = (
        decode_trace(row.trace) for row in rows(run_of(schedule=STEP, twins=True, tier="actuated"), traces="full")
    )
    event = np.searchsorted(run["t"], 0.5)
    assert np.array_equal(run["q"][: event + 1], light["q"][: event + 1])
    assert not np.array_equal(run["q"][event + 1], light["q"][event + 1])


def test_a_plot_trace_is_every_tenth_tick(run_of):
    """In single precision: enough for the eye."""
    specification = run_of()
    full, plot = (decode_trace(rows(specification, traces=kind)[0].trace) for kind in ("full", "plot"))
    assert len(full["t"]) == 2200
    assert np.array_equal(plot["q"], full["q"][::10].astype(np.float32))
    assert rows(specification, traces="none")[0].trace is None


def raises(*_):
    """Raise what nobody expects."""
    raise RuntimeError("out of\ncheese")


FAULTS = {
    "reset": ({"reset": raises}, "failed", "exception", "in reset: RuntimeError: out of cheese"),
    "compute": ({"compute": raises}, "failed", "exception", "RuntimeError: out of cheese"),
    "nan": ({"compute": lambda *_: np.full(7, np.nan)}, "failed", "nan torque", "torque of joint 1 is nan"),
    "shape": ({"compute": lambda *_: np.zeros(6)}, "failed", "wrong shape", r"returned shape (6,)"),
    "falls": ({"compute": lambda *_: np.zeros(7)}, "failed", "divergence", ""),
    "supports": ({"supports": lambda *_: "needs eight joints"}, "refused", "refused", "needs eight joints"),
    "supports raises": ({"supports": raises}, "failed", "exception", "RuntimeError: out of cheese"),
    "diagnostics": ({"diagnostics": raises}, "failed", "exception", "in diagnostics: RuntimeError: out of cheese"),
    "ledger": ({"ledger": raises}, "failed", "exception", "in ledger: RuntimeError: out of cheese"),
    "ledger of text": ({"ledger": lambda _: ("gain 3",)}, "failed", "exception", "in ledger: TypeError"),
    "ledger of arrays": (
        {"ledger": lambda _: (LedgerEntry(setting="a", value=np.ones(2), source="rule"),)},
        "failed",
        "exception",
        "in ledger: TypeError: Object of type ndarray is not JSON serializable",
    ),
    "operations": ({"operations": lambda _: {"calls": "many"}}, "failed", "exception", "in operations: ValueError"),
    "unstable": (
        {"design_inertia": lambda _: DesignInertia(mass_matrix=100 * np.eye(7), damping=100.0)},
        "refused",
        "refused",
        "times the plant's inertia",
    ),
}


@pytest.mark.parametrize(("methods", "status", "cause", "reason"), FAULTS.values(), ids=FAULTS)
def test_whatever_goes_wrong_inside_is_a_row(run_of, broken, methods, status, cause, reason):
    """With a status, a cause from the short list and one line; the campaign goes on."""
    (row,) = rows(run_of(), broken(**methods))
    assert (row.status, row.cause) == (status, cause)
    assert reason in row.reason
    assert "\n" not in row.reason
    assert not row.metrics


def test_a_failed_run_says_when_it_failed(run_of, broken):
    """On the plan's clock, with the counters up to there."""
    (row,) = rows(run_of(), broken(compute=lambda *_: np.zeros(7)))
    assert -0.2 < row.failed_at < 2.0
    assert row.counts["ticks"] == round((row.failed_at + 0.2) * 1000) + 1
    assert row.ledger


def test_a_constructor_that_fails_is_a_row_too(run_of):
    """A wrong setting of one controller is no reason to stop the others."""
    (row,) = rows(run_of(settings={"gian": 3.0}))
    assert (row.status, row.cause) == ("failed", "exception")
    assert "unknown setting 'gian'; did you mean 'gain'" in row.reason


def test_a_plug_in_that_cannot_be_imported_is_a_row(run_of):
    """Broken code of one author."""
    (row,) = execute(run_of(controller="nowhere_at_all:Law"), evaluate=mean_error)
    assert row.status == "failed"
    assert "could not be loaded: ModuleNotFoundError" in row.reason


def test_a_failed_twin_does_not_take_the_run_with_it(run_of, broken):
    """Its event is undefined later; the run's own row stands."""

    def heavy_only(self, observation, target):
        torque = Law.compute(self, observation, target)
        return torque if observation.wrench[2] < 30.0 else np.full(7, np.nan)

    found = rows(run_of(schedule=LoadSchedule.constant(Payload(mass=1.5)), twins=True), broken(compute=heavy_only))
    assert [row.status for row in found] == ["ok"]
    found = rows(run_of(schedule=STEP, twins=True), broken(compute=heavy_only))
    assert {row.role: row.status for row in found}["constant 1.5 kg"] == "ok"
    assert {row.role: row.status for row in found}["constant 3.5 kg sand"] == "failed"


@pytest.mark.parametrize("methods", [{}, {"compute": raises}, {"reset": raises}], ids=["sound", "fails", "no reset"])
def test_a_controller_is_closed_whatever_happened(run_of, broken, methods):
    """It may hold threads or files."""
    made = []

    def remember(self, *, gain=400.0):
        Law.__init__(self, gain=gain)
        made.append(self)

    rows(run_of(), broken(__init__=remember, **methods))
    assert [law.closed for law in made] == [True]


def test_a_close_that_fails_takes_nothing_from_the_result(run_of, broken):
    """The run is over by then."""
    (row,) = rows(run_of(), broken(close=raises))
    assert row.status == "ok"


def test_a_world_that_cannot_be_had_is_an_error_and_no_row(run_of):
    """It would be the same for every controller: the campaign must not start."""
    with pytest.raises(UnknownName):
        rows(run_of(trajectory="T9"))


def test_knowledge_of_the_load_takes_its_error_away(run_of):
    """3.5 kg that the law does not know against the oracle: the same law, the same run."""
    schedule = LoadSchedule.constant(HEAVY)
    blind, knowing = (
        rows(run_of(schedule=schedule, knowledge=level))[0].metrics["run"]["error"]["value"]
        for level in ("none", "oracle")
    )
    assert knowing < 1e-4 < 0.01 < blind
