"""What the report learns of robots: the arm if it is there, nothing if it is not."""

import json

from torquebench.reporting import skeleton_of


def test_a_known_robot_has_a_skeleton_that_json_can_hold():
    """It is embedded in the page."""
    found = skeleton_of("rizon4s", "")
    assert json.loads(json.dumps(found))["tool"] == found["tool"] > 7


def test_a_robot_that_is_gone_costs_the_replay_and_not_the_report():
    """Stores travel without the URDF of their arm."""
    assert skeleton_of("gone/arm.urdf", "") is None
    assert skeleton_of("nobody", "") is None
    assert skeleton_of("rizon4s", "no such tool") is None
