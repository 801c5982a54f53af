"""A campaign runs what is missing, writes each run whole, and gives the same numbers however it is cut."""

import pytest
from torquebench.controllers import InvalidInput
from torquebench.judging import JUDGES
from torquebench.scenarios import campaign as campaigns
from torquebench.scenarios import gate
from torquebench.scenarios.benchmark import load_benchmark
from torquebench.scenarios.campaign import parse_shard, plan_campaign, predicted_time, run_campaign
from torquebench.scenarios.gate import GateFailure
from torquebench.scenarios.store import Store
from torquebench.scoring import score

BENCHMARK = """
schema = 1
name = "tiny"
plant = "pinocchio"
controllers = ["PLUG:Gravity"]
knowledge = ["none"]
trajectories = ["T6", "S1"]
loads = [{ mass = 1.5 }, { mass = 3.5, material = "sand" }]
laps = 1
lead_in = 0.2
"""
PLUG = """
import os, signal, time
import numpy as np

class Gravity:
    def reset(self, task):
        self.robot = task.robot
    def compute(self, observation, target):
        error = 400.0 * (target.q - observation.q) + 40.0 * (target.dq - observation.dq)
        return self.robot.inverse_dynamics(observation.q, observation.dq, target.ddq + error)

class Dying(Gravity):
    def compute(self, observation, target):
        os.kill(os.getpid(), signal.SIGKILL)

class Raising(Gravity):
    def compute(self, observation, target):
        raise RuntimeError("no idea")

class Learning(Gravity):
    carry_over = True
    def reset(self, task):
        super().reset(task)
        self.first = task.repetition == 0

class LateDeath(Learning):
    def compute(self, observation, target):
        if not self.first:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().compute(observation, target)

class Blank(Gravity):
    def compute(self, observation, target):
        return np.full(7, np.nan)
"""


@pytest.fixture
def benchmark_of(tmp_path):
    """Builds the small benchmark for some of the plug-in's controllers."""

    def build(*controllers, **overrides):
        plug = tmp_path / "plug.py"
        plug.write_text(PLUG)
        file = tmp_path / "tiny.toml"
        file.write_text(BENCHMARK)
        doors = [f"{plug}:{name}" for name in controllers or ("Gravity",)]
        return load_benchmark(str(file), overrides={"controllers": doors, **overrides})

    return build


def run(benchmark, folder, *, workers=1, judges=None, **options):
    """Run what is missing and return how many runs that were."""
    with Store.write(folder) as store:
        campaign = plan_campaign(benchmark, store.statuses(), **options)
        return len(list(run_campaign(campaign, store, evaluate=score, judges=judges, workers=workers)))


def metrics(folder):
    """Return address to the metrics of every run."""
    with Store.read(folder) as store:
        return {run.address: (run.result.status, run.result.metrics, run.result.laps) for run in store.runs()}


def test_a_measured_latency_belongs_to_its_machine(benchmark_of, tmp_path, monkeypatch):
    """In address and row: stores of two machines that are merged keep both results; other runs do not care."""
    measured, plain = benchmark_of(latency="measured", trajectories=["S1"]), benchmark_of(trajectories=["S1"])
    run(measured, tmp_path / "store")
    with Store.read(tmp_path / "store") as store:
        assert {row.machine for row in store.runs()} == {campaigns.machine_label()}
    here = [plan_campaign(benchmark, {}).addresses for benchmark in (measured, plain)]
    monkeypatch.setattr(campaigns, "machine_label", lambda: "another, 64 cores")
    there = [plan_campaign(benchmark, {}).addresses for benchmark in (measured, plain)]
    assert not set(here[0]) & set(there[0])
    assert here[1] == there[1]


def test_running_again_does_nothing_and_two_workers_or_two_shards_give_the_same_bits(benchmark_of, tmp_path):
    """The number of processes is no part of a result, and a finished run is never repeated."""
    benchmark = benchmark_of()
    assert run(benchmark, tmp_path / "one") == 4
    assert run(benchmark, tmp_path / "one") == 0
    assert run(benchmark, tmp_path / "two", workers=2) == 4
    assert [run(benchmark, tmp_path / f"shard{part}", shard=(part, 2)) for part in (1, 2)] == [2, 2]
    with Store.write(tmp_path / "merged") as merged:
        for part in (1, 2):
            with Store.read(tmp_path / f"shard{part}") as shard:
                assert merged.merge(shard) == 2
                assert merged.merge(shard) == 0
    assert metrics(tmp_path / "one") == metrics(tmp_path / "two") == metrics(tmp_path / "merged")


@pytest.mark.parametrize(
    ("controller", "cause", "says"),
    [("Dying", "crash", "SIGKILL"), ("Raising", "exception", "no idea"), ("Blank", "nan torque", "joint 1")],
)
def test_a_failing_controller_costs_only_its_own_runs(benchmark_of, tmp_path, controller, cause, says):
    """A failure is a row with its reason; the others' runs are there, and it is tried again only on request."""
    benchmark = benchmark_of(controller, "Gravity", trajectories=["T6"], loads=[{"mass": 1.5}])
    assert run(benchmark, tmp_path / "runs") == 2
    with Store.read(tmp_path / "runs") as store:
        results = {run.specification.label.split(" ")[0]: run.result for run in store.runs()}
    assert results["Gravity"].status == "ok"
    assert (results[controller].status, results[controller].cause) == ("failed", cause)
    assert says in results[controller].reason
    assert run(benchmark, tmp_path / "runs") == 0
    assert run(benchmark, tmp_path / "runs", retry_failed=True) == 1


def test_a_run_with_twins_is_one_transaction_with_a_row_for_each_history(benchmark_of, tmp_path):
    """A shard or a kill must never leave an event without the histories it is judged against."""
    schedule = [{"at": 0.0, "mass": 1.5}, {"at": 1.0, "mass": 3.5, "material": "sand"}, {"at": 2.0, "mass": 1.5}]
    benchmark = benchmark_of(schedule=schedule, twins=True, trajectories=["S1"])
    assert run(benchmark, tmp_path / "runs") == 1
    with Store.read(tmp_path / "runs") as store:
        roles = {stored.result.role for stored in store.runs()}
        assert {stored.result.status for stored in store.runs()} == {"ok"}
    assert roles == {"run", "constant 1.5 kg", "constant 3.5 kg sand", "3.5 kg sand stays"}


def test_a_chain_is_one_transaction_with_a_row_for_each_repetition(benchmark_of, tmp_path):
    """Whole or not at all: when its process dies, every repetition that was asked for is a failed row."""
    options = {"protocol": "carried", "repetitions": 3, "trajectories": ["T6"], "loads": [{"mass": 1.5}]}
    benchmark = benchmark_of("Learning", "LateDeath", **options)
    campaign = plan_campaign(benchmark, {})
    assert predicted_time(campaign, None, workers=1)[0] == pytest.approx(2 * 3 * 2.2)
    assert run(benchmark, tmp_path / "runs", workers=2) == 2
    with Store.read(tmp_path / "runs") as store:
        rows = {(row.specification.label[:8], row.repetition): row.result for row in store.runs()}
    assert set(rows) == {(name, repetition) for name in ("Learning", "LateDeat") for repetition in range(3)}
    assert {rows["Learning", repetition].status for repetition in range(3)} == {"ok"}
    assert {rows["LateDeat", repetition].cause for repetition in range(3)} == {"crash"}
    assert run(benchmark, tmp_path / "runs") == 0


def test_a_study_is_one_transaction_with_one_row(benchmark_of, tmp_path):
    """Whatever runs it took: a margin in its unit, its probes in the provenance, and nothing to do the second time."""
    benchmark = benchmark_of(trajectories=["T6"], loads=[{"mass": 1.5}], studies=["init_offset_margin"])
    assert run(benchmark, tmp_path / "runs", judges=JUDGES) == 1
    assert run(benchmark, tmp_path / "runs", judges=JUDGES) == 0
    with Store.read(tmp_path / "runs") as store:
        (row,) = store.runs()
    entry = row.result.metrics["margin"]["init_offset_margin"]
    assert (row.result.role, row.result.status, entry["unit"]) == ("run", "ok", "rad")
    assert entry["value"] > 0.1
    assert entry["n"] == len(row.result.provenance["probes"]) > 5


def test_a_plant_that_fails_its_gate_runs_nothing(benchmark_of, tmp_path, monkeypatch):
    """A wrong plant makes every figure wrong: better none than those."""
    broken = ("always wrong", lambda *_: 1.0, 1e-12)
    monkeypatch.setattr(gate, "CHECKS", (*gate.CHECKS, broken))
    with pytest.raises(GateFailure, match="always wrong"):
        run(benchmark_of(), tmp_path / "runs")
    assert metrics(tmp_path / "runs") == {}


def test_provenance_says_what_ran_where_and_that_the_plant_passed(benchmark_of, tmp_path):
    """Every figure leads to its runs, and the runs to code, machine and gate."""
    run(benchmark_of(trajectories=["T6"]), tmp_path / "runs")
    with Store.read(tmp_path / "runs") as store:
        (record,) = store.campaigns()
        (first, *_) = store.runs()
        trace = store.trace(first.trace)
    assert record["benchmark"]["reference"] == "Gravity / none"
    assert record["versions"]["pin"] and record["machine"]["python"]
    assert record["gate"] and all(check["passed"] for check in record["gate"])
    assert first.result.timing["machine"] and first.result.timing["simulated_s"] == pytest.approx(2.2)
    assert trace["q"].shape == (220, 7)


def test_a_changed_plug_in_is_another_run(benchmark_of, tmp_path):
    """Resuming must never mix results of two versions of a controller."""
    benchmark = benchmark_of(trajectories=["T6"], loads=[{"mass": 1.5}])
    before = plan_campaign(benchmark, {}).addresses
    plug = tmp_path / "plug.py"
    plug.write_text(plug.read_text().replace("400.0", "300.0"))
    assert plan_campaign(benchmark, {}).addresses != before


def test_a_dry_run_predicts_from_the_speed_that_was_measured(benchmark_of, tmp_path):
    """The prediction is for this machine and these controllers, not a constant."""
    run(benchmark_of(trajectories=["T6"]), tmp_path / "runs")
    with Store.read(tmp_path / "runs") as store:
        campaign = plan_campaign(benchmark_of(trajectories=["S1"]), store.statuses())
        simulated, wall = predicted_time(campaign, store, workers=1)
        totals = [run.result.timing for run in store.runs()]
    speed = sum(timing["simulated_s"] for timing in totals) / sum(timing["total_s"] for timing in totals)
    assert simulated == pytest.approx(2 * 3.2)
    assert wall == pytest.approx(simulated / speed)


@pytest.mark.parametrize("text", ["0/2", "3/2", "2", "a/b", "1/0", "-1/2"])
def test_a_shard_that_does_not_exist_is_refused(text):
    """Shard 0 of 2 would silently run the wrong half."""
    with pytest.raises(InvalidInput, match="i/n"):
        parse_shard(text)
