"""One trial: what a run says of itself beside its scores, recomputed from its own log."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.controllers import LedgerEntry, Refusal
from torquebench.scenarios.result import Scores
from torquebench.scenarios.trace import decode_trace
from torquebench.scenarios.trial import TRACE_STEP, TRACED, Keeping, run_trial

TICKS = 105
"""Length of the trials here: no multiple of the step of a plot trace."""


class Judge:
    """Scores a log by its number of ticks, and counts how often it is asked."""

    def __init__(self):
        self.logs = []

    def __call__(self, log):
        self.logs.append(log)
        return Scores(
            metrics={"run": {"ticks": {"value": float(len(log.t)), "status": "ok"}}},
            laps={"ticks": [1.0]},
            timing={"slow": 2.0},
        )


@pytest.fixture
def judge():
    """A judge that keeps the logs it was shown."""
    return Judge()


@pytest.fixture
def tried(world_of, judge):
    """Tries a controller for 105 ticks of a short world and returns the trial."""

    def run(controller, *, traces="none", snapshot=False, role="run", **changes):
        world = world_of(seconds=TICKS * 1e-3, **changes)
        keeping = Keeping(evaluate=judge, traces=traces, snapshot=snapshot)
        return run_trial(world, controller, role=role, keeping=keeping)

    return run


def test_the_judge_sees_the_log_that_the_trial_keeps(tried, judge, follows):
    """Twins are compared on the very arrays that the metrics were computed from."""
    trial = tried(follows)
    assert judge.logs == [trial.log]
    assert trial.result.metrics["run"]["ticks"]["value"] == len(trial.log.t) == TICKS
    assert trial.result.laps == {"ticks": [1.0]}
    assert trial.result.timing["slow"] == 2.0 and trial.result.timing["loop_s"] > 0.0


def test_a_refused_task_is_never_run_nor_judged(tried, judge, follows):
    """A refusal costs nothing and leaves nothing: no log, no score, no trace, no wall time."""
    follows.supports = lambda task: f"needs {task.initial_q.size + 1} joints"
    trial = tried(follows, traces="full")
    assert (trial.result.status, trial.result.cause) == ("refused", "refused")
    assert trial.result.reason == "needs 8 joints"
    assert trial.log is None and trial.result.trace is None and trial.result.timing == {}
    assert judge.logs == []
    assert not hasattr(follows, "seen")


def test_a_refusal_in_reset_is_a_refusal_too(tried, judge, follows):
    """A law may find only while it designs its gains that it cannot work here."""

    def refuse(task):
        raise Refusal(f"gain margin {0.4:g} < 1")

    follows.reset = refuse
    trial = tried(follows)
    assert (trial.result.status, trial.result.reason) == ("refused", "gain margin 0.4 < 1")
    assert judge.logs == []


def test_an_empty_answer_of_supports_is_no_refusal(tried, follows):
    """None and the empty text both mean: go on."""
    follows.supports = lambda task: ""
    assert tried(follows).result.status == "ok"


def test_a_failed_run_keeps_its_log_and_is_not_judged(tried, judge, says):
    """A mean over half a motion beside means over whole ones would flatter whoever falls first."""
    gives_up = says(lambda tick: np.full(7, np.nan) if tick == 40 else np.zeros(7))
    trial = tried(gives_up)
    assert (trial.result.status, trial.result.cause) == ("failed", "nan torque")
    assert trial.result.metrics == {} and trial.result.laps == {}
    assert judge.logs == []
    assert len(trial.log.t) == trial.result.counts["ticks"] == 41
    assert trial.result.failed_at == trial.log.t[-1] == pytest.approx(-0.2 + 40e-3)


def test_a_run_that_fails_in_its_first_tick_says_no_time(tried, says):
    """No tick was finished, so there is no time to name; every wall time is zero instead of an error."""

    def stumble(tick):
        raise ZeroDivisionError("gain")

    result = tried(says(stumble)).result
    assert (result.status, result.cause, result.failed_at) == ("failed", "exception", None)
    assert result.counts["ticks"] == 0
    assert result.timing["call_us_median"] == result.timing["call_us_p99"] == result.timing["call_us_max"] == 0.0
    assert result.timing["simulated_s"] == result.timing["deadline_misses"] == 0.0


def test_wall_times_fit_together(tried, follows):
    """Simulated time is ticks times the period, and the speed is its quotient with the loop's own time."""
    timing = tried(follows).result.timing
    assert timing["simulated_s"] == pytest.approx(TICKS * 1e-3)
    assert timing["real_time_factor"] == pytest.approx(timing["simulated_s"] / timing["loop_s"])
    assert 0.0 < timing["call_us_median"] <= timing["call_us_p99"] <= timing["call_us_max"]
    assert timing["reset_s"] > 0.0


def test_a_call_longer_than_a_period_is_a_missed_deadline(tried, says):
    """The arm does not wait: on hardware that torque would come too late, however good it is."""
    import time

    def slow(tick):
        time.sleep(2e-3 if tick in (3, 50, 90) else 0.0)
        return np.zeros(7)

    timing = tried(says(slow)).result.timing
    assert 3.0 <= timing["deadline_misses"] < TICKS / 2
    assert timing["call_us_max"] >= 2000.0


def test_the_torque_that_the_limiter_took_away_is_counted_by_joint(tried, says, rizon):
    """Only joint 3 asks for more than its drive gives, in every tick."""
    torque = np.zeros(7)
    torque[2] = 2.0 * rizon.effort[2]
    counts = tried(says(lambda tick: torque)).result.counts
    assert counts["clipped_effort"] == [0, 0, counts["ticks"], 0, 0, 0, 0]
    assert counts["clipped_rate"] == [0] * 7


def test_the_row_carries_what_the_plan_and_the_load_were(tried, world_of, follows):
    """Fast or slow, which plant, which ten parameters: the row alone must be enough to read it."""
    from torquebench.scenarios.loads import LoadSchedule, Payload

    heavy = LoadSchedule.constant(Payload(mass=3.5, material="sand"))
    provenance = tried(follows, schedule=heavy).result.provenance
    world = world_of(schedule=heavy)
    assert provenance["payload"] == world.truth.parameters.tolist()
    assert provenance["payload"][0] == pytest.approx(3.5 - world.robot.gripper_mass)
    assert (provenance["group"], provenance["plant"]) == (world.plan.group, "pinocchio")
    assert provenance["tick_s"] == world.tier.period


def test_role_and_repetition_are_those_that_were_asked_for(tried, follows):
    """A chain and its twins are told apart by these two alone."""
    result = tried(follows, role="constant 3.5 kg sand", repetition=4).result
    assert (result.role, result.repetition) == ("constant 3.5 kg sand", 4)
    assert follows.task.repetition == 4


@pytest.mark.parametrize("traces", ["plot", "full"])
def test_a_trace_is_the_log_at_its_step(tried, follows, traces):
    """Every tenth tick in single precision, or every tick to the bit; the last ticks are not lost to rounding."""
    trial = tried(follows, traces=traces, tier="actuated")
    step, kind = (1, np.float64) if traces == "full" else (TRACE_STEP, np.float32)
    trace = decode_trace(trial.result.trace)
    assert set(trace) == set(TRACED)
    for name in TRACED:
        assert trace[name].dtype == kind
        assert np.array_equal(trace[name], getattr(trial.log, name)[::step].astype(kind)), name
    assert len(trace["t"]) == -(-TICKS // step)


def test_what_was_learnt_is_kept_where_it_is_asked_for(tried, follows):
    """The last link of a chain keeps its weights; a run of the grid would only fill the disk with them."""
    weights = np.arange(6.0).reshape(2, 3)
    follows.snapshot = lambda: {"weights": weights}
    kept = decode_trace(tried(follows, traces="plot", snapshot=True).result.trace)
    assert np.array_equal(kept["snapshot/weights"], weights)
    assert "snapshot/weights" not in decode_trace(tried(follows, traces="plot").result.trace)
    assert tried(follows, traces="none", snapshot=True).result.trace is None


@pytest.mark.parametrize("array", [np.array(["a"]), np.array([1.0 + 2.0j]), np.array([None])])
def test_a_snapshot_that_is_no_array_of_numbers_fails_by_its_name(tried, follows, array):
    """What a trace cannot hold without pickling is refused here, not when somebody reads it a year later."""
    follows.snapshot = lambda: {"weights": array}
    result = tried(follows, traces="plot", snapshot=True).result
    assert (result.status, result.cause) == ("failed", "exception")
    assert "in snapshot: TypeError: 'snapshot/weights' is no array of numbers" in result.reason


def test_a_ledger_comes_back_as_json_would_give_it(tried, follows):
    """A tuple becomes a list at once, so that a fresh row equals the row that is read from the store."""
    follows.ledger = lambda: (LedgerEntry(setting="gains", value=(1, 2.5), source="tuned", trials=40),)
    (entry,) = tried(follows).result.ledger
    assert entry == {
        "setting": "gains",
        "value": [1, 2.5],
        "source": "tuned",
        "note": "",
        "trials": 40,
        "learnt_before": "",
    }


def test_operations_are_whole_numbers(tried, follows):
    """A NumPy counter must reach the row as a number that JSON knows."""
    follows.operations = lambda: {"multiplications": np.int64(7), "spikes": np.float64(3.0)}
    operations = tried(follows).result.counts["operations"]
    assert operations == {"multiplications": 7, "spikes": 3}
    assert {type(count) for count in operations.values()} == {int}


def test_a_law_of_two_methods_is_a_whole_controller(tried):
    """Inheriting is optional: every hook that is missing has the answer of who has nothing to say."""
    law = SimpleNamespace(reset=lambda task: None, compute=lambda observation, target: np.zeros(7))
    result = tried(law, traces="full", snapshot=True).result
    assert result.status == "ok"
    assert (result.ledger, result.diagnostics, result.counts["operations"]) == ([], {}, {})
    assert set(decode_trace(result.trace)) == set(TRACED)


def test_a_broken_hook_after_the_run_names_itself_and_leaves_no_score(tried, judge, follows):
    """A row is whole or it is a failure: metrics beside a ledger that could not be read would be compared."""

    def ledger():
        raise KeyError("bandwidth")

    follows.ledger = ledger
    trial = tried(follows, traces="full")
    assert trial.result.reason.startswith("in ledger: KeyError: 'bandwidth' (test_trial.py:")
    assert trial.result.metrics == {} and trial.result.trace is None and trial.log is None
    assert judge.logs == []


def test_a_metric_that_fails_is_no_fault_of_the_controller(world_of, follows):
    """The harness's own slip must not stand in the table as a controller's failure."""

    def broken(log):
        raise RuntimeError("a slip of ours")

    keeping = replace(Keeping(evaluate=broken), traces="none")
    with pytest.raises(RuntimeError, match="a slip of ours"):
        run_trial(world_of(), follows, role="run", keeping=keeping)
