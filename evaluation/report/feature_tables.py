"""Tables of means, one for each feature of a motion that the headline has no room for."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..metrics import METRICS
from ..rows import Cell as GridCell
from .cells import controller_cells
from .findings import WINDOW, Findings
from .numbers import capitalised, unit_on_page
from .table import Cell, Column, Reading, Table, columns_to_rows, number_cells


@dataclass(frozen=True, kw_only=True)
class Feature:
    """What one table shows.

    Attributes:
        name: End of the table's name.
        caption: What it shows.
        metrics: Ids of its metrics, in the order of its columns.
        note: What a reader must know of all of them, empty if nothing.
    """

    name: str
    caption: str
    metrics: Sequence[str]
    note: str


FINISHED = "means of runs that finished, with their sign"

FEATURES = (
    Feature(
        name="tracking",
        caption="Position error beyond its mean, and what is lag, what is contour",
        metrics=(
            "tcp_position_error_rms", "tcp_position_error_p95", "tcp_position_error_max", "lag_free_error",
            "lag_share", "along_track_error_mean", "cross_track_error_mean", "contour_error_p95", "contour_error_max",
        ),
        note="along the path a negative error is behind the plan; the share of lag is of the squared error",
    ),
    Feature(
        name="iso",
        caption="Path criteria in the style of ISO 9283:1998",
        metrics=(
            "iso_path_accuracy", "iso_path_accuracy_orientation", "iso_path_repeatability",
            "iso_path_repeatability_orientation", "iso_velocity_accuracy", "iso_velocity_repeatability",
            "iso_velocity_fluctuation",
        ),
        note="of the laps after the first, where the standard asks for ten cycles; geometric, so blind to lag",
    ),
    Feature(
        name="velocity",
        caption="Velocity tracking",
        metrics=(
            "joint_velocity_error_mean", "joint_velocity_error_rms", "velocity_error_ratio", "tcp_speed_error_mean",
            "tcp_velocity_error_mean", "tcp_angular_velocity_error_mean",
        ),
        note="of the simulator's true velocities, not of those that controllers measured",
    ),
    Feature(
        name="smoothness",
        caption="Smoothness and saturation",
        metrics=(
            "torque_total_variation", "torque_ripple", "jerk_ratio", "ldlj", "sparc", "clip_impulse",
            "velocity_limit_fraction", "position_limit_margin_min",
        ),
        note="log dimensionless jerk and spectral arc length were made for reaching movements: on closed paths they "
        "are exploratory, and blind to a small ripple",
    ),
)  # fmt: skip


def feature_tables(findings: Findings) -> list[Table]:
    """Return a table for each feature of which a run has a value, and one for the metrics of plug-ins.

    Means are over cells of the means over repetitions, with their sign; of runs that finished.
    """
    own = sorted({name for row in findings.world.rows for name in row.metrics.get(WINDOW, {})} - set(METRICS))
    plug_ins = Feature(name="plug-ins", caption="Metrics of plug-ins", metrics=own, note="")
    return [table for feature in (*FEATURES, plug_ins) if (table := _table(findings, feature)).rows]


def shown_metrics(findings: Findings) -> list[str]:
    """Return the ids of the built-in metrics that the tables show."""
    stored = {name for row in findings.world.rows for name in row.metrics.get(WINDOW, {})}
    return [name for feature in FEATURES for name in feature.metrics if name in stored]


def _table(findings: Findings, feature: Feature) -> Table:
    """Return the table of a feature, only with columns that hold a number; without rows if none does."""
    found = [_column(findings, name) for name in feature.metrics]
    kept = [(column, cells) for column, cells in found if any(cell.value is not None for cell in cells)]
    identity = f"{findings.world.id}-{feature.name}"
    note = ". ".join(part for part in (FINISHED, feature.note) if part)
    columns = [Column("Controller / knowledge", numeric=False, note=note), *(column for column, _ in kept)]
    cells = [controller_cells(findings), *(cells for _, cells in kept)]
    return Table(
        id=identity,
        caption=feature.caption,
        columns=columns,
        rows=columns_to_rows(cells) if kept else [],
        name=identity,
    )


def _column(findings: Findings, name: str) -> tuple[Column, list[Cell]]:
    means, stored = _means(findings, name)
    readings = [Reading(means.get(label), "undefined") for label in findings.order]
    text, unit = (capitalised(METRICS[name].label), METRICS[name].unit) if name in METRICS else (name, stored)
    return Column(text, unit_on_page(unit).text), number_cells(readings, unit)


def _means(findings: Findings, name: str) -> tuple[dict[str, float], str]:
    """Return the mean of each controller over its cells, and the stored unit."""
    values: dict[str, dict[GridCell, list[float]]] = {}
    unit = ""
    for row in findings.world.rows:
        entry = row.metrics.get(WINDOW, {}).get(name) if row.status == "ok" else None
        value = None if entry is None else entry.get("value")
        if entry is not None and isinstance(value, int | float) and math.isfinite(value):
            values.setdefault(row.controller, {}).setdefault(row.cell, []).append(float(value))
            unit = str(entry.get("unit", ""))
    means = {label: float(np.mean([np.mean(cell) for cell in cells.values()])) for label, cells in values.items()}
    return means, unit
