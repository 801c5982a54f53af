"""From an arm and a recipe to patterns with their notes; what ``torquebench train cerebellum`` does."""

import importlib.util
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ...controllers import InvalidInput, UnknownName
from ..patterns import Patterns, robot_key
from ..point_payload import point_payload
from .evaluation import GravityError, gravity_heldout, gravity_torques
from .recipes import PRESETS, Recipe
from .sets import SETS, TrainingSet, Workspace, training_set
from .watch import Watch

LIBRARIES = ("torquebench", "numpy", "pin", "torch")
EVERY = 10
"""Every so many samples of a path enter its evaluation."""


@dataclass(frozen=True, kw_only=True)
class Lesson:
    """What is to be learnt, and how.

    Attributes:
        robot: Name of the robot, for the notes.
        urdf_digest: Digest of its description, for the notes.
        loads: Load beyond the gripper of each pattern [kg].
        load_centre: Where the loads' centres are along z of the flange [m].
        training_set: Name of the training set.
        preset: Name of the recipe.
        seed: Seed of everything that is drawn.
    """

    robot: str
    urdf_digest: str = ""
    loads: tuple[float, ...] = (0.0, 3.0)
    load_centre: float
    training_set: str = "workspace"
    preset: str = "default"
    seed: int = 1

    def __post_init__(self) -> None:
        """Check what can be checked without an arm."""
        if self.preset not in PRESETS:
            raise UnknownName("preset", self.preset, tuple(PRESETS))
        if self.training_set not in SETS:
            raise UnknownName("training set", self.training_set, SETS)
        rising = all(a < b for a, b in zip(self.loads, self.loads[1:], strict=False))
        if not self.loads or not all(0.0 <= load < np.inf for load in self.loads) or not rising:
            listed = ",".join(f"{load:g}" for load in self.loads)
            raise InvalidInput(f"loads {listed!r}", "training", "give increasing masses beyond the gripper in kg: 0,3")
        if self.seed < 0:
            raise InvalidInput(f"seed {self.seed}", "training", "give a whole number, 0 or larger")

    @property
    def recipe(self) -> Recipe:
        """The recipe of the preset."""
        return PRESETS[self.preset]

    @property
    def payloads(self) -> np.ndarray:
        """Parameters of each pattern's load, shape (P, 10)."""
        return np.array([point_payload(load, self.load_centre) for load in self.loads])


def train_cerebellum(arm: Workspace, lesson: Lesson, watch: Watch) -> Patterns:
    """Train a pattern for each load and evaluate them on paths and postures that training did not see.

    Args:
        arm: The arm and its paths.
        lesson: What is to be learnt.
        watch: Is told the share that is done.

    Raises:
        InvalidInput: If torch is missing, or the set needs paths that the arm cannot follow.
    """
    if importlib.util.find_spec("torch") is None:
        raise InvalidInput("torch is missing", "training", "pip install 'torquebench[train]'")
    from .trainer import train_pattern

    rng = np.random.default_rng([lesson.seed, 0])
    chosen = training_set(lesson.training_set, arm, samples=lesson.recipe.samples, rng=rng)
    trained = []
    for index, (load, payload) in enumerate(zip(lesson.loads, lesson.payloads, strict=True)):
        torques = [gravity_torques(arm.model, part, payload) for part in chosen.parts]
        seed = int(np.random.SeedSequence([lesson.seed, 1 + index]).generate_state(1)[0])
        share = _share_of(watch, index, len(lesson.loads))
        trained.append(train_pattern(chosen.parts, torques, lesson.recipe, load=load, seed=seed, watch=share))
    patterns = _joined(trained)
    groups = evaluation_groups(arm.paths, chosen.held_out)
    table = gravity_heldout(patterns, arm.model, lesson.payloads, groups)
    return replace(patterns, notes=_notes(arm, lesson, chosen, table))


def evaluation_groups(paths: Mapping[str, np.ndarray], held_out: np.ndarray) -> dict[str, np.ndarray]:
    """Return the groups of postures on which patterns are judged: thinned paths by name, and the workspace.

    Args:
        paths: Joint paths by name, sampled at 1 ms, each of shape (N, n) [rad].
        held_out: Workspace postures, shape (N, n) [rad].
    """
    return {**{name: path[::EVERY] for name, path in paths.items()}, "workspace": held_out}


def _joined(trained: Sequence[Patterns]) -> Patterns:
    """Return patterns of one load each as one record."""

    def joined(name: str) -> np.ndarray:
        return np.concatenate([getattr(pattern, name) for pattern in trained])

    return Patterns(
        granule=joined("granule"),
        granule_bias=joined("granule_bias"),
        purkinje=joined("purkinje"),
        purkinje_bias=joined("purkinje_bias"),
        readout=joined("readout"),
        readout_bias=joined("readout_bias"),
        loads=tuple(load for pattern in trained for load in pattern.loads),
    )


def _share_of(watch: Watch, index: int, count: int) -> Watch:
    """Return a watch for one pattern among several."""
    return lambda share: watch((index + share) / count)


def _notes(arm: Workspace, lesson: Lesson, chosen: TrainingSet, table: tuple[GravityError, ...]) -> dict[str, object]:
    """Return how patterns were made and how they do, as plain values."""
    return {
        "robot": {
            "name": lesson.robot,
            "key": robot_key(arm.model),
            "urdf_sha256": lesson.urdf_digest,
            "joints": arm.model.n,
        },
        "load_centre": lesson.load_centre,
        "training_set": {"name": chosen.name, "postures": [len(part) for part in chosen.parts]},
        "preset": lesson.preset,
        "recipe": asdict(lesson.recipe),
        "seed": lesson.seed,
        "versions": {name: _version(name) for name in LIBRARIES},
        "evaluation": {
            "unit": "N m",
            "what": "rmse over postures and joints, and over postures of the worst joint; "
            "paths every 10 ms, workspace: 2000 postures that training did not see",
            "rows": [_row(entry) for entry in table],
        },
    }


def _row(entry: GravityError) -> dict[str, object]:
    rounded = {name: round(value, 4) for name, value in asdict(entry).items() if isinstance(value, float)}
    return {**asdict(entry), **rounded}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"
