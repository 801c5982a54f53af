"""From a benchmark to run specifications, everything checked that a run would stumble over."""

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from ..controllers import STANDARD_LEVELS, InvalidInput, UnknownName, build_controller, discovery, knowledge_levels
from .benchmark import DEFAULT_TIER, Benchmark, Sweep, schedules
from .elastic_loop import check_substeps
from .loads import LoadSchedule
from .perturbation import Perturbation
from .robots import Robot
from .specification import CARRIED, FRESH, RunSpecification
from .tiers import Tier, build_tier
from .trajectories.feasibility import Motion, check_motion
from .trajectories.kinematics import Lap
from .trajectories.reference import STEP
from .world import cached_plan, cached_robot

RunFactory = partial[RunSpecification]

PREFERRED_PLANT, OTHER_PLANT = "pybullet", "pinocchio"


@dataclass(frozen=True, kw_only=True)
class Expansion:
    """The runs of a benchmark.

    Attributes:
        specifications: The runs in the order of the file, none twice.
        reference: Label of the controller that all others are compared with.
        notes: What a reader of the report should know about how it came to these runs.
    """

    specifications: tuple[RunSpecification, ...]
    reference: str
    notes: tuple[str, ...]


def expand(benchmark: Benchmark, *, plug_ins: Mapping[str, object] | None = None) -> Expansion:
    """Return the runs of a benchmark.

    Args:
        benchmark: The benchmark.
        plug_ins: Python objects behind controller names that no other door knows.

    Raises:
        TorquebenchError: If a robot, plant, tier, trajectory, load, controller or setting is wrong.
    """
    notes: list[str] = []
    found: dict[str, RunSpecification] = {}
    used: set[str] = set()
    for sweep in benchmark.sweeps():
        cells = _cells(benchmark, sweep, _plant(sweep.plant or "", notes))
        for controller in sweep.controllers or ():
            used.add(controller)
            settings = (sweep.settings or {}).get(controller, {})
            for level in _levels(controller, settings, sweep, plug_ins or {}):
                for cell in cells:
                    specification = cell(controller=controller, settings=dict(settings), knowledge=level)
                    found[specification.as_json()] = specification
    for name in benchmark.settings:
        if name not in used:
            raise UnknownName("controller in settings", name, sorted(used))
    return Expansion(
        specifications=tuple(found.values()),
        reference=_reference(benchmark, [specification.label for specification in found.values()], notes),
        notes=tuple(dict.fromkeys(notes)),
    )


def _plant(named: str, notes: list[str]) -> str:
    """Return the plant that a run table names, or the preferred one if it is installed."""
    if named:
        if ":" not in named and named not in discovery.names("plants"):
            raise UnknownName("plant", named, discovery.names("plants"))
        if named == PREFERRED_PLANT and importlib.util.find_spec(PREFERRED_PLANT) is None:
            raise InvalidInput(
                "PyBullet is not installed", "plant 'pybullet'", "it has wheels up to Python 3.11; use pinocchio"
            )
        return named
    if importlib.util.find_spec(PREFERRED_PLANT) is not None:
        return PREFERRED_PLANT
    notes.append(
        "PyBullet is not installed (it has no wheels beyond Python 3.11): "
        "the Pinocchio plant computes the same equations."
    )
    return OTHER_PLANT


def _checked(history: LoadSchedule, robot: Robot) -> LoadSchedule:
    """Return a load history in its one spelling; the robot must be able to carry it."""
    canonical = LoadSchedule(entries=tuple((time, load.canonical(robot)) for time, load in history.entries))
    canonical.slots(robot)
    return canonical


def _levels(
    controller: str, settings: Mapping[str, object], sweep: Sweep, plug_ins: Mapping[str, object]
) -> tuple[str, ...]:
    """Return the knowledge levels at which a configured controller runs."""
    known = discovery.names("knowledge")
    for level in sweep.knowledge or ():
        if level not in known:
            raise UnknownName("knowledge level", level, known)
    factory = discovery.load("controllers", plug_ins.get(controller, controller))
    built = build_controller(factory, settings, name=controller)
    if sweep.protocol == CARRIED and not getattr(built, "carry_over", False):
        raise InvalidInput(
            "has no carry_over",
            f"controller {controller!r} in protocol 'carried'",
            "it forgets at every reset; run it fresh",
        )
    asked = sweep.knowledge or (*STANDARD_LEVELS, *(getattr(built, "knowledge_levels", None) or ()))
    return tuple(level for level in knowledge_levels(built, known) if level in asked)


def _tier(sweep: Sweep, robot: Robot) -> tuple[Tier, dict[str, object]]:
    """Return the tier of a run table, and the constants that it changes as a specification has them."""
    given = sweep.tier_constants.model_dump(exclude_unset=True) if sweep.tier_constants else {}
    changes = {name: list(value) if isinstance(value, tuple) else value for name, value in given.items()}
    tier = build_tier(sweep.tier or DEFAULT_TIER, robot.tiers, robot.rotor_inertia, changes)
    check_substeps(tier, robot.model(rotor_inertia=tier.rotor_inertia).mass_matrix(robot.home))
    return tier, changes


def _cells(benchmark: Benchmark, sweep: Sweep, plant: str) -> list[RunFactory]:
    """Return what makes the specification of each cell: motion, load history and repetition, in its world.

    Raises:
        TorquebenchError: If there is no such tier or tool, or the robot cannot follow a motion or carry a load.
    """
    robot = cached_robot(benchmark.robot, sweep.tool or "")
    tier, changes = _tier(sweep, robot)
    world = partial(
        RunSpecification,
        robot=benchmark.robot,
        tool=robot.tool,
        plant=plant,
        tier=tier.name,
        tier_constants=changes,
        latency=benchmark.latency,
        tare=benchmark.tare,
        campaign=benchmark.seed,
        draws=bool(sweep.draws),
    )
    histories = tuple(_checked(history, robot) for history in schedules(sweep))
    lead_in = 1.0 if sweep.lead_in is None else sweep.lead_in
    for trajectory in sweep.trajectories or ():
        _check_motion(trajectory, histories, lead_in, robot, tier)
    times = sweep.repetitions or 1
    perturbation = Perturbation(**(sweep.perturbation.model_dump() if sweep.perturbation else {}))
    repeated: list[dict[str, int]] = [{"repetition": repetition} for repetition in range(times)]
    return [
        partial(
            world,
            trajectory=trajectory,
            schedule=history,
            twins=bool(sweep.twins) and bool(history.events),
            laps=sweep.laps or 3,
            lead_in=lead_in,
            protocol=sweep.protocol or FRESH,
            perturbation=perturbation,
            study=study,
            **repetition,
        )
        for study in sweep.studies or ("",)
        for trajectory in sweep.trajectories or ()
        for history in histories
        for repetition in ([{"repetitions": times}] if sweep.protocol == CARRIED else repeated)
    ]


def _check_motion(
    trajectory: str, histories: tuple[LoadSchedule, ...], lead_in: float, robot: Robot, tier: Tier
) -> None:
    """Refuse a motion that the arm cannot follow with the heaviest of its loads."""
    plan = cached_plan(robot, trajectory, lead_in)
    loads = (load for history in histories for _, load in history.entries)
    check_motion(
        Motion(
            name=trajectory,
            lap=Lap(q=plan.q, dq=plan.dq, ddq=plan.ddq),
            step=STEP,
            robot=robot,
            load=max(loads, key=lambda load: load.mass),
            rotor_inertia=tier.rotor_inertia,
        )
    )


def _reference(benchmark: Benchmark, labels: list[str], notes: list[str]) -> str:
    """Return the declared reference, or the first controller with a note if the declared one does not run."""
    if not labels:
        raise InvalidInput(
            "has no runs", f"benchmark {benchmark.name!r}", "give controllers a knowledge level they take"
        )
    if benchmark.reference in labels:
        return benchmark.reference
    if benchmark.reference:
        notes.append(
            f"The declared reference {benchmark.reference!r} is not among the controllers: {labels[0]!r} stands in."
        )
    return labels[0]
