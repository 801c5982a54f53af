"""Error curves over time: a small chart for each controller on the same axes, and zooms on the events."""

from collections.abc import Sequence

import numpy as np

from .charts import Axis, Chart, Curve, around, at_ends, thinned
from .findings import Findings
from .numbers import significant
from .resilience import Event, MeanCurve, Resilience

MOST_CHARTS = 24
"""Controllers with a chart of their own; the tables have all."""
SPIKING = (
    "cbmc_v3",
    "no_brainstem_learning",
    "no_thalamus_learning",
    "fixed_cerebellum_torque",
    "no_learning",
    "no_encoder",
)
"""Controllers of the zooms: the spiking one and its ablations, as the paper's panels."""
START_ZOOM, HEAVIER_ZOOM, LIGHTER_ZOOM = 1.5, 2.0, 1.5
"""How much of the time after an event the zooms show, as in the paper's panels [s]."""
MRAD = 1e3


def curve_charts(findings: Findings, resilience: Resilience) -> list[Chart]:
    """Return the error over time of each controller, all on the same axes."""
    labels = [label for label in findings.order if label in resilience.curves][:MOST_CHARTS]
    curves = {label: _curve(label, resilience.curves[label], 0, len(resilience.curves[label].t)) for label in labels}
    # One controller that oscillates would flatten all others: the axis ends at three times their median peak.
    tops = sorted(float(curve.y.max()) for curve in curves.values())
    top = min(tops[-1], 3.0 * tops[len(tops) // 2]) if tops else 1.0
    marks = [(event.time, event.words) for event in resilience.events if event.window]
    return [
        Chart(
            id=f"{findings.world.id}-curve-{place}",
            title=label,
            description=_described(label, resilience.curves[label], curve) + _cut(curve, top),
            x=Axis("time [s]", 0.0, float(resilience.curves[label].t[-1] + resilience.curves[label].dt)),
            y=Axis("joint error [mrad]" + _cut(curve, top), 0.0, 1.05 * top),
            # The controller's own curve is drawn last, above its twins.
            curves=[*_twins(resilience, label), curve],
            events=marks,
            height=180,
        )
        for place, (label, curve) in enumerate(curves.items(), start=1)
    ]


def zoom_charts(findings: Findings, resilience: Resilience) -> list[Chart]:
    """Return the time after each event for the spiking controller and its ablations; empty if none ran."""
    names = {run.row.controller: run.stored.specification.controller for run in findings.world.runs}
    able = [label for label in findings.order if label in resilience.curves and names[label] in SPIKING]
    labels = sorted(able, key=lambda label: SPIKING.index(names[label]))[:6]
    return [_zoom(findings, resilience, event, labels) for event in resilience.events] if labels else []


def _zoom(findings: Findings, resilience: Resilience, event: Event, labels: Sequence[str]) -> Chart:
    length = LIGHTER_ZOOM if event.words.startswith("\N{MINUS SIGN}") else HEAVIER_ZOOM
    length = length if event.window else START_ZOOM
    curves = []
    for style, label in enumerate(labels):
        mean = resilience.curves[label]
        first, last = (round(time / mean.dt) for time in (event.time, event.time + length))
        curves.append(_curve(label, mean, first, last + 1, style))
    return Chart(
        id=f"{findings.world.id}-zoom-{event.time:g}",
        title=f"{event.title}, ablations",
        description=(
            f"Joint error of the spiking controller and its ablations, "
            f"from {event.time:g} to {event.time + length:g} s. "
            f"{at_ends(curves, 'mrad')}"
        ),
        x=Axis("time [s]", event.time, event.time + length),
        y=around("joint error [mrad]", [curve.y for curve in curves], zero=True),
        curves=curves,
        height=230,
    )


def _twins(resilience: Resilience, label: str) -> list[Curve]:
    """Return what the error would have been with each load from the start on: recovery is judged against these."""
    found = resilience.constant.get(label, {})
    return [
        _curve(f"twin, {role}", mean, 0, len(mean.t), style)
        for style, (role, mean) in enumerate(found.items(), start=1)
    ]


def _curve(label: str, mean: MeanCurve, first: int, last: int, style: int = 0) -> Curve:
    """Return part of a mean curve, averaged over its seeds."""
    whole = mean.seeds[:, first:last].mean(axis=0) * MRAD
    x, y = thinned(mean.t[first:last], whole)
    return Curve(label=label, x=x, y=y, style=style)


def _described(label: str, mean: MeanCurve, curve: Curve) -> str:
    return (
        f"Joint error of {label} over time, mean over {mean.paths} trajectories and {len(mean.seeds)} seeds: "
        f"largest {significant(float(curve.y.max()))} mrad, median {significant(float(np.median(curve.y)))} mrad."
    )


def _cut(curve: Curve, top: float) -> str:
    """Say how far a curve goes beyond its chart."""
    highest = float(curve.y.max())
    return f", up to {significant(highest)} beyond the chart" if highest > 1.05 * top else ""
