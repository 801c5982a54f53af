"""The whole path once: from runs that were really made to verdicts on the paper's claims."""

import csv
import json

import numpy as np
import pytest
from torquebench.evaluation.report import write_report
from torquebench.running import run

BENCHMARK = """
schema = 1
name = "claims"
reference = "flexiv_factory / none"
plant = "pinocchio"
knowledge = ["none"]
trajectories = ["T6"]
loads = [{ mass = 2.5, material = "sand" }]

[[run]]
controllers = ["cbmc_v3", "flexiv_factory"]
laps = 3

[[run]]
controllers = ["cbmc_v3"]
laps = 10
"""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The report of two real runs that belong to the paper's grid, and of one whose calls are timed."""
    folder = tmp_path_factory.mktemp("claims")
    (folder / "claims.toml").write_text(BENCHMARK)
    run(str(folder / "claims.toml"), out=folder / "store", workers=1)
    return write_report(folder / "store")


def test_two_real_runs_are_measured_and_not_enough(report):
    """One path is measured, and the reader is told that it decides nothing about others."""
    claims = {claim["id"]: claim for claim in json.loads(report.summary.read_text(encoding="utf-8"))["claims"]}
    assert len(claims) == 55
    rows = [row for row in csv.DictReader(report.runs.open(encoding="utf-8")) if row["laps"] == "3"]
    logs = [
        np.log([float(row["run.tcp_position_error_mean [m]"]) for row in rows if row["controller"] == name])
        for name in ("cbmc_v3", "flexiv_factory")
    ]
    found = claims["C3"]
    assert found["measured"] == pytest.approx(np.exp(np.mean(logs[0] - logs[1])))
    assert (found["n"], found["reason"]) == (1, "trajectories: 1; no test of fewer than six can reach 5 %")
    assert found["verdict"] == "not enough to decide, against our approximation of the factory controller"
    assert claims["C1"]["reason"].startswith("missing: T1, T2")
    assert 0.0 < claims["C49"]["measured"] < 1.0
    assert claims["C49"]["n"] == 1
    assert claims["C7"]["measured"] == pytest.approx(float(np.mean(np.exp(logs[1]))))
