"""Checks of the contract on observations of a real episode: the Rizon 4s on the Pinocchio plant."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import TypeVar

import numpy as np

from ..controllers import Finding, NoKnowledge, Observation, Target, Task, build_controller, check_controller, discovery
from ..controllers.conformance import MEASURED, PLANNED
from .episode import run_episode
from .loads import LoadSchedule, Payload
from .specification import RunSpecification
from .world import World

AnyRecord = TypeVar("AnyRecord", Observation, Target)

SECONDS = 0.2
"""Duration of the recording: the start from rest to the speed of the lap [s]."""


def check(controller: object, settings: Mapping[str, object] | None = None) -> list[Finding]:
    """Check a controller against the contract.

    Args:
        controller: One of the four doors: a registered name, ``package.module:Name``, ``./file.py:Name``, an object.
        settings: Its keyword arguments.

    Returns:
        One finding per law, see :func:`~torquebench.controllers.check_controller`.

    Raises:
        TorquebenchError: If the controller cannot be found, imported or built.
    """
    behind = discovery.load("controllers", controller)
    name = controller if isinstance(controller, str) else type(controller).__name__
    task, observations, targets = recording()
    return check_controller(
        lambda: build_controller(behind, settings or {}, name=name), task, list(observations), list(targets)
    )


@lru_cache(maxsize=1)
def recording() -> tuple[Task, tuple[Observation, ...], tuple[Target, ...]]:
    """Return the task of an episode and what its controller saw: T1 with 2.5 kg of sand, drives and sensors real."""
    schedule = LoadSchedule.constant(Payload(mass=2.5, material="sand"))
    specification = RunSpecification(
        controller="recorder",
        trajectory="T1",
        schedule=schedule,
        robot="rizon4s",
        plant="pinocchio",
        tier="actuated",
        laps=1,
        lead_in=SECONDS,
    )
    world = World(specification, schedule)
    task, recorder, provider = world.task(), _Recorder(), NoKnowledge()
    ticks = round(SECONDS / task.period)
    world.times, world.table = world.times[:ticks], world.table[:ticks]
    recorder.reset(task)
    provider.reset(task.robot, task.actuation, world.truth)
    run_episode(world.episode(recorder, provider))
    return world.task(), tuple(recorder.observations), tuple(recorder.targets)


class _Recorder:
    """Computed torque that keeps a copy of all it sees."""

    def reset(self, task: Task) -> None:
        self.robot = task.robot
        self.observations: list[Observation] = []
        self.targets: list[Target] = []

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        self.observations.append(_copy(observation, MEASURED))
        self.targets.append(_copy(target, PLANNED))
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        return self.robot.inverse_dynamics(
            observation.q, observation.dq, target.ddq + 400.0 * error + 40.0 * error_rate
        )


def _copy(record: AnyRecord, names: tuple[str, ...]) -> AnyRecord:
    """Return a record with arrays of its own."""
    arrays = {name: np.array(getattr(record, name)) for name in names}
    return replace(record, **arrays)  # type: ignore[arg-type]
