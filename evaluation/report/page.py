"""The page: findings in, one HTML text out."""

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from . import (
    adaptation_tables,
    drawing,
    draws,
    fairness,
    feature_tables,
    headline,
    material_tables,
    motion_set_tables,
    pairs,
    records,
    run_tables,
    split_tables,
)
from .charts import Chart
from .claims import ClaimsPanel
from .figures import Figure, ratio_figure, trajectory_figure
from .findings import COMPARED, HEADLINES, Findings
from .limitations import limitations
from .panels import Panels
from .paths import PathDrawing, PathsPanel
from .sensitivity import sensitivity_of
from .sentences import (
    common_sentence,
    facts_in_words,
    failure_sentence,
    lead_sentences,
    machine_sentence,
    unranked_sentence,
)
from .table import Table
from .table_files import FORMATS, stem, tables_in
from .worlds import told_apart

SCRIPTS = ("base.js", "page.js", "tables.js", "plots.js", "arm.js", "replay.js", "player.js", "panel.js")
"""The parts of the page's script, in their order."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """One world as the template wants it.

    Attributes:
        id: Prefix of its fragments.
        title: What tells it from the other worlds; empty if there is only one.
        failures: Sentence about failures, and whether there are any.
        leads: Sentences about each headline metric.
        common: Sentence about the cells that the ranking is over, empty if over all.
        unranked: Sentence about controllers that cannot come first.
        machine: Sentence about the machine that the figures belong to, empty if to none.
        facts: What was compared.
        doubles: Rows left out, see :class:`World`.
        headline: The table of all controllers.
        ratios: Figures of ratios.
        dots: Figures of errors by trajectory, each with its table.
        masses: Tables of errors by mass.
        materials: Tables of what one content changes against another.
        shape: Table of shape ranges.
        laps: Tables of errors by lap.
        adaptation: Tables of what errors depend on; empty without a grid.
        features: Tables of lag, ISO-style criteria, velocity, smoothness, and metrics of plug-ins.
        motion_sets: Tables of old and new motions apart; empty unless both ran.
        failed: Table of failed and refused runs.
        knowledge: Table of knowledge levels.
        tuning: Table of tuning budgets.
        ledger: Table of settings.
        comparisons: Tables of comparisons, those of the headline metrics first.
        runs: Label and runs of each controller.
        twins: Table of twins.
        draws: What the repetitions drew; no rows on the nominal plant.
        drawn: Sentence about it.
        panels: Load events, modules and charts by lap.
    """

    id: str
    title: str
    failures: tuple[str, bool]
    leads: Sequence[Sequence[str]]
    common: str
    unranked: str
    machine: str
    facts: Sequence[tuple[str, str]]
    doubles: int
    headline: Table
    ratios: Sequence[Figure]
    dots: Sequence[tuple[Figure, Table]]
    masses: Sequence[Table]
    materials: Sequence[Table]
    shape: Table
    laps: Sequence[Table]
    adaptation: Sequence[Table]
    features: Sequence[Table]
    motion_sets: Sequence[Table]
    failed: Table
    knowledge: Table
    tuning: Table
    ledger: Table
    comparisons: Sequence[Table]
    runs: Sequence[tuple[str, Table]]
    twins: Table
    draws: Table
    drawn: str
    panels: Panels


def render(
    findings: Sequence[Findings],
    panels: Sequence[Panels],
    campaigns: Sequence[Mapping[str, object]],
    claims: ClaimsPanel | None,
    conformance: Table,
    robots: Mapping[str, object],
) -> tuple[str, dict[str, str], list[Table]]:
    """Return the page, its figures and its tables.

    Args:
        findings: Findings of each world.
        panels: What the section of each world has besides.
        campaigns: Records of the campaigns, oldest first.
        claims: Verdicts on the paper's claims; None if no run is about any.
        conformance: Whether the controllers keep the contract; without rows if nobody checked.
        robots: Skeletons of the arms that the replay draws, see :func:`~.run_files.robot_key`.

    Returns:
        One HTML text that needs nothing beside it, the texts of the figures' files by name, and every table with rows.
    """
    environment = _environment()
    worlds = [found.world for found in findings]
    title, description = _title(campaigns)
    sensitivity = sensitivity_of(findings)
    sections = [
        _section(found, extra, (sensitivity and sensitivity.title_of(found)) or told_apart(found.world, worlds))
        for found, extra in zip(findings, panels, strict=True)
    ]
    shown = [extra.metrics for extra in panels] + ([claims.metrics] if claims else [])
    shown += [feature_tables.shown_metrics(found) for found in findings]
    definitions = records.definition_table(dict.fromkeys(name for names in shown for name in names))
    recorded = [_campaign(number, record) for number, record in enumerate(campaigns, start=1)]
    order = sensitivity.table if sensitivity else None
    tables = tables_in([claims, order, sections, conformance, definitions, [record["gate"] for record in recorded]])
    page = environment.get_template("page.html").render(
        title=title,
        description=description,
        sections=sections,
        claims=claims,
        sensitivity=sensitivity,
        conformance=conformance,
        limitations=limitations(findings, panels),
        definitions=definitions,
        campaigns=recorded,
        tables=[(stem(table), table.caption) for table in tables],
        formats=FORMATS,
        robots=Markup(json.dumps(robots, sort_keys=True, separators=(",", ":")).replace("<", "\\u003c")),
        **_script(environment),
    )
    return page, _figure_files(environment, sections), tables


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("torquebench.evaluation.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )

    def draw(chart: Chart) -> Markup:
        return Markup(drawing.draw(chart))

    def swatch(style: int, *, plain: bool) -> Markup:
        return Markup(drawing.swatch(style, plain=plain))

    def way(panel: PathsPanel, drawing: PathDrawing) -> Markup:
        return Markup(panel.draw(drawing))

    environment.globals.update(draw=draw, swatch=swatch, way=way)
    return environment


def _script(environment: Environment) -> dict[str, Markup]:
    """Return the page's script and its hash: the policy lets no other inline script run."""
    loader = environment.loader
    assert loader is not None
    text = "\n".join(loader.get_source(environment, name)[0] for name in SCRIPTS)
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
    return {"script": Markup(text), "script_hash": Markup(f"sha256-{digest}")}


def _figure_files(environment: Environment, sections: Sequence[Section]) -> dict[str, str]:
    """Return the file of each figure of the page by its name."""
    macro = environment.get_template("macros.html").module.drawing  # type: ignore[attr-defined]
    files = {}
    for section in sections:
        timed = [section.panels.timing.figure] if section.panels.timing is not None else []
        for figure in (*section.ratios, *(figure for figure, _ in section.dots), *timed):
            files[f"{figure.id}.svg"] = drawing.wrap_file(str(macro(figure)), figure.title, figure.axis, figure.height)
        for chart in section.panels.charts:
            files[f"{chart.id}.svg"] = drawing.draw_file(chart)
    return files


def _section(found: Findings, panels: Panels, title: str) -> Section:
    world = found.world
    dots = [(trajectory_figure(found, metric), split_tables.trajectory_table(found, metric)) for metric in HEADLINES]
    ratios = [ratio_figure(found, metric) for metric in HEADLINES]
    laps = [split_tables.lap_table(found, metric) for metric, means in found.by_lap.items() if means]
    return Section(
        id=world.id,
        title=title,
        failures=(failure_sentence(found), any(run.row.status == "failed" for run in world.runs)),
        leads=[lead_sentences(found, lead) for lead in found.leads],
        common=common_sentence(found),
        unranked=unranked_sentence(found),
        machine=machine_sentence(found),
        facts=facts_in_words(found),
        doubles=world.doubles,
        headline=headline.headline_table(found),
        ratios=[figure for figure in ratios if figure is not None],
        dots=[(figure, table) for figure, table in dots if figure is not None],
        masses=[split_tables.mass_table(found, metric) for metric in HEADLINES],
        materials=material_tables.material_tables(found),
        shape=split_tables.shape_table(found),
        laps=laps,
        adaptation=adaptation_tables.adaptation_tables(found),
        features=feature_tables.feature_tables(found),
        motion_sets=[motion_set_tables.motion_set_table(found, metric) for metric in HEADLINES if found.by_set],
        failed=run_tables.failure_table(found),
        knowledge=fairness.knowledge_table(found),
        tuning=fairness.tuning_table(found),
        ledger=fairness.ledger_table(found),
        comparisons=[pairs.comparison_table(found, metric) for metric in COMPARED if found.comparisons[metric]],
        runs=[(label, run_tables.run_table(found, label)) for label in found.order],
        twins=run_tables.twin_table(found),
        draws=draws.draw_table(found),
        drawn=draws.draw_sentence(found),
        panels=panels,
    )


def _title(campaigns: Sequence[Mapping[str, object]]) -> tuple[str, str]:
    """Return the newest benchmark's title and description."""
    for campaign in reversed(campaigns):
        benchmark = campaign.get("benchmark")
        if isinstance(benchmark, Mapping):
            title = benchmark.get("title") or benchmark.get("name")
            if title:
                return str(title), str(benchmark.get("description") or "")
    return "Joint-torque controllers compared", ""


def _campaign(number: int, record: Mapping[str, object]) -> dict[str, object]:
    """Return a campaign's record as lists of words; what is missing is left out."""
    benchmark, machine = _mapping(record, "benchmark"), _mapping(record, "machine")
    named = {"Benchmark": benchmark.get("name"), "Reference": benchmark.get("reference")}
    plain = {
        name.capitalize(): record.get(name) for name in ("started", "command", "commit", "digest", "seed", "workers")
    }
    host = {f"Machine: {name}": value for name, value in machine.items()}
    facts = [(name, str(value)) for name, value in {**named, **plain, **host}.items() if value not in (None, "")]
    notes = record.get("notes")
    versions = [(str(name), str(version)) for name, version in sorted(_mapping(record, "versions").items())]
    return {
        "number": number,
        "facts": facts,
        "versions": versions,
        "notes": [str(note) for note in notes] if isinstance(notes, list | tuple) else [],
        "gate": records.gate_table(number, record.get("gate")),
    }


def _mapping(record: Mapping[str, object], name: str) -> Mapping[str, object]:
    value = record.get(name)
    return value if isinstance(value, Mapping) else {}
