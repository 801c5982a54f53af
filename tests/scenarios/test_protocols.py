"""Protocols: fresh runs know nothing of each other, a carried chain is one controller that lives on."""

import numpy as np
import pytest
from torquebench.controllers import Controller, InvalidInput
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import Scores
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.store import Store
from torquebench.scenarios.trace import decode_trace

HEAVY = Payload(mass=3.5, material="sand")


class Learner(Controller):
    """A stiff law that counts its resets and learns a mass by gradient descent on the error."""

    carry_over = True

    def __init__(self, *, rate=0.0):
        self.rate, self.tasks, self.mass = rate, [], np.zeros(1)

    def reset(self, task):
        self.tasks.append(task)
        self.robot = task.robot

    def compute(self, observation, target):
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        torque = self.robot.inverse_dynamics(observation.q, observation.dq, target.ddq + 400 * error + 40 * error_rate)
        lift = self.robot.at(observation.q, observation.dq).jacobian[2]
        self.mass += self.rate * (lift @ error)
        return torque + 9.81 * self.mass[0] * lift

    def snapshot(self):
        return {"mass": self.mass}


def error_of(log):
    """Score a log by its mean error."""
    value = float(np.linalg.norm(log.p - log.p_ref, axis=1).mean())
    return Scores(metrics={"run": {"error": {"value": value, "status": "ok", "unit": "m", "n": len(log.t)}}})


@pytest.fixture
def chain_of(run_of):
    """Runs a chain of a law and returns its rows and the controllers that were built."""

    def run(law=Learner, *, repetitions=3, traces="none", **changes):
        built = []

        def make(*, rate=0.0):
            built.append(law(rate=rate))
            return built[-1]

        specification = run_of(protocol="carried", repetitions=repetitions, **changes)
        return execute(specification, evaluate=error_of, traces=traces, plug_ins={"mine": make}), built

    return run


def errors(rows):
    """Return the error of every row."""
    return [row.metrics["run"]["error"]["value"] for row in rows]


def test_a_chain_is_one_controller_and_a_row_for_each_repetition(chain_of):
    """Reset once for each, the number counting up: this is what carry_over is asked for."""
    rows, (controller,) = chain_of()
    assert [row.repetition for row in rows] == [task.repetition for task in controller.tasks] == [0, 1, 2]
    assert {row.status for row in rows} == {"ok"}


def test_what_was_learnt_stays(chain_of):
    """The second repetition starts where the first ended: its error has less to lose."""
    rows, _ = chain_of(settings={"rate": 0.1}, schedule=LoadSchedule.constant(HEAVY), tier="actuated")
    first, second, third = errors(rows)
    assert first > 1.2 * second > 1.2 * third


def test_each_repetition_meets_the_draws_that_a_fresh_run_would_meet(chain_of, run_of):
    """Without learning the protocols give the same bits: their difference is what was learnt, and nothing else."""
    rows, (controller,) = chain_of(tier="actuated")
    seeds = [task.seed for task in controller.tasks]
    for repetition, row in enumerate(rows):
        alone = Learner()
        specification = run_of(tier="actuated", repetition=repetition)
        (fresh,) = execute(
            specification, evaluate=error_of, traces="none", plug_ins={"mine": lambda alone=alone: alone}
        )
        assert fresh.metrics == row.metrics
        assert alone.tasks[0].seed == seeds[repetition]
    assert len(set(seeds)) == 3


def test_a_repetition_that_fails_ends_its_chain(chain_of):
    """What would come after it has not learnt what it should have: it is a row that says so, not a result."""

    class Breaks(Learner):
        def compute(self, observation, target):
            return super().compute(observation, target) if len(self.tasks) < 2 else np.full(7, np.nan)

    rows, (controller,) = chain_of(Breaks, repetitions=4)
    assert [row.status for row in rows] == ["ok", "failed", "failed", "failed"]
    assert [row.cause for row in rows] == ["", "nan torque", "carried", "carried"]
    assert all(row.reason.startswith("the chain ended with repetition 1: torque of joint 1") for row in rows[2:])
    assert len(controller.tasks) == 2


def test_a_refusal_refuses_the_whole_chain(chain_of):
    """A controller that cannot do the first repetition was not asked for the others, and has not failed."""

    class Refuses(Learner):
        def supports(self, task):
            return "needs eight joints"

    rows, _ = chain_of(Refuses)
    assert [row.status for row in rows] == ["refused"] * 3


def test_a_controller_that_cannot_be_built_fails_in_every_repetition(chain_of):
    """Every row that was asked for is there."""
    rows, _ = chain_of(settings={"rat": 1.0})
    assert [(row.repetition, row.status) for row in rows] == [(0, "failed"), (1, "failed"), (2, "failed")]


def test_the_last_row_keeps_what_was_learnt(chain_of, run_of):
    """Weights after the chain, once: other rows have no snapshot, nor has a fresh run."""
    rows, (controller,) = chain_of(settings={"rate": 0.5}, traces="plot", schedule=LoadSchedule.constant(HEAVY))
    kept = [decode_trace(row.trace).get("snapshot/mass") for row in rows]
    assert kept[:2] == [None, None]
    assert np.array_equal(kept[2], controller.mass)
    (fresh,) = execute(run_of(), evaluate=error_of, plug_ins={"mine": Learner})
    assert "snapshot/mass" not in decode_trace(fresh.trace)


@pytest.mark.parametrize("learnt", [{"mass": object()}, {"mass": ["a"]}, 3])
def test_a_snapshot_that_cannot_be_kept_fails_its_row(chain_of, learnt):
    """Found in the run, not when the campaign writes its rows."""

    class Odd(Learner):
        def snapshot(self):
            return learnt

    rows, _ = chain_of(Odd, repetitions=2, traces="plot")
    assert [row.status for row in rows] == ["ok", "failed"]
    assert rows[1].reason.startswith("in snapshot: ")


def test_a_chain_is_stored_and_read_back_row_by_row(chain_of, run_of, tmp_path):
    """One address, as many rows as repetitions; the repetition of a row is the one that a report has to show."""
    rows, _ = chain_of(traces="plot")
    chain, fresh = run_of(protocol="carried", repetitions=3), run_of(repetition=5)
    with Store.write(tmp_path / "out") as store:
        store.put("aa", chain, rows)
        store.put("bb", fresh, rows[:1])
        stored = store.runs()
    assert [row.repetition for row in stored] == [0, 1, 2, 5]
    assert [row.result.metrics for row in stored[:3]] == [row.metrics for row in rows]


def test_a_chain_has_its_own_address(run_of):
    """Its rows are other results than those of fresh runs, and a longer chain is another chain."""
    addresses = [
        run_of().address("code"),
        run_of(protocol="carried").address("code"),
        run_of(protocol="carried", repetitions=2).address("code"),
    ]
    assert len(set(addresses)) == 3
    chain = run_of(protocol="carried", repetitions=2)
    assert RunSpecification.from_json(chain.as_json()) == chain
    assert [link.as_json() for link in chain.links()] == [run_of(repetition=r).as_json() for r in (0, 1)]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"protocol": "kept"}, "run: protocol = 'kept'; one of fresh, carried"),
        ({"repetitions": 2}, "run: repetitions = 2 in one run; only in protocol 'carried'"),
        ({"protocol": "carried", "repetitions": 0}, "run: repetitions = 0; at least 1"),
        ({"protocol": "carried", "repetition": 1}, "run: repetition = 1; a chain of protocol 'carried' starts at 0"),
        ({"protocol": "carried", "twins": True}, "run: twins in protocol 'carried'; judge events in protocol 'fresh'"),
    ],
)
def test_a_chain_that_makes_no_sense_is_refused(run_of, changes, says):
    """A twin of a chain would have learnt something else than the run: their difference means nothing."""
    with pytest.raises(InvalidInput) as caught:
        run_of(**changes)
    assert str(caught.value) == says
