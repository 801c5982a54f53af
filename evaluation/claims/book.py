"""The claims of the paper as data: what each says, what measures it here, and the rule that judges it."""

import tomllib
from functools import cache
from importlib.resources import files
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict

Rule = Literal[
    "ratio", "range_ratio", "interaction", "all_cells", "slope_sign", "time", "count", "correlation", "level",
    "agreement", "profile", "literature", "none",
]  # fmt: skip
Group = Literal["precision", "adaptation", "resilience", "module", "compute", "energy", "overview"]
Axis = Literal["mass", "material", "group", "metric", "a", "b", "joint"]


def _as_tuple(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


Names = Annotated[tuple[str, ...], BeforeValidator(_as_tuple)]
Numbers = Annotated[tuple[float, ...], BeforeValidator(_as_tuple)]
Axes = Annotated[tuple[Axis, ...], BeforeValidator(_as_tuple)]


class Record(BaseModel):
    """A table of the file: frozen, and no key that nobody reads."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class RunSet(Record):
    """Runs that claims are judged on.

    Attributes:
        id: Its name.
        title: What it holds.
        benchmarks: Benchmarks that ship and run it, or part of it; empty if none does.
        tier: Tier of its runs.
        laps: Their laps.
        lead_in: Their lead-in [s].
        history: Their load history in words; empty for constant loads.
        trajectories: Their trajectories.
        masses: Their loads [kg].
        materials: Contents of every load but the first, which has none.
    """

    id: str
    title: str
    benchmarks: Names = ()
    tier: str = "actuated"
    laps: int = 0
    lead_in: float = 1.0
    history: str = ""
    trajectories: Names = ()
    masses: Numbers = ()
    materials: Names = ()


class Claim(Record):
    """One statement that can be checked; a family of one, fixed before any run.

    Attributes:
        id: ``C`` and a number.
        group: Part of the page.
        says: The statement in our words.
        place: Where the paper makes it.
        printed: The printed number; None if there is none.
        unit: Its unit: ``%`` is a reduction of the ratio of A to B.
        metrics: What is read from each run: ids of metrics, or of :data:`.readings.READINGS`.
        runs: Id of the set of runs.
        window: Window of the metrics.
        a: Controllers that the claim is about, as tables label them.
        b: What they are compared with, the same way.
        a_is: Material or window of side A, where one controller is compared with itself.
        b_is: The same of side B.
        material: Content that the claim is about; loads without content belong to every material.
        only: Group of trajectories that the claim is about.
        higher: Whether A is claimed to be larger, a slope to be rising.
        rule: How it is judged.
        cells: What makes a cell of rule ``all_cells``.
        of_range: Whether the range over trajectories is compared and not the mean.
        joint: Joint of rule ``correlation``, from 1.
        low: Lower limit of rule ``level``.
        high: Upper limit of rule ``level``.
        band: Tolerance around the printed correlation, or around ``at`` [kg].
        at: Load at which the error of each controller of A is claimed to be smallest [kg].
        nulls: Controllers without modules, which should not show the count.
        claims: Claims whose verdicts rule ``agreement`` compares.
        parts: Claims of which rule ``profile`` lists the verdicts.
        testable: ``proxy`` judges a stand-in, and every sentence says so.
        why: What stands in, or why it cannot be tested.
        see: Inconsistencies of the paper that bear on it.
    """

    id: str
    group: Group
    says: str
    place: str
    printed: float | None = None
    unit: str = ""
    metrics: Names = ()
    runs: str = ""
    window: str = "run"
    a: Names = ()
    b: Names = ()
    a_is: str = ""
    b_is: str = ""
    material: str = ""
    only: str = ""
    higher: bool = False
    rule: Rule
    cells: Axes = ()
    of_range: bool = False
    joint: int = 0
    low: float = float("-inf")
    high: float = float("inf")
    band: float = 0.0
    at: Numbers = ()
    nulls: Names = ()
    claims: Names = ()
    parts: Annotated[tuple["Claim", ...], BeforeValidator(_as_tuple)] = ()
    testable: Literal["yes", "partly", "proxy", "no"] = "yes"
    why: str = ""
    see: Names = ()


class Inconsistency(Record):
    """A contradiction within the paper.

    Attributes:
        id: ``I`` and a number.
        place: Where it stands.
        says: What is printed.
        evidence: Why it cannot be; empty if it is plain.
        handling: What this project does about it.
    """

    id: str
    place: str
    says: str
    evidence: str = ""
    handling: str


class Book(Record):
    """All claims, the sets of runs that they are judged on, and the paper's inconsistencies."""

    version: int
    set: Annotated[tuple[RunSet, ...], BeforeValidator(_as_tuple)]
    claim: Annotated[tuple[Claim, ...], BeforeValidator(_as_tuple)]
    inconsistency: Annotated[tuple[Inconsistency, ...], BeforeValidator(_as_tuple)]

    def set_of(self, claim: Claim) -> RunSet | None:
        """Return the set of runs of a claim; None if it has none."""
        return next((found for found in self.set if found.id == claim.runs), None)


@cache
def read_book() -> Book:
    """Return the claims that ship."""
    text = (files(f"{__package__.rpartition('.')[0]}") / "data" / "claims.toml").read_text(encoding="utf-8")
    return Book.model_validate(tomllib.loads(text))
