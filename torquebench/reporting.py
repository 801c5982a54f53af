"""Writes the report of a results folder for the commands."""

import os
from dataclasses import asdict
from pathlib import Path

from .controllers import Finding, InvalidInput, TorquebenchError
from .evaluation.report import write_report
from .gravity_errors import gravity_errors_of
from .operation_costs import costs_of
from .scenarios.conformance import check
from .scenarios.robots import load_robot, skeleton
from .scenarios.store import StoredRun

SLOW_CALL = 4000.0
"""Median time of a call above which a report does not wait for the thousand calls of the checks [us]."""


def report(folder: Path) -> Path:
    """Write the report of a results folder and return its page.

    Args:
        folder: The folder.

    Raises:
        InvalidInput: If it holds no run store, or the report cannot be written; an old report is kept then.
    """
    try:
        return write_report(
            folder,
            costs_of=lambda run: costs_of(run.specification),
            gravity_of=lambda run: gravity_errors_of(run.specification),
            conformance_of=conformance_of,
            skeleton_of=skeleton_of,
            workers=os.cpu_count() or 1,
        ).index
    except OSError as cause:
        raise InvalidInput(
            f"the report cannot be written ({cause})", str(folder), "runs and old report are kept"
        ) from cause


def conformance_of(run: StoredRun) -> list[Finding]:
    """Return the outcome of every check of a run's controller; none if it is slow or no longer where the run found it.

    Args:
        run: The run.
    """
    median = run.result.timing.get("call_us_median")
    if isinstance(median, int | float) and median > SLOW_CALL:
        return []
    try:
        return check(run.specification.controller, run.specification.settings)
    except TorquebenchError:
        return []


def skeleton_of(robot: str, tool: str) -> dict[str, object] | None:
    """Return what the replay draws of a robot; None if its file is no longer where the runs found it.

    Args:
        robot: Name or file of the robot.
        tool: Name of its tool point.
    """
    try:
        return asdict(skeleton(load_robot(robot, tool=tool)))
    except TorquebenchError:
        # A report is often read where the runs were not made.
        return None
