"""What one run is, as data: frozen, canonical JSON, addressed by its hash."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ..controllers import InvalidInput, UnknownName
from .latency import Latency, check_latency
from .loads import LoadSchedule, Payload
from .margins import HOLD, LOOP_RESPONSE, STUDIES
from .perturbation import NOMINAL, Perturbation

SCHEMA = 1

IDEAL = "ideal"
"""The tier that never draws anything."""

FRESH, CARRIED = "fresh", "carried"
PROTOCOLS = (FRESH, CARRIED)
"""``fresh``: every run starts anew. ``carried``: repetitions follow one another on one controller that learns on."""


@dataclass(frozen=True, kw_only=True)
class RunSpecification:
    """One controller on one motion with one load history.

    Attributes:
        controller: Name or door of the controller.
        settings: Its keyword arguments, JSON-serialisable.
        knowledge: Name of the knowledge level.
        trajectory: Name or door of the trajectory.
        schedule: The load history.
        twins: Whether the same run with other load histories belongs to it, see :func:`twin_schedules`.
        robot: Name or file of the robot.
        tool: Name of the tool point, empty for the robot's first.
        plant: Name of the plant.
        tier: Name of the tier.
        tier_constants: Constants of the tier in place of the robot's own, see :class:`~.tiers.TierTable`.
        laps: Whole laps after the lead-in.
        lead_in: Duration of the start from rest [s].
        latency: Ticks by which every command is late, before the limiter, or ``"measured"``: each by its own call.
        tare: Whether the force sensor is zeroed before the run, with the gripper alone.
        campaign: Seed of the campaign.
        repetition: Number of the repetition, from 0.
        protocol: ``"fresh"`` or ``"carried"``, see :data:`PROTOCOLS`.
        repetitions: Length of the chain of repetitions of ``carried``, 1 in ``fresh``.
        perturbation: What is wrong with the world that nobody is told.
        study: What is measured by many runs in place of this one: a margin or the loop responses, one of
            :data:`~.margins.STUDIES`; empty for a run.
        draws: Whether every repetition draws an arm, a load and a start of its own, see :mod:`~.draws`.
    """

    controller: str
    trajectory: str
    schedule: LoadSchedule
    robot: str
    plant: str
    tier: str
    settings: Mapping[str, object] = field(default_factory=dict)
    knowledge: str = "none"
    twins: bool = False
    tool: str = ""
    laps: int = 3
    lead_in: float = 1.0
    latency: Latency = 0
    tare: bool = False
    campaign: int = 1
    repetition: int = 0
    protocol: str = FRESH
    repetitions: int = 1
    perturbation: Perturbation = NOMINAL
    study: str = ""
    draws: bool = False
    tier_constants: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check what needs neither robot nor plug-in."""
        for name, value, least in (
            ("laps", self.laps, 1),
            ("repetition", self.repetition, 0),
            ("repetitions", self.repetitions, 1),
        ):
            if value < least:
                raise InvalidInput(f"{name} = {value}", "run", f"at least {least}")
        if not 0.0 <= self.lead_in < 60.0:
            raise InvalidInput(f"lead_in = {self.lead_in:g} s", "run", "between 0 and 60 s")
        check_latency(self.latency, where="run")
        if self.draws and self.tier == IDEAL:
            valid = "it is the nominal arm with exact sensors; choose another tier or draws = false"
            raise InvalidInput("draws = true in tier 'ideal'", "run", valid)
        self._check_protocol()
        self._check_study()

    def _check_protocol(self) -> None:
        """Check that a chain is a chain: it starts at repetition 0 and has no twins."""
        if self.protocol not in PROTOCOLS:
            raise InvalidInput(f"protocol = {self.protocol!r}", "run", f"one of {', '.join(PROTOCOLS)}")
        if self.protocol == FRESH and self.repetitions > 1:
            raise InvalidInput(f"repetitions = {self.repetitions} in one run", "run", "only in protocol 'carried'")
        if self.protocol == CARRIED and self.repetition:
            raise InvalidInput(f"repetition = {self.repetition}", "run", "a chain of protocol 'carried' starts at 0")
        if self.protocol == CARRIED and self.twins:
            # A twin has to start from what the run had learnt, but in a chain of its own it learns something else.
            raise InvalidInput("twins in protocol 'carried'", "run", "judge events in protocol 'fresh'")

    def _check_study(self) -> None:
        """Check that a study is known and made of single runs; loops are measured at rest."""
        if not self.study:
            return
        if self.study not in STUDIES:
            raise UnknownName("study", self.study, STUDIES)
        if self.twins or self.protocol == CARRIED:
            raise InvalidInput(f"study {self.study!r} with twins or carried repetitions", "run", "give it a run table")
        if self.study == LOOP_RESPONSE and (self.trajectory != HOLD or self.schedule.events or self.laps < 3):
            came = f"study {self.study!r} on {self.trajectory!r}"
            raise InvalidInput(came, "run", f"it needs the motion {HOLD!r}, a constant load and at least 3 laps")

    def links(self) -> tuple["RunSpecification", ...]:
        """Return the repetitions that this run consists of, each as ``fresh`` would have it and with its draws."""
        if self.protocol == FRESH:
            return (self,)
        return tuple(
            replace(self, protocol=FRESH, repetitions=1, repetition=repetition)
            for repetition in range(self.repetitions)
        )

    @property
    def label(self) -> str:
        """The controller as tables call it: what follows the colon of a door, then its knowledge level."""
        return f"{self.controller.rpartition(':')[2]} / {self.knowledge}"

    def as_json(self) -> str:
        """Return the canonical text: sorted keys, shortest floats that read back to the same bits."""
        table: dict[str, object] = {
            "schema": SCHEMA,
            "controller": self.controller,
            "settings": dict(self.settings),
            "knowledge": self.knowledge,
            "trajectory": self.trajectory,
            "schedule": [[time, load.mass, load.material] for time, load in self.schedule.entries],
            "twins": self.twins,
            "robot": self.robot,
            "tool": self.tool,
            "plant": self.plant,
            "tier": self.tier,
            "laps": self.laps,
            "lead_in": self.lead_in,
            "latency": self.latency,
            "campaign": self.campaign,
            "repetition": self.repetition,
            "protocol": self.protocol,
            "repetitions": self.repetitions,
        }
        # Written only where they say something: an ordinary run keeps its text, and with it its address.
        if self.tier_constants:
            table["tier_constants"] = dict(self.tier_constants)
        if self.tare:
            table["tare"] = True
        if self.perturbation != NOMINAL:
            table["perturbation"] = self.perturbation.as_table()
        if self.study:
            table["study"] = self.study
        if self.draws:
            table["draws"] = True
        return canonical_json(table)

    @classmethod
    def from_json(cls, text: str) -> "RunSpecification":
        """Return the specification of a canonical text."""
        table = json.loads(text)
        del table["schema"]
        entries = tuple((time, Payload(mass=mass, material=material)) for time, mass, material in table.pop("schedule"))
        perturbation = Perturbation(**table.pop("perturbation", {}))
        return cls(schedule=LoadSchedule(entries=entries), perturbation=perturbation, **table)

    def address(self, digest: str) -> str:
        """Return the SHA-256 of the specification together with the digest of code and data that it uses."""
        return hashlib.sha256(f"{self.as_json()}\n{digest}".encode()).hexdigest()


def canonical_json(value: object) -> str:
    """Return JSON with sorted keys, no spaces and no NaN.

    Raises:
        InvalidInput: If a value is not JSON-serialisable.
    """
    try:
        return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    except (TypeError, ValueError) as cause:
        raise InvalidInput(f"not JSON-serialisable ({cause})", "run", "settings are plain values") from cause


def twin_schedules(schedule: LoadSchedule) -> dict[str, LoadSchedule]:
    """Return the load histories that an event is judged against, by name.

    For each event the old load that stays, and the new load from the start; equal histories appear once.

    Args:
        schedule: The history with its events.
    """
    found: dict[LoadSchedule, str] = {}
    for event in range(1, len(schedule.entries)):
        stays = LoadSchedule(entries=schedule.entries[:event])
        name = f"{_load_name(stays.entries[-1][1])} stays" if event > 1 else _constant_name(stays)
        if name in found.values():
            name += f" from {stays.entries[-1][0]:g} s"
        found.setdefault(stays, name)
        constant = LoadSchedule.constant(schedule.entries[event][1])
        found.setdefault(constant, _constant_name(constant))
    return {name: history for history, name in found.items()}


def _constant_name(schedule: LoadSchedule) -> str:
    return f"constant {_load_name(schedule.entries[0][1])}"


def _load_name(load: Payload) -> str:
    return f"{load.mass:g} kg" if load.material == "none" else f"{load.mass:g} kg {load.material}"
