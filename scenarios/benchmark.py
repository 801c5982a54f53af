"""Benchmark files: which controllers run on which motions with which loads, how often, and against which reference."""

import difflib
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from ..controllers import InvalidInput, UnknownName
from .latency import Latency, check_latency
from .loads import NO_MATERIAL, LoadSchedule, Payload
from .tiers import TierTable
from .validation import Names, Number, Record, read_toml, validate

DEFAULT_TIER = "actuated"


def _records(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


def _latency(value: object) -> Latency:
    try:
        return check_latency(value, where="latency")
    except InvalidInput as problem:
        raise PydanticCustomError("latency", "{valid}", {"valid": problem.valid}) from problem


Count = Annotated[int, Field(ge=1)]
Settings = dict[str, dict[str, object]]
Protocol = Literal["fresh", "carried"]


class LoadTable(Record):
    """A load: everything beyond the flange, gripper included."""

    mass: Number
    material: str = NO_MATERIAL


class EventTable(LoadTable):
    """A load that hangs on the flange from a time on."""

    at: Number


class PerturbationTable(Record):
    """What is wrong with the world, see :class:`~.perturbation.Perturbation`."""

    payload: Number = 0.0
    delay: int = 0
    gain: Number = 1.0
    velocity_noise: Number = 0.0
    friction: Number = 1.0
    offset: Number = 0.0


class Sweep(Record):
    """What a run table may say; what it leaves out, the benchmark says.

    Attributes:
        controllers: Names or doors.
        knowledge: Levels; empty for the standard ones that can differ.
        trajectories: Names or doors.
        loads: Constant loads, each a cell of its own.
        schedule: One load history with events, instead of ``loads``.
        twins: Whether the load histories that events are judged against run too.
        laps: Whole laps after the lead-in.
        repetitions: How often every cell is repeated.
        lead_in: Duration of the start from rest, 0 for an arm at rest under a moving reference [s].
        settings: Controller name to keyword arguments, beside those of the benchmark.
        protocol: ``"fresh"``, or ``"carried"``: the repetitions of a cell follow one another on one controller.
        perturbation: What is wrong with the world that nobody is told.
        studies: Margins and loop responses to measure in place of single runs, see :data:`~.margins.STUDIES`.
        tool: Name of the tool point, empty for the robot's first.
        plant: Name of the plant, empty for PyBullet or, where it has no wheel, Pinocchio.
        tier: Name of the tier.
        tier_constants: Constants of the tier in place of the robot's own.
        draws: Whether every repetition draws an arm, a load and a start of its own; never in tier ``ideal``.
    """

    controllers: Names | None = None
    knowledge: Names | None = None
    trajectories: Names | None = None
    loads: Annotated[tuple[LoadTable, ...], BeforeValidator(_records)] | None = None
    schedule: Annotated[tuple[EventTable, ...], BeforeValidator(_records)] | None = None
    twins: bool | None = None
    laps: Count | None = None
    repetitions: Count | None = None
    lead_in: Number | None = None
    settings: Settings | None = None
    protocol: Protocol | None = None
    perturbation: PerturbationTable | None = None
    studies: Names | None = None
    tool: str | None = None
    plant: str | None = None
    tier: str | None = None
    tier_constants: TierTable | None = None
    draws: bool | None = None


class Benchmark(Sweep):
    """A benchmark file.

    Attributes:
        name: What reports call it.
        version: Version of this form; the file calls it ``schema``.
        title: One line.
        description: What it is for.
        reference: Label of the controller that all others are compared with, for example ``"flexiv_factory / none"``.
        robot: Name or file of the robot.
        latency: Ticks by which every command is late, or ``"measured"``: each by its own call.
        tare: Whether the force sensor is zeroed before every run, with the gripper alone.
        seed: Seed of the campaign.
        run: Run tables; none means one that says nothing. In a file a run table may have ``cases``, tables of the same
            keys: each is a run table of its own, and what it leaves out its run table says.
    """

    name: str
    version: Annotated[int, Field(alias="schema", ge=1, le=1)] = 1
    title: str = ""
    description: str = ""
    reference: str = ""
    robot: str = "rizon4s"
    tool: str = ""
    plant: str = ""
    tier: str = DEFAULT_TIER
    latency: Annotated[Latency, BeforeValidator(_latency)] = 0
    tare: bool = False
    seed: Annotated[int, Field(ge=0)] = 1
    draws: bool = False
    lead_in: Number = 1.0
    settings: Annotated[Settings, Field(default_factory=dict)]
    protocol: Protocol = "fresh"
    run: Annotated[tuple[Sweep, ...], BeforeValidator(_records)] = ()

    def sweeps(self) -> tuple[Sweep, ...]:
        """Return the run tables, each with what the benchmark says where it says nothing itself.

        Raises:
            InvalidInput: If one has no controllers, trajectories or loads, or both loads and a schedule.
            UnknownName: If one has settings for a controller that it does not run.
        """
        return tuple(self._completed(index, sweep) for index, sweep in enumerate(self.run or (Sweep(),)))

    def _completed(self, index: int, sweep: Sweep) -> Sweep:
        own = {name: getattr(sweep, name) for name in Sweep.model_fields if getattr(sweep, name) is not None}
        inherited = {name: getattr(self, name) for name in Sweep.model_fields}
        loaded = "loads" in own or "schedule" in own
        if loaded:
            inherited |= {"loads": None, "schedule": None}
        own["settings"] = {
            name: self.settings.get(name, {}) | (sweep.settings or {}).get(name, {})
            for name in (*self.settings, *(sweep.settings or {}))
        }
        full = Sweep.model_construct(**(inherited | own))
        where = f"benchmark {self.name!r}, run {index + 1}"
        if bool(full.loads) == bool(full.schedule):
            raise InvalidInput(
                "has both loads and a schedule" if full.loads else "has no load", where, "give one of them"
            )
        for name in ("controllers", "trajectories"):
            if not getattr(full, name):
                raise InvalidInput(f"has no {name}", where, f"give {name} = [...]")
        for name in sweep.settings or ():
            if name not in (full.controllers or ()):
                raise UnknownName("controller in settings", name, full.controllers or ())
        return full


def schedules(sweep: Sweep) -> tuple[LoadSchedule, ...]:
    """Return the load histories of a completed run table."""
    if sweep.schedule:
        entries = ((event.at, Payload(mass=event.mass, material=event.material)) for event in sweep.schedule)
        return (LoadSchedule(entries=tuple(entries)),)
    return tuple(LoadSchedule.constant(Payload(mass=load.mass, material=load.material)) for load in sweep.loads or ())


def benchmark_names() -> tuple[str, ...]:
    """Return the names of the benchmarks that ship."""
    folder = files(__package__) / "benchmarks"
    return tuple(sorted(entry.name[:-5] for entry in folder.iterdir() if entry.name.endswith(".toml")))


def load_benchmark(
    name: str, *, overrides: Mapping[str, object] | None = None, changes: Sequence[str] = ()
) -> Benchmark:
    """Read a benchmark.

    Args:
        name: Name of one that ships, or a file that ends in ``.toml``.
        overrides: Keys that replace the file's, in its run tables too; of controllers, run tables that name some keep
            those that are chosen, and whom none names runs as the last table says.
        changes: ``key=value`` texts; dots lead into tables, values are TOML or else plain text.

    Raises:
        UnknownName: If no benchmark has the name.
        InvalidInput: If the file or a change is wrong.
    """
    if name.endswith(".toml"):
        table, where = read_toml(Path(name)), name
    elif name in benchmark_names():
        text = (files(__package__) / "benchmarks" / f"{name}.toml").read_text(encoding="utf-8")
        table, where = tomllib.loads(text), f"benchmark {name!r}"
    else:
        raise UnknownName("benchmark", name, benchmark_names())
    if "run" in table:
        table["run"] = _spread_cases(table["run"], where)
    for key, value in (overrides or {}).items():
        _replace(table, key, value)
    for change in changes:
        key, value = _parse_change(change)
        if "." in key:
            _descend(table, key, value)
        else:
            _replace(table, key, value)
        where = f"{where} with --set {change}"
    return validate(Benchmark, table, where=where)


def _spread_cases(runs: object, where: str) -> object:
    """Return a run table for each case of a run table: what a case leaves out, its run table says.

    Raises:
        InvalidInput: If cases are no list of tables.
    """
    if not isinstance(runs, list) or not all(isinstance(run, dict) for run in runs):
        return runs
    found = []
    for index, run in enumerate(runs):
        shared = {key: value for key, value in run.items() if key != "cases"}
        cases = run.get("cases", [{}])
        if not isinstance(cases, list) or not cases or not all(isinstance(case, dict) for case in cases):
            raise InvalidInput("cases are no list of tables", f"{where}, run {index + 1}", "write [[run.cases]]")
        for case in cases:
            loaded = "loads" in case or "schedule" in case
            kept = {key: value for key, value in shared.items() if not loaded or key not in ("loads", "schedule")}
            found.append(deepcopy(kept | case))
    return found


def _replace(table: dict[str, Any], key: str, value: object) -> None:
    """Set a key of the benchmark and take it out of its run tables."""
    table[key] = value
    if key == "controllers" and isinstance(value, list | tuple):
        _choose(table, value)
        return
    for sweep in table.get("run", ()):
        sweep.pop(key, None)
        if key in ("loads", "schedule"):
            sweep.pop("schedule" if key == "loads" else "loads", None)
    if key in ("loads", "schedule"):
        table.pop("schedule" if key == "loads" else "loads", None)


def _choose(table: dict[str, Any], chosen: Sequence[object]) -> None:
    """Let the chosen controllers run where the run tables name them; whom none names runs as the last table says."""
    sweeps = list(table.get("run", ()))
    naming = [sweep for sweep in sweeps if isinstance(sweep.get("controllers"), list)]
    named = {name for sweep in naming for name in sweep["controllers"]}
    for sweep in naming:
        sweep["controllers"] = [name for name in sweep["controllers"] if name in chosen]
    if sweeps and len(naming) == len(sweeps):
        naming[-1]["controllers"] += [name for name in chosen if name not in named]
    kept = [sweep for sweep in sweeps if sweep.get("controllers") != []]
    if sweeps:
        table["run"] = kept
    for part in (table, *kept):
        if isinstance(part.get("settings"), dict):
            runs = part.get("controllers", chosen)
            part["settings"] = {name: own for name, own in part["settings"].items() if name in runs}


def _descend(table: dict[str, Any], key: str, value: object) -> None:
    """Set a key inside nested tables and take it out of those of the run tables."""
    *path, last = key.split(".")
    for sweep in table.get("run", ()):
        inner: object = sweep
        for part in path:
            inner = inner.get(part) if isinstance(inner, dict) else None
        if isinstance(inner, dict):
            inner.pop(last, None)
    current = table
    for part in path:
        inner = current.setdefault(part, {})
        if not isinstance(inner, dict):
            raise InvalidInput(f"{part!r} is no table", f"--set {key}", "only settings.CONTROLLER.NAME has dots")
        current = inner
    current[last] = value


def _parse_change(change: str) -> tuple[str, object]:
    key, separator, text = change.partition("=")
    if not separator or not key.strip():
        raise InvalidInput(f"{change!r}", "--set", "expected key=value, for example laps=5")
    if key.split(".")[0] not in Benchmark.model_fields and key != "schema":
        nearest = difflib.get_close_matches(key, Benchmark.model_fields, n=1)
        hint = f"did you mean {nearest[0]!r}?" if nearest else f"valid keys: {', '.join(Benchmark.model_fields)}"
        raise InvalidInput(f"unknown key {key!r}", "--set", hint)
    try:
        return key.strip(), tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), text
