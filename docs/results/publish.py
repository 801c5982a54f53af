"""Publish a report beside this file: a shortened summary, the claims and the precision table.

    python docs/results/publish.py REPORT_FOLDER

The pages are made of the shortened summary alone, so that they say what the published figures say.
"""

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

METRICS = (
    "run.tcp_position_error_mean",
    "run.tcp_orientation_error_mean",
    "run.joint_error_mean",
    "run.tcp_position_error_last_lap",
    "run.time_lag",
    "run.contour_error_mean",
    "run.torque_rate_rms",
)
FIGURES = ("mean", "runs", "failures", "by_trajectory", "by_mass")
WORLD = (
    *("facts", "runs", "reference", "ranking", "sentences", "comparisons", "motion_sets", "materials"),
    *("adaptation", "resilience", "modules", "efficiency"),
)
SETS = {"paper": "T", "further": "M"}
"""First letter of the trajectories of each set of motions."""

CLAIMS_HEAD = """\
# The paper's claims, judged

Ratios are CBMC-V3 over the factory preset; below 1 its error is the smaller. "Proxy": the paper's rival is a real
product, ours an impedance law after its documentation. Rules and words: [statistics](../statistics.md). Made from
`summary.json` beside this page by `publish.py`.

| claim | printed | measured (95 % interval) | verdict | why not higher |
| --- | --- | --- | --- | --- |
"""

PRECISION_HEAD = """\
# Precision of every controller

Mean position error, and its ratio to `{reference}`: geometric mean over the motions of the set with the 95 %
interval over motions. A mean gives each motion the same weight, whatever loads the controller ran there; a failed run
counts with the metric's `fail_value`. Made from `summary.json` beside this page by `publish.py`.
"""

PRECISION_COLUMNS = """
| controller / knowledge | T1 to T8 [mm] | ratio | M1 to M16 [mm] | ratio | failed of runs |
| --- | --- | --- | --- | --- | --- |
"""


def shortened(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is published of a report's ``summary.json``; of what was published already, the same again."""
    kept: dict[str, Any] = _rounded(_kept(summary))
    return kept


def _kept(summary: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "schema": summary["schema"],
        "campaigns": [_campaign(campaign) for campaign in summary["campaigns"]],
        "claims": summary["claims"],
        "worlds": [_world(world) for world in summary["worlds"]],
    }


def _rounded(value: Any) -> Any:
    """Return a value with every number at six significant digits: nobody reads more, and differences stay readable."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, Mapping):
        return {name: _rounded(part) for name, part in value.items()}
    return [_rounded(part) for part in value] if isinstance(value, list) else value


def _campaign(campaign: Mapping[str, Any]) -> dict[str, Any]:
    """Return a campaign without its gate, and with a command that names no folder of the machine it ran on."""
    command = re.sub(r"(--out[ =])(\S+)", lambda found: f"{found[1]}results/{Path(found[2]).name}", campaign["command"])
    return {name: value for name, value in campaign.items() if name != "gate"} | {"command": command}


def _world(world: Mapping[str, Any]) -> dict[str, Any]:
    controllers = {
        label: {"metrics": {name: _figures(own["metrics"][name]) for name in METRICS if name in own["metrics"]}}
        for label, own in world["controllers"].items()
    }
    return {name: world[name] for name in WORLD if name in world} | {"controllers": controllers}


def _figures(metric: Mapping[str, Any]) -> dict[str, Any]:
    return {name: metric[name] for name in FIGURES}


def claims_page(summary: Mapping[str, Any]) -> str:
    """Return the page of the paper's claims, one row each."""
    return CLAIMS_HEAD + "".join(_claim_row(claim) for claim in summary["claims"])


def _claim_row(claim: Mapping[str, Any]) -> str:
    verdict = claim["verdict"].replace(", against our approximation of the factory controller", " (proxy)")
    cells = (f"{claim['id']} {claim['claim']}", _printed(claim), _measured(claim), verdict, claim["reason"])
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def _printed(claim: Mapping[str, Any]) -> str:
    return "" if claim["printed"] is None else f"{claim['printed']:g} {claim['printed_unit']}".strip()


def _measured(claim: Mapping[str, Any]) -> str:
    if claim["measured"] is None:
        return ""
    factor, unit = _readable(claim["measured"], claim["unit"])
    ends = [end for end in claim["interval"] or () if end is not None]
    interval = f" ({ends[0] * factor:.3g} to {ends[1] * factor:.3g})" if len(ends) == 2 else ""
    return f"{claim['measured'] * factor:.3g}{interval} {unit}".strip()


def _readable(value: float, unit: str) -> tuple[float, str]:
    """Return the factor and the name of the unit that a reader expects of a robot's errors."""
    if unit == "ratio":
        return 1.0, ""
    if unit == "1":
        return 1e2, "%"
    length = unit == "m" or unit.startswith("m/")
    if length or unit.startswith("rad") or (unit == "s" and abs(value) < 0.1):
        return 1e3, f"m{unit}"
    return 1.0, unit


def precision_page(summary: Mapping[str, Any]) -> str:
    """Return the page of the first world's position errors, without and with granted knowledge of the load."""
    world = summary["worlds"][0]
    rows = {label: _precision_row(world, label) for label in sorted(world["controllers"], key=_place(world))}
    unaided = "".join(row for label, row in rows.items() if label.endswith(" / none"))
    aided = "".join(row for label, row in rows.items() if not label.endswith(" / none"))
    head = PRECISION_HEAD.format(reference=world["reference"])
    return (
        f"{head}\n## Arm and gripper known, the load not\n{PRECISION_COLUMNS}{unaided}"
        f"\n## With an estimate of the load, or the true load\n{PRECISION_COLUMNS}{aided}"
    )


def _place(world: Mapping[str, Any]) -> Any:
    """Return the order of the rows: by the error on the paper's motions, those that did not run them last."""
    return lambda label: (_set_mean(world, label, "paper") or float("inf"), label)


def _precision_row(world: Mapping[str, Any], label: str) -> str:
    own = world["controllers"][label]["metrics"][METRICS[0]]
    cells = [f"`{label}`"]
    for name in SETS:
        mean = _set_mean(world, label, name)
        cells += ["" if mean is None else f"{mean * 1e3:.2f}", _ratio(world, label, name)]
    return "| " + " | ".join([*cells, f"{own['failures']} of {own['runs']}"]) + " |\n"


def _set_mean(world: Mapping[str, Any], label: str, motions: str) -> float | None:
    """Return the mean over a set's trajectories [m]; None if the controller ran none of them."""
    errors = world["controllers"][label]["metrics"][METRICS[0]]["by_trajectory"]
    own = [error for trajectory, error in errors.items() if trajectory.startswith(SETS[motions])]
    return sum(own) / len(own) if own else None


def _ratio(world: Mapping[str, Any], label: str, motions: str) -> str:
    if _set_mean(world, label, motions) is None:
        return ""
    if label == world["reference"]:
        return "1 (the reference)"
    # A world of one set of motions is not split: all of its comparisons are on that set.
    for pair in world["motion_sets"].get(motions, world["comparisons"]):
        if pair["controller"] == label and f"run.{pair['metric']}" == METRICS[0] and pair["gmr"] is not None:
            interval = pair["interval_new_motions"]
            low, high = (interval or {}).get("low"), (interval or {}).get("high")
            known = low is not None and high is not None
            return _two_figures(pair["gmr"]) + (f" ({_two_figures(low)} to {_two_figures(high)})" if known else "")
    return ""


def _two_figures(ratio: float) -> str:
    return f"{ratio:.2f}" if ratio >= 1.0 else f"{ratio:#.2g}"


def publish(report: Path, folder: Path) -> None:
    """Write the published files of a report.

    Args:
        report: Folder of the report, with its ``summary.json``.
        folder: Where ``summary.json``, ``claims.md`` and ``precision.md`` are written.
    """
    summary = shortened(json.loads((report / "summary.json").read_text(encoding="utf-8")))
    text = json.dumps(summary, sort_keys=True, indent=0, allow_nan=False, ensure_ascii=False) + "\n"
    for name, content in {
        "summary.json": text,
        "claims.md": claims_page(summary),
        "precision.md": precision_page(summary),
    }.items():
        (folder / name).write_text(content, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2 or not (Path(sys.argv[1]) / "summary.json").is_file():
        sys.exit("usage: python docs/results/publish.py REPORT_FOLDER, a folder with the summary.json of a report")
    publish(Path(sys.argv[1]), Path(__file__).parent)
