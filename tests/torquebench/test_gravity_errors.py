"""What a run's patterns know of gravity: the training's own figures, asked again, and nobody else's."""

import json
from importlib.resources import files

import numpy as np
import pytest
from torquebench.cbmc.point_payload import point_payload
from torquebench.cbmc.training import gravity_torques
from torquebench.gravity_errors import gravity_errors_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.robots import load_robot
from torquebench.scenarios.specification import RunSpecification
from torquebench.training import joint_paths, load_centre


def specification(controller, **changes):
    load = LoadSchedule.constant(Payload(mass=1.5))
    world = {"robot": "rizon4s", "plant": "pinocchio", "tier": "ideal"}
    return RunSpecification(controller=controller, trajectory="T1", schedule=load, **world, **changes)


def test_the_error_is_the_one_that_training_wrote_down():
    """Root mean square over joints and postures of the shipped notes, by that of gravity: another way to one figure."""
    notes = json.loads((files("torquebench.cbmc") / "data" / "patterns" / "rizon4s.json").read_text(encoding="utf-8"))
    written = {(row["group"], row["load"]): row["rmse"] for row in notes["evaluation"]["rows"]}
    arm, found = load_robot("rizon4s"), gravity_errors_of(specification("cbmc_v3"))
    paths = joint_paths(arm)
    for motion in ("T1", "T6", "S2"):
        for load in (0.0, 3.0):
            right = gravity_torques(arm.model(), paths[motion][::10], point_payload(load, load_centre(arm)))
            size = float(np.sqrt(np.mean(right**2)))
            assert found[motion][load] == pytest.approx(written[motion, load] / size, rel=2e-3)


def test_an_ablation_has_the_patterns_too_and_others_have_none():
    """The error is a property of the patterns, which an ablation does not retrain."""
    assert gravity_errors_of(specification("no_force")) == gravity_errors_of(specification("cbmc_v3"))
    assert gravity_errors_of(specification("computed_torque")) is None
    assert gravity_errors_of(specification("a plug-in that is gone")) is None


def test_patterns_that_are_gone_cost_their_figures_and_not_the_report(tmp_path):
    """A report is often read where the runs were not made."""
    gone = {"patterns": str(tmp_path / "gone.safetensors")}
    assert gravity_errors_of(specification("cbmc_v3", settings=gone)) is None
