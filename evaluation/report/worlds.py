"""Runs of a store, sorted into worlds: only runs of one world may be compared with each other."""

import json
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from ...controllers import discovery
from ...scenarios.store import StoredRun
from ..rows import RunRow
from .numbers import counting

RUN = "run"
"""The role of the runs that enter comparisons; any other role is a twin."""

NOISE_ONLY, PLANT_TOO = "sensor noise", "friction, load, link masses, start and sensor noise"
"""What tells the repetitions of a run apart; runs that drew a plant pair with no run on the nominal one."""

OWN_CONSTANTS = "the robot's own"
"""Tier constants of all runs that change none."""
SPIKING = "cbmc_v3"
"""The controller that the comparison is about."""
CONSTANT = "constant load"
"""Load history of all runs whose load does not change; any other history is a world of its own."""


@dataclass(frozen=True)
class Run:
    """A row of the store as the page calls it.

    Attributes:
        row: The run as comparisons want it; its controller is a label that is unique within the world.
        stored: The row itself.
    """

    row: RunRow
    stored: StoredRun

    @property
    def anchor(self) -> str:
        """Fragment of the run's row on the page; role and repetition tell the rows of one address apart."""
        result = self.stored.result
        role = "" if result.role == RUN else f"-{result.role.replace(' ', '-')}"
        repetition = f"-{result.repetition}" if self.stored.specification.repetitions > 1 else ""
        return f"run-{self.stored.address[:12]}{role}{repetition}"

    @property
    def load(self) -> str:
        """The load history in words."""
        return history_in_words(self.stored)


@dataclass(frozen=True, kw_only=True)
class World:
    """Runs that differ in controller, trajectory, load and repetition only.

    Attributes:
        id: Prefix of its fragments on the page.
        facts: What all of its runs share, by words for people.
        runs: Its runs.
        twins: Runs that exist only to judge an event of another run.
        studies: Margins and loop responses, each made of many runs.
        reference: Label of the declared reference controller, empty if none was declared.
        doubles: Rows left out because another row has the same specification, written by other code.
    """

    id: str
    facts: Mapping[str, str]
    runs: tuple[Run, ...]
    twins: tuple[Run, ...]
    studies: tuple[Run, ...]
    reference: str
    doubles: int

    @cached_property
    def rows(self) -> list[RunRow]:
        """The runs as comparisons want them."""
        return [run.row for run in self.runs]

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Controllers in the order of their names."""
        return tuple(sorted({run.row.controller for run in self.runs}))

    @property
    def has_reference(self) -> bool:
        """Whether the declared reference has runs here."""
        return self.reference in self.labels


def history_in_words(stored: StoredRun) -> str:
    """Return a load history: ``2.5 kg sand``, ``1.5 kg, from 12 s 3.5 kg sand``."""
    parts: list[str] = []
    for time, load in stored.specification.schedule.entries:
        text = f"{load.mass:g} kg" + ("" if load.material == "none" else f" {load.material}")
        parts.append(f"from {time:g} s {text}" if parts else text)
    return ", ".join(parts)


def worlds_of(stored: Sequence[StoredRun], campaigns: Sequence[Mapping[str, object]]) -> tuple[World, ...]:
    """Sort the rows of a store into worlds.

    Args:
        stored: All rows.
        campaigns: Records of the campaigns that wrote them, oldest first; they declare the references.

    Returns:
        The worlds, the one with the most runs first.
    """
    single, doubles = _without_doubles(stored)
    groups: dict[tuple[tuple[str, str], ...], list[StoredRun]] = {}
    for row in single:
        groups.setdefault(_facts(row), []).append(row)
    ordered = sorted(groups.items(), key=lambda item: (-len(item[1]), item[0]))
    doubled = [_facts(row) for row in doubles]
    return tuple(
        _world(f"w{number}", dict(facts), rows, campaigns, doubled.count(facts))
        for number, (facts, rows) in enumerate(ordered, start=1)
    )


def told_apart(world: World, worlds: Sequence[World]) -> str:
    """Return what tells a world from the others, in words; what most of them share goes without saying.

    Args:
        world: One of the worlds.
        worlds: All of them.
    """
    shares = {name: Counter(other.facts[name] for other in worlds) for name in world.facts}
    differing = {name: value for name, value in world.facts.items() if len(shares[name]) > 1}
    unusual = {name: value for name, value in differing.items() if 2 * shares[name][value] <= len(worlds)}
    return ", ".join(f"{name.lower()} {value}" for name, value in (unusual or differing).items())


def _facts(row: StoredRun) -> tuple[tuple[str, str], ...]:
    """Return what runs must share to be comparable."""
    run = row.specification
    return (
        ("Robot", run.robot),
        ("Tool point", run.tool or "the robot's first"),
        ("Plant", run.plant),
        ("Tier", run.tier),
        ("Tier constants", settings_in_words(run.tier_constants) or OWN_CONSTANTS),
        ("Load history", history_in_words(row) if run.schedule.events else CONSTANT),
        ("Laps", str(run.laps)),
        ("Lead-in", f"{run.lead_in:g} s"),
        ("Protocol", run.protocol),
        ("Repetitions draw", PLANT_TOO if run.draws else NOISE_ONLY),
        ("Latency", _latency(row)),
        ("Force sensor", "tared before the run" if run.tare else "not tared"),
        ("Perturbation", run.perturbation.in_words()),
        ("Seed", str(run.campaign)),
    )


def _latency(row: StoredRun) -> str:
    """Return the latency in words; a measured one is a word in the specification, and one machine's own."""
    latency = row.specification.latency
    if isinstance(latency, str):
        return f"{latency} on {row.machine or 'an unknown machine'}"
    return f"{latency} ticks" if latency else "none"


def _world(
    name: str,
    facts: Mapping[str, str],
    stored: Sequence[StoredRun],
    campaigns: Sequence[Mapping[str, object]],
    doubles: int,
) -> World:
    labels, groups = _labels(stored), _groups(stored)
    runs = [Run(_row(row, labels[row.address], groups[row.specification.trajectory]), row) for row in stored]
    runs.sort(key=lambda run: (counting(run.row.trajectory), run.row.key))
    single = [run for run in runs if not run.stored.specification.study]
    world = World(
        id=name,
        facts=facts,
        runs=tuple(run for run in single if run.stored.result.role == RUN),
        twins=tuple(run for run in single if run.stored.result.role != RUN),
        studies=tuple(run for run in runs if run.stored.specification.study),
        reference="",
        doubles=doubles,
    )
    return replace(world, reference=_reference(world.labels, campaigns))


def _row(stored: StoredRun, label: str, group: str) -> RunRow:
    run, first = stored.specification, stored.specification.schedule.entries[0][1]
    return RunRow(
        controller=label,
        trajectory=run.trajectory,
        group=group,
        mass=first.mass,
        material="" if first.material == "none" else first.material,
        repetition=stored.repetition,
        status=stored.result.status,  # type: ignore[arg-type]
        metrics=stored.result.metrics,
    )


def _reference(labels: Iterable[str], campaigns: Sequence[Mapping[str, object]]) -> str:
    """Return the newest declared reference that ran here, else the newest declared."""
    declared = []
    for campaign in reversed(campaigns):
        benchmark = campaign.get("benchmark")
        if isinstance(benchmark, Mapping) and benchmark.get("reference"):
            declared.append(str(benchmark["reference"]))
    known = set(labels)
    return next((label for label in declared if label in known), declared[0] if declared else "")


def _without_doubles(stored: Sequence[StoredRun]) -> tuple[list[StoredRun], list[StoredRun]]:
    """Split off rows that a newer one of the same specification replaces: results of older code, in the same store."""
    newest = {_identity(row): row.address for row in stored}
    kept: list[StoredRun] = []
    doubles: list[StoredRun] = []
    for row in stored:
        is_newest = newest[_identity(row)] == row.address
        (kept if is_newest else doubles).append(row)
    return kept, doubles


def _identity(row: StoredRun) -> tuple[str, str, str]:
    """Return what two rows share if one of them replaces the other."""
    return row.specification.as_json(), row.result.role, row.machine


def _labels(stored: Sequence[StoredRun]) -> dict[str, str]:
    """Return a label for each address; settings are named where one controller runs with several."""
    variants: dict[str, set[tuple[str, str]]] = {}
    for row in stored:
        run = row.specification
        variants.setdefault(run.label, set()).add((run.controller, settings_in_words(run.settings)))
    return {row.address: _label(row, variants[row.specification.label]) for row in stored}


def _label(row: StoredRun, variants: Collection[tuple[str, str]]) -> str:
    """Return the label, with what tells one variant of a controller from the others where there are several."""
    run, doors = row.specification, {door for door, _ in variants}
    parts = [f"from {run.controller}"] if len(doors) > 1 else []
    if len(variants) > len(doors) and run.settings:
        parts.append(settings_in_words(run.settings))
    return f"{run.label} ({', '.join(parts)})" if parts else run.label


def settings_in_words(settings: Mapping[str, object]) -> str:
    """Return settings as a label names them: ``bandwidth=40.0, integral=true``."""
    return ", ".join(f"{name}={json.dumps(value)}" for name, value in sorted(settings.items()))


def _groups(stored: Sequence[StoredRun]) -> dict[str, str]:
    """Return the group of each trajectory: what the runs noted, else what the registered trajectory says."""
    groups = {row.specification.trajectory: "" for row in stored}
    for row in stored:
        noted = row.result.provenance.get("group")
        groups[row.specification.trajectory] = str(noted) if noted else groups[row.specification.trajectory]
    return {name: group or _registered_group(name) for name, group in groups.items()}


def _registered_group(trajectory: str) -> str:
    """Return the group of a registered trajectory; files are not run for a report."""
    if trajectory not in discovery.names("trajectories"):
        return ""
    try:
        path = discovery.load("trajectories", trajectory)()  # type: ignore[operator]
    except Exception:
        # A plug-in that no longer loads costs its group, not the page.
        return ""
    return str(getattr(path, "group", ""))
