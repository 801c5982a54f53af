"""Worker processes: what they inherit, what they give back, and what a dead one costs."""

import os

import pytest
from torquebench.controllers import Controller
from torquebench.scenarios.workers import THREAD_VARIABLES, Duty, run_in_workers
from torquebench.scoring import score


class Pools(Controller):
    """Computed torque that counts as operations what its process was told of thread pools."""

    def __init__(self, *, dies=False, exits=0):
        self.dies, self.exits = dies, exits

    def reset(self, task):
        self.robot, self.ticks = task.robot, 0

    def compute(self, observation, target):
        self.ticks += 1
        if self.ticks > 100 and self.dies:
            os.abort()
        if self.ticks > 100 and self.exits:
            os._exit(self.exits)
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        return self.robot.inverse_dynamics(observation.q, observation.dq, target.ddq + 400 * error + 40 * error_rate)

    def operations(self):
        limits = {name: int(os.environ.get(name, 0)) for name in THREAD_VARIABLES}
        return {**limits, "process": os.getpid()}


class Learner(Pools):
    """The same with something to carry over."""

    carry_over = True


@pytest.fixture
def working():
    """Runs specifications in worker processes and returns position to results."""

    def run(specifications, *, workers=1):
        duty = Duty(evaluate=score, traces="none", plug_ins={})
        found = list(run_in_workers(specifications, duty, workers=workers))
        assert len({position for position, _ in found}) == len(found)
        return dict(found)

    return run


@pytest.fixture
def short(run_of):
    """Builds the specification of a run of two seconds, its law behind the door of this file."""
    return lambda **changes: run_of(**{"lead_in": 0.1, "controller": f"{__file__}:Pools"} | changes)


def test_a_process_ends_and_only_its_own_run_is_lost(short, working, monkeypatch):
    """An abort, a foreign exit status and a sound run in one campaign: three rows, in whatever order.

    Every process finds all thread pools set to one, whatever the coordinator's own environment says.
    """
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    found = working(
        [short(settings={"dies": True}), short(settings={"exits": 3}), short(), short(trajectory="S1")], workers=2
    )
    rows = [found[position][0] for position in range(4)]
    assert [(row.status, row.cause) for row in rows[:2]] == [("failed", "crash")] * 2
    assert rows[0].reason == "the process of the run ended with SIGABRT"
    assert rows[1].reason == "the process of the run ended with status 3"
    for row in rows[2:]:
        assert row.status == "ok"
        assert {row.counts["operations"][name] for name in THREAD_VARIABLES} == {1}
        assert row.counts["operations"]["process"] != os.getpid()
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


def test_a_world_that_cannot_be_had_is_a_failed_row_in_one_line(short, working):
    """A night's campaign must not end at its third run because a file of the first two has been moved meanwhile."""
    (lost,), (sound,) = working([short(robot="gone.toml"), short()]).values()
    assert (lost.role, lost.status, lost.cause) == ("run", "failed", "exception")
    assert lost.reason.startswith("InvalidInput: ") and "gone.toml" in lost.reason
    assert "\n" not in lost.reason
    assert sound.status == "ok"


def test_the_process_of_a_chain_costs_every_repetition_of_it(short, working):
    """What a later link would have learnt is gone with the process: a row for each, none of them missing."""
    chain = short(protocol="carried", repetitions=3, settings={"exits": 5}, controller=f"{__file__}:Learner")
    (rows,) = working([chain]).values()
    assert [row.repetition for row in rows] == [0, 1, 2]
    assert {(row.status, row.cause) for row in rows} == {("failed", "crash")}


def test_no_runs_need_no_answers(working):
    """An empty campaign ends at once."""
    assert working([]) == {}
