"""Joins rooms: what the controller of a run computes, whichever room it comes from."""

from dataclasses import replace
from functools import cache

from .baselines.operation_costs import gravity_feedback_costs, operation_costs
from .cbmc.controller import CbmcV3
from .cbmc.nulls import PdOracle
from .cbmc.operation_costs import stack_costs
from .controllers import TorquebenchError, build_controller, discovery, hook
from .controllers.operations import OperationCosts
from .scenarios.specification import RunSpecification
from .scenarios.world import World


def costs_of(specification: RunSpecification) -> OperationCosts | None:
    """Return what the controller of a run computes; None for a plug-in, which nobody has counted.

    Nothing runs: the laws are counted on their expression graphs, and CBMC is reset once for the sizes of its networks.
    What a law computes depends neither on what it is told nor on what was drawn, so such runs are counted once.

    Args:
        specification: The run.
    """
    alike = replace(specification, plant="pinocchio", knowledge="none", repetition=0, draws=False, twins=False)
    return _counted(alike.as_json())


@cache
def _counted(specification: str) -> OperationCosts | None:
    try:
        return _costs(RunSpecification.from_json(specification))
    except TorquebenchError:
        # A robot's file or a plug-in that is gone costs its counts, not the report.
        return None


def _costs(specification: RunSpecification) -> OperationCosts | None:
    name = specification.controller
    if name not in discovery.names("controllers"):
        return None
    controller = build_controller(discovery.load("controllers", name), specification.settings, name=name)
    world = World(specification, specification.schedule)
    try:
        if isinstance(controller, CbmcV3):
            controller.reset(world.task())
            return stack_costs(controller.stack)
        robot = world.task().robot
        return gravity_feedback_costs(robot) if isinstance(controller, PdOracle) else operation_costs(robot, controller)
    finally:
        hook(controller, "close")()  # type: ignore[operator]
        world.plant.close()
