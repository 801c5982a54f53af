"""Model predictive control whose cost is the tool's pose."""

from dataclasses import dataclass
from typing import ClassVar

from .mpc import Mpc
from .mpc_problem import PlanProblem
from .mpc_tool_problem import ToolProblem


@dataclass(kw_only=True)
class MpcTool(Mpc):
    """The same law with plans that track the tool, see :class:`torquebench.baselines.mpc_tool_problem.ToolProblem`."""

    problem_type: ClassVar[type[PlanProblem]] = ToolProblem
