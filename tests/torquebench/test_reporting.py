"""What the report learns of robots: the arm if it is there, nothing if it is not."""

import json

from torquebench.reporting import conformance_of, skeleton_of
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.store import StoredRun


def test_a_known_robot_has_a_skeleton_that_json_can_hold():
    """It is embedded in the page."""
    found = skeleton_of("rizon4s", "")
    assert json.loads(json.dumps(found))["tool"] == found["tool"] > 7


def test_a_robot_that_is_gone_costs_the_replay_and_not_the_report():
    """Stores travel without the URDF of their arm."""
    assert skeleton_of("gone/arm.urdf", "") is None
    assert skeleton_of("nobody", "") is None
    assert skeleton_of("rizon4s", "no such tool") is None


def run_of(controller, median=20.0, **settings):
    """Return a stored run of a controller whose calls took so long [us]."""
    load = LoadSchedule.constant(Payload(mass=1.5))
    world = {"trajectory": "T1", "schedule": load, "robot": "rizon4s", "plant": "pinocchio", "tier": "ideal"}
    specification = RunSpecification(controller=controller, settings=settings, **world)
    result = RunResult(role="run", status="ok", timing={"call_us_median": median})
    return StoredRun(address="a", specification=specification, result=result, trace="")


def test_a_controller_is_checked_as_it_was_run_and_one_that_is_gone_is_not():
    """Settings are part of a controller; a file that is no longer there costs its row and not the report."""
    found = conformance_of(run_of("computed_torque", bandwidth=12.0))
    assert found and all(finding.passed for finding in found)
    assert conformance_of(run_of("./gone.py:Mine")) == []
    assert conformance_of(run_of("computed_torque", width=1.0)) == []


def test_a_report_does_not_wait_for_a_slow_controller():
    """A thousand calls of 50 ms each would take longer than the rest of the page."""
    assert conformance_of(run_of("computed_torque", median=50_000.0)) == []
