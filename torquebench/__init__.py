"""torquebench: honest side-by-side comparison of joint-torque controllers for robot arms.

The public names are imported when they are used: the command line answers before any library is loaded.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .controllers import Controller, Observation, RobotModel, Target, Task, TorquebenchError
    from .running import RunReport, run

_HOMES = {
    "Controller": ".controllers",
    "Observation": ".controllers",
    "RobotModel": ".controllers",
    "Target": ".controllers",
    "Task": ".controllers",
    "TorquebenchError": ".controllers",
    "RunReport": ".running",
    "run": ".running",
}

__all__ = ["Controller", "Observation", "RobotModel", "RunReport", "Target", "Task", "TorquebenchError", "run"]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name], __name__), name)
