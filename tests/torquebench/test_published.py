"""Five numbers of the published result, run again with full traces and recomputed by other means."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from torquebench.scenarios.execution import execute
from torquebench.scenarios.result import Scores
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.trace import decode_trace

FIVE = json.loads((Path(__file__).parents[2] / "docs/results/five_runs.json").read_text())


def recomputed(trace):
    """Return the published metrics from the arrays of every tick, without the metric library."""
    scored = trace["t"] > -1e-6
    part = {name: array[scored] for name, array in trace.items() if len(array) == len(scored)}
    turns = Rotation.from_quat(part["quat"]).inv() * Rotation.from_quat(part["quat_ref"])
    change = np.linalg.norm(part["tau"][1:] - part["tau"][:-1], axis=1) / 1e-3
    return {
        "tcp_position_error_mean": np.sqrt(((part["p"] - part["p_ref"]) ** 2).sum(axis=1)).mean(),
        "tcp_orientation_error_mean": turns.magnitude().mean(),
        "joint_error_mean": np.sqrt(((part["q"] - part["q_ref"]) ** 2).sum(axis=1)).mean(),
        "torque_rate_rms": np.sqrt((change**2).mean()),
    }


@pytest.mark.skipif(importlib.util.find_spec("pybullet") is None, reason="published on PyBullet")
@pytest.mark.parametrize("row", FIVE, ids=lambda row: row["specification"]["controller"])
def test_a_published_number_comes_out_again(row):
    """To 1e-9: whoever doubts a figure of the result can have it again."""
    specification = RunSpecification.from_json(json.dumps(row["specification"]))
    (result,) = execute(specification, evaluate=lambda _: Scores(metrics={}), traces="full")
    found = recomputed(decode_trace(result.trace))
    for name, published in row["published"].items():
        assert found[name] == pytest.approx(published, rel=1e-9, abs=1e-9), name
