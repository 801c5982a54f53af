"""Short runs of the Rizon: a world, a controller, an outcome."""

import numpy as np
import pytest
from torquebench.controllers import NoKnowledge
from torquebench.scenarios.episode import run_episode
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World


@pytest.fixture
def run_of():
    """Builds the specification of a run: T6, 1.5 kg, Pinocchio plant, ideal tier, unless told otherwise."""

    def build(**changes):
        settings = {
            "controller": "mine",
            "trajectory": "T6",
            "schedule": LoadSchedule.constant(Payload(mass=1.5)),
            "robot": "rizon4s",
            "plant": "pinocchio",
            "tier": "ideal",
            "laps": 1,
            "lead_in": 0.2,
        }
        return RunSpecification(**settings | changes)

    return build


@pytest.fixture
def world_of(run_of):
    """Builds the world of a run that ends after some seconds, lead-in included."""
    opened = []

    def build(*, seconds=0.1, **changes):
        specification = run_of(**changes)
        world = World(specification, specification.schedule)
        ticks = round(seconds / world.tier.period)
        world.times, world.table = world.times[:ticks], world.table[:ticks]
        opened.append(world.plant)
        return world

    yield build
    for plant in opened:
        plant.close()


@pytest.fixture
def play():
    """Runs a controller in a world and returns the outcome."""

    def run(world, controller, provider=None, **changes):
        provider = provider or NoKnowledge()
        task = world.task()
        provider.reset(task.robot, task.actuation, world.truth)
        controller.reset(task)
        episode = world.episode(controller, provider)
        for name, value in changes.items():
            episode.constants[name][:] = value
        return run_episode(episode)

    return run


class Holds:
    """Gives the gravity torque that its model knows, and keeps what it saw."""

    def reset(self, task):
        self.task, self.robot, self.seen = task, task.robot, []

    def compute(self, observation, target):
        self.seen.append({name: np.array(getattr(observation, name)) for name in observation.__slots__})
        return self.robot.gravity(observation.q)


class Follows(Holds):
    """Computed torque."""

    def compute(self, observation, target):
        super().compute(observation, target)
        acceleration = target.ddq + 400 * (target.q - observation.q) + 40 * (target.dq - observation.dq)
        return self.robot.inverse_dynamics(observation.q, observation.dq, acceleration)


class Says(Holds):
    """Answers with whatever a function of the tick returns."""

    def __init__(self, answer):
        self.answer = answer

    def compute(self, observation, target):
        super().compute(observation, target)
        return self.answer(len(self.seen) - 1)


@pytest.fixture
def holds():
    """A controller that holds the arm against gravity."""
    return Holds()


@pytest.fixture
def follows():
    """A controller that follows the plan."""
    return Follows()


@pytest.fixture
def says():
    """Builds a controller that answers with a function of the tick."""
    return Says
