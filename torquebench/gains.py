"""The mean gains that CBMC-V3's null controls are given: measured on its own runs, tier by tier."""

import json
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from .controllers import InvalidInput
from .running import run
from .scenarios.benchmark import load_benchmark
from .scenarios.robots import load_robot
from .scenarios.store import Store
from .scenarios.tiers import build_tier

BENCHMARK, CONTROLLER, SECOND_LEVEL = "paper-precision", "cbmc_v3", 10
LOADS = 'loads=[{mass=1.5},{mass=2.5,material="sand"},{mass=3.5,material="sand"}]'


def measure_mean_gains(tier: str) -> dict[str, list[float]]:
    """Return the time means of K_P and K_V over the run window of T1 to T8 at 1.5, 2.5 and 3.5 kg.

    Args:
        tier: Name of the tier.

    Returns:
        ``stiffness`` [N m/rad] and ``damping`` [N m s/rad], one number for each joint.
    """
    with TemporaryDirectory() as folder:
        run(BENCHMARK, out=folder, controllers=[CONTROLLER], tier=tier, changes=[LOADS])
        with Store.read(Path(folder)) as store:
            finished = [row for row in store.runs() if row.result.status == "ok"]
            traces = [(row.specification.lead_in, store.trace(row.trace)) for row in finished]
    means: dict[str, list[float]] = {}
    for name in ("stiffness", "damping"):
        # Rows are SECOND_LEVEL ms apart; what lies before time 0 is lead-in.
        rows = [trace[f"diagnostics/{name}"][round(lead_in * 1e3 / SECOND_LEVEL) :] for lead_in, trace in traces]
        means[name] = [round(float(gain), 2) for gain in np.mean([part.mean(axis=0) for part in rows], axis=0)]
    return means


def write_mean_gains(file: Path, tiers: Sequence[str]) -> None:
    """Measure and write the file of mean gains.

    Args:
        file: The JSON file.
        tiers: Names of the tiers.

    Raises:
        UnknownName: If one of them is no tier.
        InvalidInput: If none is named, or the file's folder does not exist; nothing runs then.
    """
    # Every slip is found before hours of runs, not after those of the first tier.
    if not tiers:
        raise InvalidInput("no tier", "--tier", "give names between commas: ideal,actuated")
    if not file.parent.is_dir():
        raise InvalidInput(f"{str(file.parent)!r} is no folder", "--out", "name a file in a folder that exists")
    robot = load_robot(load_benchmark(BENCHMARK).robot)
    for tier in tiers:
        build_tier(tier, robot.tiers, robot.rotor_inertia)
    table = {
        "made_by": f"torquebench train gains --tier {','.join(tiers)}",
        "what": "time mean of cbmc_v3's gains over the run window of T1 to T8 at 1.5, 2.5 and 3.5 kg, three laps",
        "tiers": {tier: measure_mean_gains(tier) for tier in tiers},
    }
    file.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
