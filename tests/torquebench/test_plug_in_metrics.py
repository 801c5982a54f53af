"""Metrics of other distributions: found by entry point, computed for every run, refused in one line."""

import json
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from torquebench import cli
from torquebench.bounds import check_bounds, read_bounds
from torquebench.controllers import InvalidInput, PlugInFailure, discovery
from torquebench.evaluation import METRICS
from torquebench.plug_in_metrics import all_metrics
from torquebench.scenarios.digest import run_digest
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scoring import score

from .conftest import fill, run_of

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SOURCE = '''
from torquebench.evaluation import metric

@metric(unit="rad", better="lower", family="own", needs=("q",), source="here", label="largest angle")
def angle_max(q):
    """Largest angle."""
    return float(abs(q).max())

no_metric = 3
'''


@pytest.fixture
def register(monkeypatch, tmp_path):
    """Registers metrics of a package that is on the path, and forgets them afterwards."""
    (tmp_path / "own_metrics_package.py").write_text(SOURCE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    registered = discovery.registered

    def register(**values):
        points = {n: EntryPoint(name=n, value=v, group="torquebench.metrics") for n, v in values.items()}
        found = {**registered("metrics"), **points}
        monkeypatch.setattr(discovery, "registered", lambda kind: found if kind == "metrics" else registered(kind))
        all_metrics.cache_clear()

    yield register
    all_metrics.cache_clear()


class Log:
    """A lap of an arm that holds still beside its plan."""

    def __init__(self):
        ticks = 2000
        self.t, self.dt, self.lap = np.arange(ticks) * 1e-3, 1e-3, 2.0
        self.q, self.q_ref = np.full((ticks, 7), -0.3), np.zeros((ticks, 7))
        self.p = self.p_ref = np.zeros((ticks, 3))
        self.quat = self.quat_ref = np.tile([0.0, 0.0, 0.0, 1.0], (ticks, 1))
        self.call_time = np.concatenate([np.full(500, 1.0), np.full(ticks - 500, 2e-5)])


def test_a_registered_metric_is_computed_for_every_run(register):
    """Beside the built-in ones, which keep their order."""
    register(angle_max="own_metrics_package:angle_max")
    assert list(all_metrics()) == [*METRICS, "angle_max"]
    assert score(Log()).metrics["run"]["angle_max"] == {"value": 0.3, "unit": "rad", "status": "ok", "n": 2000}


def test_a_registered_metric_is_computed_for_a_log_of_ones_own(register):
    """`torquebench evaluate` and a campaign know the same metrics."""
    register(angle_max="own_metrics_package:angle_max")
    words = [
        "evaluate",
        str(EXAMPLES / "own_log.csv"),
        "--map",
        str(EXAMPLES / "own_log.toml"),
        "--metrics",
        "angle_max",
    ]
    found = CliRunner().invoke(cli.group, [*words, "--json"], standalone_mode=False)
    assert json.loads(found.output)["windows"]["run"]["angle_max"]["unit"] == "rad"


def test_a_registered_metric_can_be_gated_and_explained(register, tmp_path, line):
    """What every run has a value of, a pipeline may bound and a reader may go down to."""
    register(angle_max="own_metrics_package:angle_max")
    fill(tmp_path / "store", run_of(), run_of("computed_torque"))
    bound = '[[bound]]\nmetric = "angle_max"\ncontroller = "computed_torque"\n'
    (tmp_path / "gate.toml").write_text(f'{bound}at_most = 3.2\n{bound}at_least = 0.9\nagainst = "flexiv_factory"\n')
    own, ratio = check_bounds(read_bounds(tmp_path / "gate.toml"), tmp_path / "store")
    assert (own.unit, own.passed, ratio.passed) == ("rad", True, True)
    words = ["explain", tmp_path / "store", "--controller", "computed_torque", "--metric", "angle_max"]
    assert json.loads(line(*words, "--json").output)["mean"] == pytest.approx(own.value)
    assert "angle_max [mrad]" in line(*words).output


def test_a_metrics_source_is_part_of_what_a_run_depends_on(register):
    """With a new formula under an old id, old rows must not be taken for new ones."""
    load = LoadSchedule.constant(Payload(mass=1.5))
    run = RunSpecification(
        controller="computed_torque", trajectory="T1", schedule=load, robot="rizon4s", plant="pinocchio", tier="ideal"
    )
    before = run_digest(run)
    register(angle_max="own_metrics_package:angle_max")
    assert run_digest(run) != before


@pytest.mark.parametrize(
    ("name", "value", "error", "words"),
    [
        ("no_metric", "own_metrics_package:no_metric", InvalidInput, "a int; decorate it"),
        ("angle", "own_metrics_package:angle_max", InvalidInput, "registered as 'angle'; register it under its id"),
        ("gone", "nowhere_at_all:gone", PlugInFailure, "could not be loaded"),
    ],
)
def test_what_is_registered_and_no_metric_is_named(register, name, value, error, words):
    register(**{name: value})
    with pytest.raises(error, match=words):
        all_metrics()


def test_call_times_stand_with_the_timing_and_lose_their_warm_up():
    """Half a second of slow first calls shows in no figure; no wall time is among the results."""
    scores = score(Log())
    assert scores.timing["tick_time_max"] == pytest.approx(2e-5)
    assert scores.timing["deadline_miss_fraction"] == 0.0
    assert not set(scores.timing) & set(scores.metrics["run"])
