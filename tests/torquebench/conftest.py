"""Small stores of real runs, made in this process: what the commands that read a store are tried on."""

from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner
from torquebench import cli
from torquebench.judging import JUDGES
from torquebench.scenarios.digest import run_digest
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.store import Store
from torquebench.scoring import score, score_events

EMPTY, FULL = Payload(mass=1.5), Payload(mass=2.5, material="sand")
LAWS = """
import numpy as np

class Late:
    def reset(self, task): self.robot, self.seen = task.robot, 0
    def compute(self, o, t):
        self.seen += 1
        if self.seen > 100: raise RuntimeError("too late")
        return self.robot.gravity(o.q)

class Scalar:
    def reset(self, task): pass
    def compute(self, o, t): return 0.0
"""


def run_of(controller="flexiv_factory", trajectory="T6", load=EMPTY, **changes):
    """Return a run of two seconds on exact drives."""
    plain = {"robot": "rizon4s", "plant": "pinocchio", "tier": "ideal", "laps": 1, "lead_in": 0.1}
    schedule = changes.pop("schedule", LoadSchedule.constant(load))
    return RunSpecification(controller=controller, trajectory=trajectory, schedule=schedule, **{**plain, **changes})


def fill(folder, *specifications, traces="plot", reference="flexiv_factory / none", **record):
    """Run specifications into a store, and return their addresses."""
    addresses = []
    with Store.write(folder) as store:
        for run in specifications:
            addresses.append(run.address(run_digest(run)))
            results = execute(run, evaluate=score, evaluate_events=score_events, judges=JUDGES, traces=traces)
            store.put(addresses[-1], run, results)
        benchmark = {"name": "small", "title": "Small", "reference": reference}
        store.put_campaign("2026-05-04T10:00:00+00:00", {"benchmark": benchmark, **record})
    return addresses


@dataclass(frozen=True)
class Kept:
    """A store and the addresses of its runs, by controller, trajectory and mass."""

    folder: Path
    addresses: dict


@pytest.fixture(scope="session")
def kept(tmp_path_factory):
    """Two controllers on two motions with two loads, noisy sensors for the spiking one."""
    folder = tmp_path_factory.mktemp("kept") / "store"
    runs = [
        run_of(controller, trajectory, load, tier="actuated")
        for controller in ("flexiv_factory", "cbmc_v3")
        for trajectory in ("T6", "T7")
        for load in (EMPTY, FULL)
    ]
    addresses = fill(folder, *runs)
    keys = [(run.controller, run.trajectory, run.schedule.entries[0][1].mass) for run in runs]
    return Kept(folder, dict(zip(keys, addresses, strict=True)))


@pytest.fixture(scope="session")
def laws(tmp_path_factory):
    """A file with a law that gives up and one that answers nonsense."""
    file = tmp_path_factory.mktemp("laws") / "laws.py"
    file.write_text(LAWS)
    return file


@pytest.fixture
def line():
    """Calls the command line within this process; what a user can cause is the exception's one line."""

    def invoke(*arguments):
        return CliRunner().invoke(cli.group, [str(argument) for argument in arguments], standalone_mode=False)

    return invoke
