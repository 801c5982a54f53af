"""``torquebench.run``: from a few words to a store and its page, and what is said of it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from torquebench import running
from torquebench.controllers import Controller, InvalidInput, UnknownName
from torquebench.running import run
from torquebench.scenarios.store import DATABASE, Store

BENCHMARK = """
schema = 1
name = "small"
title = "One motion"
plant = "pinocchio"
tier = "ideal"
controllers = ["FILE:Law"]
knowledge = ["none"]
trajectories = ["T6"]
loads = [{ mass = 1.5 }, { mass = 2.5, material = "sand" }]
laps = 1
lead_in = 0.1
"""
LAWS = """
import numpy as np

class Law:
    def __init__(self, *, gain=400.0): self.gain = gain
    def reset(self, task): self.robot = task.robot
    def compute(self, o, t):
        error = self.gain * (t.q - o.q) + 40.0 * (t.dq - o.dq)
        return self.robot.inverse_dynamics(o.q, o.dq, t.ddq + error)

class Heavy(Law):
    def compute(self, o, t):
        return super().compute(o, t) if o.wrench[2] < 20.0 else np.full(7, np.nan)

class Picky(Law):
    def supports(self, task): return "never in the mood"
"""


class Mine(Controller):
    """An author's own class, never registered anywhere."""

    def reset(self, task):
        self.robot = task.robot

    def compute(self, observation, target):
        return self.robot.gravity(observation.q)


@pytest.fixture
def laws(tmp_path):
    """A file with three laws."""
    file = tmp_path / "laws.py"
    file.write_text(LAWS)
    return str(file)


@pytest.fixture
def benchmark(tmp_path, laws):
    """A benchmark of two short runs."""
    file = tmp_path / "small.toml"
    file.write_text(BENCHMARK.replace("FILE", laws))
    return str(file)


@pytest.fixture
def unrun(monkeypatch):
    """Lets no run begin, and keeps the campaigns that would have."""
    campaigns = []

    def never(campaign, store, **options):
        campaigns.append((campaign, options))
        return iter(())

    monkeypatch.setattr(running, "run_campaign", never)
    return campaigns


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A store in which one of two runs was done, and the benchmark of both beside it."""
    folder = tmp_path_factory.mktemp("stored")
    (folder / "laws.py").write_text(LAWS)
    (folder / "small.toml").write_text(BENCHMARK.replace("FILE", str(folder / "laws.py")))
    heavy = "loads=[{mass=2.5,material='sand'}]"
    done = run(str(folder / "small.toml"), out=folder / "out", changes=[heavy], workers=1)
    assert (done.total, done.failed) == (1, 0)
    return folder / "out"


def test_a_first_call_and_the_second_say_what_they_did(benchmark, laws, tmp_path):
    """Two loads, of which one breaks the law: a failure now is a failure still when nothing is left to do."""
    heavy = f"{laws}:Heavy"
    seen = []
    first = run(benchmark, out=tmp_path / "out", controllers=[heavy], workers=1, watch=lambda *told: seen.append(told))
    assert (first.total, first.done, first.failed, first.refused) == (2, 2, 1, 0)
    assert first.page == tmp_path / "out" / "report" / "index.html"
    assert first.page.is_file()
    assert [finished.failed for _, finished in seen[1:]] == [False, True]
    assert seen[0][1] is None and len({id(campaign) for campaign, _ in seen}) == 1
    assert first.simulated == pytest.approx(sum(finished.simulated for _, finished in seen[1:]))
    again = run(benchmark, out=tmp_path / "out", controllers=[heavy], workers=1)
    assert (again.total, again.done, again.failed, again.simulated) == (2, 0, 1, 0.0)
    planned = run(benchmark, out=tmp_path / "out", controllers=[heavy], retry_failed=True, dry_run=True)
    assert (planned.total, planned.done, planned.failed) == (2, 0, 1)
    assert planned.simulated == pytest.approx(first.simulated / 2.0)
    assert planned.page is None


def test_a_refused_run_is_counted_apart_from_failures(benchmark, laws, tmp_path):
    """The status of a command line is that of failures; a refusal is an answer."""
    done = run(benchmark, out=tmp_path / "out", controllers=[f"{laws}:Picky"], workers=1)
    assert (done.total, done.done, done.failed, done.refused) == (2, 2, 0, 2)


def test_a_dry_run_of_no_store_predicts_and_leaves_nothing(benchmark, tmp_path):
    """Simulated time is laps and lead-in of both runs; two workers need half the wall time of one."""
    from torquebench.scenarios.campaign import UNMEASURED_SPEED

    one, two = (run(benchmark, out=tmp_path / "out", dry_run=True, workers=workers) for workers in (1, 2))
    assert one.simulated == two.simulated == pytest.approx(2 * (0.1 + 2.0))
    assert one.predicted == pytest.approx(one.simulated / UNMEASURED_SPEED)
    assert two.predicted == pytest.approx(one.predicted / 2.0)
    assert (one.done, one.page) == (0, None)
    assert not (tmp_path / "out").exists()


def test_a_dry_run_counts_what_is_there_already(stored):
    """Only what is missing costs time."""
    planned = run(str(stored.parent / "small.toml"), out=stored, dry_run=True)
    assert (planned.total, planned.done) == (2, 0)
    assert planned.simulated == pytest.approx(0.1 + 2.0)


def test_wrong_input_makes_no_folder(benchmark, tmp_path):
    """A typo must not leave an empty store that the next command takes for a finished one."""
    for wrong in ({"controllers": ["nobody"]}, {"tier": "ideel"}, {"changes": ["laps=0"]}, {"traces": "some"}):
        with pytest.raises((InvalidInput, UnknownName)):
            run(benchmark, out=tmp_path / "out", **wrong)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("traces", ["", "all", "Plot"])
def test_traces_are_of_a_kind(benchmark, traces):
    """One of three words, said in the error."""
    with pytest.raises(InvalidInput, match="one of plot, full, none"):
        run(benchmark, traces=traces, dry_run=True)


def test_arguments_stand_in_for_the_file(benchmark, tmp_path, unrun):
    """What an author says at the call wins over the benchmark, and empty words say nothing."""
    run(
        benchmark,
        out=tmp_path / "out",
        tier="actuated",
        latency=0,
        robot="",
        plant="",
        changes=["seed=5"],
        traces="none",
    )
    ((campaign, options),) = unrun
    assert {(item.tier, item.latency, item.robot, item.plant, item.campaign) for item in campaign.runs} == {
        ("actuated", 0, "rizon4s", "pinocchio", 5)
    }
    assert options["traces"] == "none"


def test_latency_none_leaves_the_benchmarks_own(benchmark, tmp_path, unrun):
    """0 ticks is a choice, None is none."""
    for latency, expected in ((None, 3), (0, 0), (1, 1)):
        run(
            benchmark,
            out=tmp_path / f"out{latency}",
            latency=latency,
            changes=[] if latency is not None else ["latency=3"],
        )
        campaign, _ = unrun[-1]
        assert {item.latency for item in campaign.runs} == {expected}


def test_shards_are_apart_and_together_all(benchmark, tmp_path, unrun):
    """Every run has one home, whatever the number of machines."""
    for part in (1, 2, 3):
        run(benchmark, out=tmp_path / f"out{part}", shard=(part, 3), changes=["repetitions=4"])
    parts = [{item.address("") for item in campaign.runs} for campaign, _ in unrun]
    assert [len(part) for part in parts] == [3, 3, 2]
    assert len(set.union(*parts)) == 8


def test_zero_workers_are_one_for_each_core_that_may_be_used(benchmark, tmp_path, unrun, monkeypatch):
    """A queue may give three cores of sixty-four."""
    monkeypatch.setattr(running.os, "sched_getaffinity", lambda _: {4, 5, 6})
    run(benchmark, out=tmp_path / "out")
    run(benchmark, out=tmp_path / "out", workers=2)
    assert [options["workers"] for _, options in unrun] == [3, 2]


def test_an_object_from_code_runs_under_the_name_of_its_class(benchmark, tmp_path, unrun):
    """Classes and instances, in one list with names."""
    names = ("flexiv_factory", Mine)
    run(benchmark, out=tmp_path / "out", controllers=names, changes=['knowledge=["none"]'])
    campaign, _ = unrun[0]
    assert {item.controller for item in campaign.runs} == {"flexiv_factory", "Mine"}
    assert campaign.plug_ins == {"Mine": Mine}
    instance = Mine()
    run(benchmark, out=tmp_path / "out", controllers=[instance])
    assert unrun[1][0].plug_ins == {"Mine": instance}


def test_two_objects_of_one_name_are_refused(benchmark):
    """Their rows would stand under one label, and one of them would be run twice."""
    other = type("Mine", (Mine,), {})
    with pytest.raises(InvalidInput, match="two controllers are called 'Mine'"):
        run(benchmark, controllers=[Mine, other], dry_run=True)
    assert run(benchmark, controllers=[Mine, Mine], dry_run=True).total == 2


def test_notes_of_the_expansion_reach_the_caller(benchmark, tmp_path, unrun):
    """A reference that does not run is replaced, never in silence."""
    done = run(benchmark, out=tmp_path / "out", changes=["reference=cbmc_v3 / none"])
    assert any("'cbmc_v3 / none' is not among the controllers" in note for note in done.notes)


def test_a_report_is_frozen_and_says_where_it_is(benchmark, tmp_path):
    """It is what a program gets: plain values, no open file."""
    done = run(benchmark, out=str(tmp_path / "out"), dry_run=True)
    assert done.folder == tmp_path / "out"
    with pytest.raises(AttributeError):
        done.total = 3
    assert json.dumps(replace(done, folder=str(done.folder)).__dict__)


def test_runs_are_done_at_full_rate_and_scored_by_the_metrics(stored):
    """The rows hold every metric of a log, and the errors of each lap."""
    from torquebench.evaluation.metrics import METRICS

    assert (stored / DATABASE).is_file()
    with Store.read(stored) as store:
        (row,) = store.runs()
    computed = row.result.metrics["run"]
    assert {name for name, metric in METRICS.items() if metric.kind == "log"} >= set(computed)
    assert computed["tcp_position_error_mean"]["status"] == "ok"
    assert row.result.laps["tcp_position_error_mean"] == [pytest.approx(computed["tcp_position_error_mean"]["value"])]
    assert np.isfinite(row.result.laps["tcp_orientation_error_mean"]).all()
