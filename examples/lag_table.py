"""How much of a tracking error is lateness: a table for each controller, from the report of a results folder.

torquebench run paper-precision --controllers flexiv_factory,flexiv_full_ff --out results/factory
python examples/lag_table.py results/factory
"""

import csv
import sys
from collections import defaultdict
from pathlib import Path
from statistics import mean

Rows = list[dict[str, str]]
FIGURES = {
    "mm": ("run.tcp_position_error_mean [m]", 1e3),
    "lag ms": ("run.time_lag [s]", 1e3),
    "without the lag mm": ("run.lag_free_error [m]", 1e3),
    "lag's share": ("run.lag_share [1]", 1.0),
    "along mm": ("run.along_track_error_mean [m]", 1e3),
    "across mm": ("run.cross_track_error_mean [m]", 1e3),
    "mrad": ("run.tcp_orientation_error_mean [rad]", 1e3),
}
"""Column of the table to column of the report, and the factor between their units."""


def groups_of(rows: Rows, key: str) -> dict[str, Rows]:
    """Return rows by the value of one of their columns."""
    found: dict[str, Rows] = defaultdict(list)
    for row in rows:
        found[row[key]].append(row)
    return dict(sorted(found.items()))


def means(rows: Rows) -> dict[str, float]:
    """Return the mean of every figure over rows."""
    return {name: mean(float(row[column]) * factor for row in rows) for name, (column, factor) in FIGURES.items()}


def table(rows: Rows) -> list[str]:
    """Return the lines of one controller: a row for each trajectory, their mean, and their range by speed group."""
    by_path = {name: means(runs) for name, runs in groups_of(rows, "trajectory").items()}
    ranges = {}
    for group, runs in groups_of(rows, "group").items():
        paths = {name: [by_path[row["trajectory"]][name] for row in runs] for name in FIGURES}
        ranges[f"range, {group}"] = {name: max(values) - min(values) for name, values in paths.items()}
    average = {name: mean(path[name] for path in by_path.values()) for name in FIGURES}
    lines = ["| trajectory |" + "".join(f" {name} |" for name in FIGURES), "| --- |" + " --- |" * len(FIGURES)]
    for name, row in (by_path | {"mean": average} | ranges).items():
        lines.append(f"| {name} |" + "".join(f" {value:.2f} |" for value in row.values()))
    return lines


def main(folder: str) -> None:
    """Print the tables of a results folder; failed runs are left out, and counted."""
    with (Path(folder) / "report" / "runs.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for label, runs in groups_of(rows, "label").items():
        finished = [row for row in runs if row["status"] == "ok"]
        print(f"\n{label}: {len(finished)} of {len(runs)} runs finished\n")
        print("\n".join(table(finished)) if finished else "no figures")


if __name__ == "__main__":
    main(sys.argv[1])
