"""What the report learns of robots: the arm if it is there, nothing if it is not."""

import json

from torquebench.reporting import conformance_of, skeleton_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification


def test_a_known_robot_has_a_skeleton_that_json_can_hold():
    """It is embedded in the page."""
    found = skeleton_of("rizon4s", "")
    assert json.loads(json.dumps(found))["tool"] == found["tool"] > 7


def test_a_robot_that_is_gone_costs_the_replay_and_not_the_report():
    """Stores travel without the URDF of their arm."""
    assert skeleton_of("gone/arm.urdf", "") is None
    assert skeleton_of("nobody", "") is None
    assert skeleton_of("rizon4s", "no such tool") is None


def test_a_controller_is_checked_as_it_was_run_and_one_that_is_gone_is_not():
    """Settings are part of a controller; a file that is no longer there costs its row and not the report."""
    load = LoadSchedule.constant(Payload(mass=1.5))
    world = {"trajectory": "T1", "schedule": load, "robot": "rizon4s", "plant": "pinocchio", "tier": "ideal"}
    found = conformance_of(RunSpecification(controller="computed_torque", settings={"bandwidth": 12.0}, **world))
    assert found and all(finding.passed for finding in found)
    assert conformance_of(RunSpecification(controller="./gone.py:Mine", **world)) == []
    assert conformance_of(RunSpecification(controller="computed_torque", settings={"width": 1.0}, **world)) == []
