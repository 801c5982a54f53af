import hashlib
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from torquebench.evaluation.metrics import METRICS
from torquebench.evaluation.report import write_report
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.store import Store

REFERENCE = "flexiv_factory / none"
SLOW, FAST = ("T1", "T2", "T3", "T4", "T5"), ("T6", "T7", "T8")
TYPICAL = {
    "tcp_position_error_mean": 1.0,
    "tcp_orientation_error_mean": 1.05,
    "joint_error_mean": 1.7,
    "tcp_position_error_last_lap": 0.9,
    "time_lag": 3.1,
    "contour_error_mean": 0.3,
    "torque_rate_rms": 5.0e4,
    "clip_fraction": 0.0,
    "torque_rate_clip_fraction": 0.02,
}
"""Size of each metric where the mean position error is 1 m."""

SCALES = {
    ("flexiv_factory", "none"): 17.2e-3,
    ("flexiv_full_ff", "none"): 2.6e-3,
    ("computed_torque", "oracle"): 0.46e-3,
    ("computed_torque", "none"): 3.1e-3,
    ("computed_torque_pid", "none"): 0.44e-3,
}
"""Mean position error of a few controllers [m]."""


def ledger(controller: str) -> list[dict[str, object]]:
    return [
        {
            "setting": "bandwidth",
            "value": 20.0,
            "source": "rule",
            "note": "half the bandwidth",
            "trials": 0,
            "learnt_before": "",
        },
        {
            "setting": "integral",
            "value": [1, 2, 3],
            "source": "tuned",
            "note": controller,
            "trials": 40,
            "learnt_before": "T1",
        },
    ]


def metrics_of(size: float, rng: np.random.Generator) -> dict[str, dict[str, dict[str, object]]]:
    values = {}
    for name, metric in METRICS.items():
        if metric.kind != "log":
            continue
        value = TYPICAL.get(name, math.nan) * size * math.exp(rng.normal(0.0, 0.03))
        status = "undefined" if math.isnan(value) else "ok"
        values[name] = {"value": value, "unit": metric.unit, "status": status, "n": 12000}
    return {"run": values, "steady": {name: dict(entry) for name, entry in values.items()}}


def result_of(specification: RunSpecification, size: float, group: str) -> RunResult:
    mass = specification.schedule.entries[0][1].mass
    seed = int(hashlib.sha256(specification.as_json().encode()).hexdigest()[:8], 16)
    rng = np.random.default_rng(seed)
    speed = 1.6 if group == "fast" else 1.0
    wobble = math.exp(rng.normal(0.0, 0.12))
    metrics = metrics_of(size * speed * wobble * (0.7 + 0.2 * mass), rng)
    position = float(metrics["run"]["tcp_position_error_mean"]["value"])
    return RunResult(
        role="run",
        status="ok",
        metrics=metrics,
        laps={
            "tcp_position_error_mean": [position * (1.2, 0.95, 0.85)[lap % 3] for lap in range(specification.laps)],
            "tcp_orientation_error_mean": [position * 1.1] * specification.laps,
        },
        ledger=ledger(specification.controller),
        counts={"ticks": 13000, "clipped_effort": [0] * 7, "clipped_rate": [3] * 7, "operations": {}},
        timing={
            "reset_s": 0.01, "loop_s": 0.9, "total_s": 1.1, "simulated_s": 13.0, "real_time_factor": 14.4,
            "call_us_median": 18.3, "call_us_p99": 31.0, "call_us_max": 240.0, "deadline_misses": 0.0,
        },
        provenance={"plant": specification.plant, "payload": [mass, 0, 0, 0.1], "group": group},
    )  # fmt: skip


def specification_of(
    controller: str,
    knowledge: str,
    trajectory: str = "T1",
    mass: float = 1.5,
    **changes: object,
) -> RunSpecification:
    payload = Payload(mass=mass, material="sand" if mass > 1.5 else "none")
    plain = RunSpecification(
        controller=controller,
        knowledge=knowledge,
        trajectory=trajectory,
        schedule=LoadSchedule.constant(payload),
        robot="rizon4s",
        plant="pybullet",
        tier="actuated",
    )
    return replace(plain, **changes)


def campaign_record(reference: str = REFERENCE, name: str = "quick") -> dict[str, object]:
    return {
        "benchmark": {
            "name": name,
            "title": "Seven joints, eight motions, three loads",
            "reference": reference,
            "description": "Eight closed motions with three loads, three laps each.",
        },
        "command": f"torquebench run {name} --out results",
        "notes": ["PyBullet has no wheel for Python 3.13: the Pinocchio plant took over"],
        "versions": {"torquebench": "0.1.0", "numpy": "2.1.0", "pin": "4.0.0"},
        "commit": "08ee2fa",
        "machine": {"processor": "x86-64", "cores": 8, "python": "3.11.9", "system": "Linux 6.1"},
        "digest": "ab" * 32,
        "gate": [
            {"name": "gravity", "plant": "pybullet", "deviation": 3.1e-13, "allowed": 1e-9, "passed": True},
            {"name": "energy", "plant": "pybullet", "deviation": 2.4e-4, "allowed": 1e-3, "passed": True},
        ],
        "seed": 1,
        "workers": 2,
    }


class Shelf:
    """A store that tests fill run by run."""

    specification = staticmethod(specification_of)
    result = staticmethod(result_of)
    record = staticmethod(campaign_record)

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.store = Store.write(folder)

    def put(self, specification: RunSpecification, *results: RunResult) -> str:
        address = specification.address("digest")
        self.store.put(address, specification, results)
        return address

    def grid(
        self,
        scales: dict[tuple[str, str], float] = SCALES,
        trajectories: tuple[str, ...] = SLOW + FAST,
        masses: tuple[float, ...] = (1.5, 2.5, 3.5),
        **changes: object,
    ) -> "Shelf":
        for (controller, knowledge), size in scales.items():
            for trajectory in trajectories:
                for mass in masses:
                    run = specification_of(controller, knowledge, trajectory, mass, **changes)
                    self.put(run, result_of(run, size, "fast" if trajectory in FAST else "slow"))
        return self

    def fail(self, specification: RunSpecification, status: str = "failed") -> "Shelf":
        words = {
            "failed": ("divergence", "joint 4 is 1.02 rad from its plan"),
            "refused": ("refused", "gain margin 0.4 < 1"),
        }
        cause, reason = words[status]
        failed_at = 2.125 if status == "failed" else None
        self.put(specification, RunResult(role="run", status=status, cause=cause, reason=reason, failed_at=failed_at))
        return self

    def campaign(self, record: dict[str, object] | None = None) -> "Shelf":
        self.store.put_campaign("2026-05-04T10:00:00+00:00", record or campaign_record())
        return self

    def report(self) -> "Page":
        self.store.close()
        files = write_report(self.folder)
        return Page(
            files.index.read_text(encoding="utf-8"), json.loads(files.summary.read_text(encoding="utf-8")), files
        )


class Page:
    """A written report."""

    def __init__(self, html: str, summary: dict[str, object], files: object) -> None:
        self.html, self.summary, self.files = html, summary, files


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    return Shelf(tmp_path / "store")


@pytest.fixture(scope="session")
def quick(tmp_path_factory: pytest.TempPathFactory) -> Page:
    """Five controllers on eight trajectories with three loads; one run failed, one controller was refused twice."""
    shelf = Shelf(tmp_path_factory.mktemp("quick") / "store").grid()
    shelf.fail(specification_of("flexiv_full_ff", "none", "T7", 3.5))
    shelf.fail(specification_of("mpc", "none", "T1", 3.5), status="refused")
    shelf.fail(specification_of("mpc", "none", "T2", 3.5), status="refused")
    return shelf.campaign().report()


@pytest.fixture(scope="session")
def shelf_class() -> type[Shelf]:
    """What fixtures of a wider scope fill."""
    return Shelf


@pytest.fixture(scope="session")
def precise(tmp_path_factory: pytest.TempPathFactory) -> Page:
    """CBMC-V3 and the factory controller on the paper's grid of sand, two repetitions."""
    shelf, scales = Shelf(tmp_path_factory.mktemp("precise") / "store"), {("flexiv_factory", "none"): 17.2e-3}
    for repetition in (0, 1):
        shelf.grid(scales | {("cbmc_v3", "none"): 12.0e-3}, masses=(1.5, 2.0, 2.5, 3.0, 3.5), repetition=repetition)
    return shelf.campaign().report()
