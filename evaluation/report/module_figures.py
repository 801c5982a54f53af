"""Figures of the modules: error and weight by load, and the gains over time."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..intervals import t_interval
from .charts import Axis, Chart, Curve, around, at_ends, thinned
from .findings import Findings
from .modules import SWEPT, Gains, Modules

MRAD = 1e3
PATTERNS = "one pattern, the other, and both"
"""What the figure by load shows where all of its controllers ran."""


def load_charts(findings: Findings, modules: Modules) -> list[Chart]:
    """Return joint error and heavy weight by load; empty where there are fewer than two loads."""
    charts = []
    errors = {label: found for label, found in modules.errors.items() if len(found) > 1}
    if errors:
        curves = [_by_load(label, found, MRAD, style) for style, (label, found) in enumerate(errors.items())]
        charts.append(
            Chart(
                id=f"{findings.world.id}-load-error",
                title=f"Joint error by load: {PATTERNS if len(errors) == len(SWEPT) else ', '.join(errors)}",
                description=f"Mean joint error, steady window, 95 % interval over seeds. {at_ends(curves, 'mrad')}",
                x=_loads([curve.x for curve in curves]),
                y=around("mean joint error [mrad]", _extents(curves), zero=True),
                curves=curves,
                height=260,
            )
        )
    if len(modules.weights) > 1:
        curves = [_by_load("heavy pattern's weight, last lap", modules.weights, 1.0, 0)]
        if modules.right:
            masses = np.array(sorted(modules.right))
            right = np.array([modules.right[mass] for mass in masses])
            curves.append(Curve(label="right: load beyond the gripper / 3 kg", x=masses, y=right, plain=True))
        charts.append(
            Chart(
                id=f"{findings.world.id}-load-weight",
                title="Weight of the heavy pattern by load",
                description=f"Mean over the last lap, with 95 % interval over seeds. {at_ends(curves, '')}",
                x=_loads([curve.x for curve in curves]),
                y=Axis("weight", 0.0, 1.1),
                curves=curves,
                height=260,
            )
        )
    return charts


def gain_charts(findings: Findings, label: str, gains: Gains) -> list[Chart]:
    """Return stiffness and damping of each joint over time in one run."""
    row, place = gains.run.row, findings.order.index(label) + 1
    words = f"{row.trajectory}, {gains.run.load}, repetition {row.repetition}"
    events = gains.run.stored.specification.schedule.events
    short = row.trajectory if events else f"{row.trajectory}, {gains.run.load}"
    charts = []
    for name, unit in (("stiffness", "N m/rad"), ("damping", "N m s/rad")):
        rows, start = gains.curves.shown[name], gains.curves.starts[name]
        t = start + np.arange(len(rows)) * gains.curves.periods[name]
        curves = [
            Curve(label=f"joint {joint + 1}", x=x, y=y, style=joint)
            for joint in range(rows.shape[1])
            for x, y in [thinned(t, rows[:, joint], 110)]
        ]
        charts.append(
            Chart(
                id=f"{findings.world.id}-{name}-{place}",
                title=f"{name.capitalize()} of {label}, {short}",
                description=f"{name.capitalize()} of each joint over time, {words}. {at_ends(curves, unit)}",
                x=Axis("time [s]", 0.0, gains.curves.duration),
                y=around(f"{name} [{unit}]", [curve.y for curve in curves]),
                curves=curves,
                height=240,
            )
        )
    return charts


def _by_load(label: str, found: Mapping[float, Sequence[float]], factor: float, style: int) -> Curve:
    """Return the mean by load, with the interval over seeds as a band where there are at least two."""
    masses = np.array(sorted(found))
    means = np.array([np.mean(found[mass]) for mass in masses]) * factor
    band = None
    if all(len(found[mass]) > 1 for mass in masses):
        limits = [t_interval(found[mass]) for mass in masses]
        band = (np.array([i.low for i in limits]) * factor, np.array([i.high for i in limits]) * factor)
    return Curve(label=label, x=masses, y=means, style=style, band=band, dots=True)


def _extents(curves: Sequence[Curve]) -> list[np.ndarray]:
    return [edge for curve in curves for edge in (curve.y, *(curve.band or ()))]


def _loads(masses: Sequence[np.ndarray]) -> Axis:
    return around("load beyond the flange, gripper included [kg]", masses)
