"""Shows a controller what another one saw, tick by tick, and keeps what it would have answered; nothing moves."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ..controllers import InvalidInput, Refusal, build_controller, discovery, hook
from .episode import Episode, aim, change_load, describe, observe
from .specification import RunSpecification
from .tick import frame_dtype, target_dtype
from .trial import ControllerFault, reset_controller
from .world import World

SEEN = ("q_measured", "dq_measured", "wrench_measured")
"""What a tick's own sensors gave; commands and torques that a controller is shown are those of the tick before."""


@dataclass(frozen=True, kw_only=True)
class Fed:
    """What a controller answered to observations that its own torques did not bring about.

    Attributes:
        times: Time of every tick that it answered, shape (K,) [s].
        command: Its answers, shape (K, n) [N m].
        failure: What ended it early, in one line; empty if it answered to the end.
    """

    times: np.ndarray
    command: np.ndarray
    failure: str


def feed(
    specification: RunSpecification,
    frames: np.ndarray,
    *,
    controller: str,
    settings: Mapping[str, object],
    plug_ins: Mapping[str, object] | None = None,
) -> Fed:
    """Feed the observations of a run to a controller.

    Task, plan, knowledge level and seeds are those that the controller would have had in the run's place, so the run's
    own controller answers what it answered.

    Args:
        specification: The run.
        frames: Its ticks, records of :func:`~.tick.frame_dtype`, shape (K,).
        controller: Name or door of the controller.
        settings: Its keyword arguments.
        plug_ins: Python objects behind controller names that no other door knows.

    Raises:
        TorquebenchError: If the controller cannot be had or refuses the task.
    """
    taken = replace(specification, controller=controller, settings=dict(settings))
    factory = discovery.load("controllers", (plug_ins or {}).get(controller, controller))
    law = build_controller(factory, settings, name=controller)
    world = World(taken, taken.schedule)
    answers = np.full((len(frames), world.robot.n), np.nan)
    answered, failure = 0, ""
    try:
        episode = world.episode(law, reset_controller(world, law))
        for answer in _answers(episode, frames):
            if getattr(answer, "shape", None) != answers[answered].shape:
                raise ValueError(f"expected an array of shape {answers[answered].shape}")
            answers[answered] = answer
            answered += 1
    except (Refusal, InvalidInput):
        raise
    except Exception as error:
        failure = str(error) if isinstance(error, ControllerFault) else describe(error)
    finally:
        world.plant.close()
        with suppress(Exception):
            hook(law, "close")()  # type: ignore[operator]
    return Fed(times=world.times[:answered], command=answers[:answered], failure=failure)


def _answers(episode: Episode, frames: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the answer to every tick's observation."""
    n = episode.plant.q.shape[0]
    frame, target = np.zeros(1, frame_dtype(n)), np.zeros(1, target_dtype(n))
    frame["readback"] = frame["torque"] = episode.nominal_gravity
    observation, plan = observe(frame), aim(target, episode.reference)
    for k, seen in enumerate(frames):
        if k in episode.loads:
            change_load(episode, episode.loads[k])
        observation.time = float(episode.times[k])
        target[0] = episode.table[k]
        for name in SEEN:
            frame[name][0] = seen[name]
        episode.provider.refresh(observation)
        yield episode.controller.compute(observation, plan)
        frame["readback"], frame["torque"] = seen["readback"], seen["torque"]
