"""How fast harness, plants and controllers are here: medians of repeats in one process, best of five."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..controllers import Observation, Target, build_controller, discovery
from .episode import Outcome, run_episode
from .execution import Evaluate, execute
from .loads import LoadSchedule, Payload
from .plants.pybullet_plant import PyBulletPlant
from .result import OK, Scores
from .specification import RunSpecification
from .world import World

REPEATS = 5
LOAD = LoadSchedule.constant(Payload(mass=2.5, material="sand"))
TRAJECTORY = "T6"
TICK_BARS: dict[str, float | None] = {"flexiv_factory": 40.0, "computed_torque": None, "whole_body_qp": 60.0}
"""Controllers whose median tick is measured, and what it should keep to, if there is a bar [us]."""

SPIKING, THIRD_LEVEL = "cbmc_v3", 50
"""The spiking controller, and the period of its slowest level [ticks]."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One measured figure.

    Attributes:
        name: What was measured.
        value: The best of the repeats.
        unit: Its unit.
        bar: What it should keep to, None if there is no bar.
        at_least: Whether the bar is a floor instead of a ceiling.
    """

    name: str
    value: float
    unit: str
    bar: float | None = None
    at_least: bool = False

    @property
    def met(self) -> bool:
        """Whether the bar is kept."""
        if self.bar is None:
            return True
        return self.value >= self.bar if self.at_least else self.value <= self.bar


class Holding:
    """A controller that costs nothing: it repeats the gravity torque of the start."""

    knowledge_levels = ("oracle",)

    def __init__(self, torque: np.ndarray) -> None:
        self.torque = torque

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the same buffer every tick."""
        return self.torque


def measure_speed(plant: str, *, evaluate: Evaluate) -> tuple[Figure, ...]:
    """Measure on one robot and motion.

    Args:
        plant: Name of the plant.
        evaluate: Scores a log, part of the end-to-end figure.

    Returns:
        The figures, each the best of five repeats.
    """
    ideal, actuated, elastic = (tick_time(plant, tier) for tier in ("ideal", "actuated", "elastic"))
    figures = [
        Figure(name="tick without a controller, ideal", value=ideal, unit="us"),
        Figure(name="tick without a controller, actuated", value=actuated, unit="us"),
        Figure(name="tick without a controller, elastic", value=elastic, unit="us", bar=60.0),
        Figure(name="actuated over ideal", value=actuated / ideal, unit="1", bar=2.0),
    ]
    world = World(_specification("computed_torque", plant, "ideal"), LOAD)
    inside = plant_time(world)
    harness = ideal - inside + wrench_time(world)
    figures.append(Figure(name="plant step", value=inside, unit="us"))
    figures.append(Figure(name="harness: sensors, target, limiter, log, wrench", value=harness, unit="us"))
    if isinstance(world.plant, PyBulletPlant):
        own = bullet_time(world.plant)
        figures.append(Figure(name="PyBullet's own read, write and step", value=own, unit="us"))
        figures.append(Figure(name="harness over PyBullet's own", value=harness / own, unit="1", bar=0.6))
    world.plant.close()
    factor = end_to_end("computed_torque", plant, evaluate)
    figures.append(
        Figure(name="computed torque, end to end", value=factor, unit="x real time", bar=40.0, at_least=True)
    )
    known = discovery.names("controllers")
    figures += [
        Figure(name=f"{name} tick", value=call_time(name, plant), unit="us", bar=bar)
        for name, bar in TICK_BARS.items()
        if name in known
    ]
    if SPIKING in known:
        figures += spiking_figures(plant)
    return tuple(figures)


def spiking_figures(plant: str) -> list[Figure]:
    """Return what the spiking controller costs: on average, when all its levels run, at worst, and its whole loop."""
    outcomes = []
    for _ in range(REPEATS):
        specification = replace(_specification(SPIKING, plant, "ideal"), knowledge="none")
        world = World(specification, LOAD)
        controller = build_controller(discovery.load("controllers", SPIKING), {}, name=SPIKING)
        controller.reset(world.task())  # type: ignore[attr-defined]
        provider = discovery.load("knowledge", "none")()  # type: ignore[operator]
        outcomes.append(run_episode(world.episode(controller, provider)))
        world.plant.close()
    calls = [outcome.log["call_time"][500:] * 1e-3 for outcome in outcomes]
    # Row k is tick k + 1, so the rows at which the third level runs end a stretch of its period.
    all_levels = [np.median(times[(THIRD_LEVEL - 501) % THIRD_LEVEL :: THIRD_LEVEL]) for times in calls]
    factor = max(len(outcome.log) * 1e-3 / outcome.wall_time for outcome in outcomes)
    name = f"{SPIKING} tick"
    return [
        Figure(name=f"{name}, mean", value=min(times.mean() for times in calls), unit="us", bar=6.0),
        Figure(name=f"{name}, all levels, median", value=float(min(all_levels)), unit="us", bar=100.0),
        Figure(name=f"{name}, 99.9th percentile", value=min(np.quantile(times, 0.999) for times in calls), unit="us"),
        Figure(name=f"{SPIKING}, whole loop", value=factor, unit="x real time", bar=35.0, at_least=True),
    ]


def tick_time(plant: str, tier: str) -> float:
    """Return the time of one tick of the whole loop with a controller that costs nothing [us]."""

    def once() -> float:
        world = World(_specification("computed_torque", plant, tier), LOAD)
        outcome = _hold(world)
        world.plant.close()
        return outcome.wall_time / len(outcome.log) * 1e6

    return min(once() for _ in range(REPEATS))


def call_time(controller: str, plant: str) -> float:
    """Return the median time of one call of a controller in a running loop [us]."""

    def once() -> float:
        (result,) = execute(_specification(controller, plant, "ideal"), evaluate=_unscored, traces="none")
        return float(result.timing["call_us_median"]) if result.status == OK else float("nan")

    return min(once() for _ in range(REPEATS))


def end_to_end(controller: str, plant: str, evaluate: Evaluate) -> float:
    """Return simulated time over wall time of a whole run: world, reset, loop, metrics, trace."""
    specification = _specification(controller, plant, "ideal")

    def once() -> float:
        (result,) = execute(specification, evaluate=evaluate)
        return float(result.timing["simulated_s"]) / float(result.timing["total_s"])

    return max(once() for _ in range(REPEATS))


def plant_time(world: World) -> float:
    """Return the time of one step of a plant, held at its start [us]."""
    torque = world.plant.gravity()
    return _best(lambda: world.plant.step(torque))


def wrench_time(world: World) -> float:
    """Return the time of one force and torque reading, which a plant's step contains [us]."""
    return _best(world.plant.measure_wrench)


def bullet_time(plant: PyBulletPlant) -> float:
    """Return the time of PyBullet's own read, write and step, as a plain script would call them [us]."""
    bullet, body, joints, client = plant.bullet, plant.body, plant.joints, plant.client
    torque = plant.gravity().tolist()

    def once() -> None:
        bullet.getJointStates(body, joints, physicsClientId=client)
        bullet.setJointMotorControlArray(body, joints, bullet.TORQUE_CONTROL, forces=torque, physicsClientId=client)
        bullet.stepSimulation(physicsClientId=client)

    return _best(once)


def _hold(world: World) -> Outcome:
    """Run an episode that only the plant's own motion could end, for at most a second of simulated time."""
    world.times, world.table = world.times[:1000], world.table[:1000].copy()
    world.table["q"] = world.table["q"][0]
    provider = discovery.load("knowledge", "none")()  # type: ignore[operator]
    return run_episode(world.episode(Holding(world.plant.gravity()), provider))


def _specification(controller: str, plant: str, tier: str) -> RunSpecification:
    return RunSpecification(
        controller=controller,
        trajectory=TRAJECTORY,
        schedule=LOAD,
        robot="rizon4s",
        plant=plant,
        tier=tier,
        knowledge="oracle",
        laps=5,
    )


def _unscored(_: object) -> Scores:
    return Scores(metrics={})


def _best(call: Callable[[], None], *, number: int = 500) -> float:
    """Return the time of one call, best of the repeats [us]."""
    call()
    best = float("inf")
    for _ in range(REPEATS):
        begun = time.perf_counter()
        for _ in range(number):
            call()
        best = min(best, time.perf_counter() - begun)
    return best / number * 1e6
