"""The report for programs: every run and every comparison as CSV, every figure of the page as JSON."""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict

from ..comparison import Comparison
from ..intervals import Interval
from ..metrics import METRICS
from ..summary import Summary
from .adaptation import adaptation_values, compared_rows, grids_of
from .claims import ClaimsPanel, claim_figures
from .draws import drawn_by
from .fairness import ledger_of
from .findings import COMPARED, HEADLINES, SUMMARISED, Findings
from .panel_exports import panel_figures
from .panels import Panels
from .sentences import common_sentence, failure_sentence, lead_sentences, machine_sentence, unranked_sentence
from .worlds import Run

SCHEMA = 1

SPECIFICATION = (
    "trajectory",
    "robot",
    "tool",
    "plant",
    "tier",
    "laps",
    "lead_in",
    "latency",
    "tare",
    "campaign",
    "repetition",
    "twins",
    "study",
    "draws",
)
"""Fields of the specification that stand in runs.csv as they are."""


def runs_csv(findings: Sequence[Findings]) -> str:
    """Return one row for each run, twin and study: specification, status, metrics in stored units, wall times."""
    runs = [(found, run) for found in findings for run in (*found.world.runs, *found.world.twins, *found.world.studies)]
    metrics = _metric_columns([run for _, run in runs])
    timings = sorted({name for _, run in runs for name in run.stored.result.timing})
    drawn = sorted({name for _, run in runs for name in drawn_by(run)})
    header = [
        "world",
        "label",
        "controller",
        "settings",
        "knowledge",
        "group",
        "mass [kg]",
        "material",
        "load",
        *SPECIFICATION,
    ]
    header += ["role", "address", "status", "cause", "reason", "failed_at [s]"]
    header += [f"drawn.{name}" for name in drawn]
    header += [f"{window}.{metric} [{unit}]" for window, metric, unit in metrics]
    header += [f"timing.{name}" for name in timings]
    rows = [
        [
            *_identity(found, run),
            *(json.dumps(drawn_by(run)[name]) if name in drawn_by(run) else "" for name in drawn),
            *(_metric(run, window, metric) for window, metric, _ in metrics),
            *(run.stored.result.timing.get(name, "") for name in timings),
        ]
        for found, run in runs
    ]
    return _csv(header, rows)


def probes_csv(findings: Sequence[Findings]) -> str:
    """Return one row for each run behind a margin; empty without margins."""
    header = ["world", "label", "trajectory", "load", "study", "address", "perturbation", "passed", "status", "cause"]
    rows = [
        [
            found.world.id, run.row.controller, run.row.trajectory, run.load, run.stored.specification.study,
            run.stored.address, json.dumps(probe["perturbation"], sort_keys=True), probe["passed"], probe["status"],
            probe["cause"], probe["reason"], "" if probe["failed_at"] is None else probe["failed_at"],
        ]
        for found in findings
        for run in found.world.studies
        for probe in run.stored.result.provenance.get("probes", ())  # type: ignore[attr-defined]
    ]  # fmt: skip
    return _csv([*header, "reason", "failed_at [s]"], rows) if rows else ""


def comparisons_csv(findings: Sequence[Findings]) -> str:
    """Return one row for each comparison with a reference."""
    rows = [
        {"world": found.world.id, **_flat(_comparison(found, comparison))}
        for found in findings
        for metric in COMPARED
        for comparison in found.comparisons[metric].values()
    ]
    header = list(rows[0]) if rows else ["world", "controller", "reference", "metric", "window"]
    return _csv(header, [[row.get(name, "") for name in header] for row in rows])


def summary_json(
    findings: Sequence[Findings],
    panels: Sequence[Panels],
    campaigns: Sequence[Mapping[str, object]],
    claims: ClaimsPanel | None,
) -> str:
    """Return every figure of the page with unit, window, number of runs, interval and reference."""
    content = {
        "schema": SCHEMA,
        "worlds": [{**_world(found), **panel_figures(extra)} for found, extra in zip(findings, panels, strict=True)],
        "metrics": {
            name: {
                field: getattr(METRICS[name], field)
                for field in ("label", "unit", "better", "family", "source", "version")
            }
            for name in SUMMARISED
        },
        "campaigns": list(campaigns),
        "claims": claim_figures(claims) if claims else [],
    }
    return json.dumps(_finite(content), indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False) + "\n"


def _world(found: Findings) -> dict[str, object]:
    world = found.world
    return {
        "id": world.id,
        "facts": dict(world.facts),
        "reference": world.reference,
        "reference_present": world.has_reference,
        "runs": len(world.runs),
        "twins": len(world.twins),
        "studies": len(world.studies),
        "left_out": world.doubles,
        "sentences": {
            "failures": failure_sentence(found),
            "common": common_sentence(found),
            "not_ranked": unranked_sentence(found),
            "machine": machine_sentence(found),
            **{lead.metric: lead_sentences(found, lead) for lead in found.leads},
        },
        "ranking": {metric: list(found.ranked(metric)) for metric in HEADLINES},
        "controllers": {label: _controller(found, label) for label in found.order},
        "comparisons": [
            _comparison(found, comparison) for metric in COMPARED for comparison in found.comparisons[metric].values()
        ],
        "motion_sets": {
            name: [_comparison(found, comparison) for family in families.values() for comparison in family.values()]
            for name, families in found.by_set.items()
        },
        "adaptation": _adaptation(found),
        "against_next": [_comparison(found, pair) for lead in found.leads if (pair := lead.against_next) is not None],
        "materials": [
            {**asdict(contrast), "ratio": _comparison(found, contrast.ratio)} for contrast in found.materials
        ],
        "failed": [
            {
                "controller": run.row.controller, "trajectory": run.row.trajectory, "load": run.load,
                "repetition": run.row.repetition, "address": run.stored.address, "status": run.row.status,
                "failed_at_s": run.stored.result.failed_at, "cause": run.stored.result.cause,
                "reason": run.stored.result.reason,
            }
            for run in found.failures
        ],
    }  # fmt: skip


def _adaptation(found: Findings) -> dict[str, dict[str, object]]:
    """Return base metric to controller to the metrics of its grid, or why it has none; empty without a grid."""
    rows = compared_rows(found.world.rows)
    grids = {metric: grids_of(rows, found.order, metric) for metric in HEADLINES if rows}
    return {
        metric: {
            label: grid if isinstance(grid, str) else adaptation_values(grid, metric) for label, grid in listed.items()
        }
        for metric, listed in grids.items()
    }


def _controller(found: Findings, label: str) -> dict[str, object]:
    runs = found.runs_of(label)
    first = runs[0].stored.specification
    return {
        "controller": first.controller,
        "knowledge": first.knowledge,
        "settings": dict(first.settings),
        "metrics": {f"{s[label].window}.{metric}": _summary(s[label]) for metric, s in found.summaries.items()},
        "runs_saturated": found.saturated(label),
        "by_lap": {metric: means.get(label) for metric, means in found.by_lap.items()},
        "median_over_runs": {name: found.timing(label, name) for name in ("call_us_median", "real_time_factor")},
        "ledger": [{**entry, "value": values[0] if len(values) == 1 else values} for entry, values in ledger_of(runs)],
    }


def _summary(summary: Summary) -> dict[str, object]:
    table = asdict(summary)
    table["by_mass"] = {f"{mass:g}": mean for mass, mean in summary.by_mass.items()}
    return table


def _comparison(found: Findings, comparison: Comparison) -> dict[str, object]:
    table = asdict(comparison)
    for name in ("without_ratio", "unpaired"):
        table[name] = len(getattr(comparison, name))
    table["failures"] = {"controller": comparison.failures[0], "reference": comparison.failures[1]}
    verdicts = {"verdict_alone": found.verdict_alone(comparison), "verdict_in_family": comparison.verdict}
    return {**table, **verdicts, "headline": comparison.headline, "remarks": list(comparison.remarks)}


def _flat(table: Mapping[str, object]) -> dict[str, object]:
    """Return a table of plain values: intervals as two columns, lists joined."""
    flat: dict[str, object] = {}
    for name, value in table.items():
        if name in ("interval_new_motions", "interval_suite", "suite_bootstrap", "bca"):
            limits = value if isinstance(value, Mapping) else {}
            flat |= {f"{name}.low": limits.get("low", ""), f"{name}.high": limits.get("high", "")}
        elif isinstance(value, Mapping):
            flat |= {f"{name}.{key}": entry for key, entry in value.items()}
        else:
            flat[name] = "; ".join(value) if isinstance(value, list) else "" if value is None else value
    return flat


def _identity(found: Findings, run: Run) -> list[object]:
    stored, row = run.stored, run.row
    specification, result = stored.specification, stored.result
    settings = json.dumps(dict(specification.settings), sort_keys=True)
    described = [found.world.id, row.controller, specification.controller, settings, specification.knowledge, row.group]
    loaded = [row.mass, row.material, run.load, *(getattr(specification, name) for name in SPECIFICATION)]
    failed_at = "" if result.failed_at is None else result.failed_at
    return [*described, *loaded, result.role, stored.address, result.status, result.cause, result.reason, failed_at]


def _metric_columns(runs: Sequence[Run]) -> list[tuple[str, str, str]]:
    """Return window, id and unit of every metric that any run has, in the registry's order."""
    found: dict[tuple[str, str], str] = {}
    for run in runs:
        for window, entries in run.row.metrics.items():
            for metric, entry in entries.items():
                found.setdefault((window, metric), str(entry.get("unit", "")))
    known = {name: place for place, name in enumerate(METRICS)}
    ordered = sorted(found, key=lambda key: (key[0], known.get(key[1], len(known)), key[1]))
    return [(window, metric, found[window, metric]) for window, metric in ordered]


def _metric(run: Run, window: str, metric: str) -> object:
    """Return a value, or the word for why there is none."""
    entry = run.row.metrics.get(window, {}).get(metric)
    if entry is None:
        return ""
    value = entry.get("value")
    return value if isinstance(value, int | float) and math.isfinite(value) else entry.get("status", "undefined")


def _csv(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return stream.getvalue()


def _finite(value: object) -> object:
    """Return a value with what JSON has no word for as null, and keys as text."""
    if isinstance(value, Mapping):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, Interval):
        return _finite(asdict(value))
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
