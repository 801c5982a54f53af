"""The digest of code and data that a run uses: results of other code are other results."""

import hashlib
import importlib.util
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from ..controllers import discovery
from .specification import RunSpecification
from .world import cached_robot

LIBRARIES = ("numpy", "scipy", "numba", "pin", "pybullet", "control", "proxsuite", "casadi")
SHARED_ROOMS = ("controllers", "scenarios", "evaluation.metrics")
STUDY_ROOMS = ("evaluation.loops", "judging")
"""Modules that judge the runs of a study."""

PACKAGE = __name__.split(".")[0]


def run_digest(specification: RunSpecification, plug_ins: Mapping[str, object] | None = None) -> str:
    """Return the SHA-256 of all code and data, ours and plugged in, that the result of a run depends on.

    Args:
        specification: The run.
        plug_ins: Python objects behind controller names that no other door knows.
    """
    door = (plug_ins or {}).get(specification.controller, specification.controller)
    robot = cached_robot(specification.robot, specification.tool)
    materials = {load.material for _, load in specification.schedule.entries} - {"none"}
    outside = (
        discovery.source_digest("controllers", door),
        discovery.source_digest("trajectories", specification.trajectory),
        discovery.source_digest("knowledge", specification.knowledge),
        discovery.source_digest("plants", specification.plant),
        *(discovery.source_digest("loads", material) for material in sorted(materials)),
        *filter(None, (discovery.source_digest("metrics", name) for name in discovery.names("metrics"))),
    )
    arm = (robot.urdf, repr(robot.home.tolist()), repr(robot.rotor_inertia.tolist()), repr(dict(robot.tiers)))
    body = (repr(robot.container), repr(robot.gripper_mass))
    own = "" if specification.controller in (plug_ins or {}) else specification.controller
    rooms = (*SHARED_ROOMS, *_room_of("controllers", own), *_room_of("knowledge", specification.knowledge))
    rooms = (*rooms, *(STUDY_ROOMS if specification.study else ()))
    outside = (*outside, *_files_in(specification.settings.values()))
    parts = (*(room_digest(room) for room in rooms), *library_versions().values(), *outside, *arm, *body)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def library_versions() -> dict[str, str]:
    """Return the versions of the libraries that enter results, ``"missing"`` where one is not installed."""
    return {name: _version(name) for name in LIBRARIES}


@cache
def room_digest(room: str) -> str:
    """Return the SHA-256 of the files of a room that can change a result; benchmark files only choose runs.

    Args:
        room: Name of the room, or of a module, below the package, dots for subpackages.
    """
    specification = importlib.util.find_spec(f"{PACKAGE}.{room}")
    folders = specification.submodule_search_locations if specification is not None else None
    digest = hashlib.sha256()
    if specification is not None and folders is None and specification.origin:
        digest.update(Path(specification.origin).read_bytes())
    for folder in folders or ():
        for file in sorted(_sources(Path(folder))):
            digest.update(file.relative_to(folder).as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _sources(folder: Path) -> Iterator[Path]:
    for file in folder.rglob("*"):
        inside = file.relative_to(folder).parts
        if file.is_file() and "__pycache__" not in inside and "benchmarks" not in inside:
            yield file


def _files_in(values: Iterable[object]) -> Iterator[str]:
    """Yield the SHA-256 of every file that a setting names: trained weights, for example."""
    for value in values:
        if isinstance(value, str) and value and Path(value).is_file():
            yield hashlib.sha256(Path(value).read_bytes()).hexdigest()


def _room_of(kind: str, name: str) -> tuple[str, ...]:
    """Return the room of a controller or knowledge provider that this package registers itself, nothing for others."""
    point = discovery.registered(kind).get(name)
    module = point.value.split(":")[0].split(".") if point is not None else []
    return (module[1],) if module[:1] == [PACKAGE] else ()


@cache
def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"
