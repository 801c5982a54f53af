"""Writes the report of a results folder for the commands."""

from pathlib import Path

from .controllers import InvalidInput
from .evaluation.report import write_report
from .operation_costs import costs_of


def report(folder: Path) -> Path:
    """Write the report of a results folder and return its page.

    Args:
        folder: The folder.

    Raises:
        InvalidInput: If it holds no run store, or the report cannot be written; an old report is kept then.
    """
    try:
        return write_report(folder, costs_of=lambda run: costs_of(run.specification)).index
    except OSError as cause:
        raise InvalidInput(
            f"the report cannot be written ({cause})", str(folder), "runs and old report are kept"
        ) from cause
