"""The section on efficiency: three kinds of figures that are never summed, and the error beside the estimates."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..energy import energy_table
from ..metrics import METRICS
from .charts import Axis, Chart, Curve, Point
from .efficiency import Computing, CostsOf, Efficiency, efficiency_of
from .efficiency_tables import MECHANICAL, count_table, estimate_table, host_table, mechanical_table
from .findings import POSITION, WINDOW, Findings
from .numbers import significant, unit_on_page
from .scale import LogScale
from .table import Table

ARITHMETIC, WITH_MEMORY = "arithmetic", "memory"


@dataclass(frozen=True, kw_only=True)
class EfficiencyPanel:
    """What computing and moving cost, on the page.

    Attributes:
        efficiency: What the tables show.
        sentences: What was measured, what was counted, what was estimated, and what none of it says.
        counts: Operations.
        estimates: Energy by a table of prices.
        host: Time on the machine that ran the campaign.
        mechanical: Energy at the joints; without rows where no metric says.
        charts: Error against estimate, without and with memory traffic.
        metrics: Ids of the metrics of mechanical energy that are shown.
    """

    efficiency: Efficiency
    sentences: Sequence[str]
    counts: Table
    estimates: Table
    host: Table
    mechanical: Table
    charts: Sequence[Chart]
    metrics: Sequence[str]


def efficiency_panel(
    findings: Findings,
    campaigns: Sequence[Mapping[str, object]],
    costs_of: CostsOf,
) -> EfficiencyPanel | None:
    """Return the section on efficiency, None if nobody has counted a controller of this world.

    Args:
        findings: The world's findings.
        campaigns: Records of the campaigns; they name the machines.
        costs_of: Knows what controllers compute.
    """
    efficiency = efficiency_of(findings, costs_of)
    if efficiency is None:
        return None
    mechanical = mechanical_table(findings)
    shown = [name for name in MECHANICAL if name in METRICS] if mechanical.rows else []
    return EfficiencyPanel(
        efficiency=efficiency,
        sentences=_sentences(efficiency, mechanical=bool(mechanical.rows)),
        counts=count_table(findings, efficiency),
        estimates=estimate_table(findings, efficiency),
        host=host_table(findings, _machines(campaigns)),
        mechanical=mechanical,
        charts=pareto_charts(findings, efficiency),
        metrics=shown,
    )


def pareto_charts(findings: Findings, efficiency: Efficiency) -> list[Chart]:
    """Return mean position error against estimated power, without and with memory traffic; empty without two points.

    Args:
        findings: The world's findings.
        efficiency: What its controllers compute.
    """
    compared = [label for label in efficiency.found if efficiency.errors.get(label, 0.0) > 0.0]
    if len(compared) < 2:
        return []
    readings: tuple[tuple[str, str, Callable[[Computing], float]], ...] = (
        (ARITHMETIC, "arithmetic alone", lambda found: found.estimate.arithmetic),
        (WITH_MEMORY, "with memory traffic", lambda found: found.estimate.with_memory),
    )
    return [
        _chart(findings, efficiency, {k: read(efficiency.found[k]) for k in compared}, place, name, words)
        for place, (name, words, read) in enumerate(readings)
    ]


def _chart(
    findings: Findings, efficiency: Efficiency, powers: Mapping[str, float], place: int, name: str, words: str
) -> Chart:
    shown = unit_on_page(METRICS[POSITION].unit)
    errors = {label: shown.of(efficiency.errors[label]) for label in powers}
    levels = sorted({efficiency.knowledge[label] for label in powers})
    numbers = {label: str(number) for number, label in enumerate(efficiency.found, start=1)}
    front = efficiency.fronts[place]
    points = [
        Point(
            key=numbers[label],
            title=f"{label}: {significant(errors[label])} {shown.text}, {significant(power)} \N{MICRO SIGN}W",
            x=power,
            y=errors[label],
            shape="circle" if label in front else "diamond",
            style=levels.index(efficiency.knowledge[label]),
        )
        for label, power in powers.items()
    ]
    curves = []
    for style, level in enumerate(levels):
        kept = sorted((powers[k], errors[k]) for k in powers if k in front and efficiency.knowledge[k] == level)
        x, y = np.array(kept).T
        curves.append(Curve(label=f"knowledge {level}", x=x, y=y, style=style))
    return Chart(
        id=f"{findings.world.id}-pareto-{name}",
        title=f"Error against estimate: {words}",
        description=f"Estimates by the table's prices, no measurement. {'; '.join(point.title for point in points)}",
        x=_log_axis(f"estimate, {words} [\N{MICRO SIGN}W], logarithmic", powers.values()),
        y=_log_axis(f"mean position error [{shown.text}], logarithmic", errors.values()),
        curves=curves,
        points=points,
        width=560,
        height=340,
    )


def _log_axis(title: str, values: Iterable[float]) -> Axis:
    scale = LogScale.around(values)
    return Axis(title, scale.low, scale.high, log=True)


def _machines(campaigns: Sequence[Mapping[str, object]]) -> list[str]:
    """Return the machines of the campaigns in words, each once."""
    found = []
    for campaign in campaigns:
        machine = campaign.get("machine")
        if isinstance(machine, Mapping):
            found.append(f"{machine.get('processor', 'unknown processor')}, {machine.get('cores', '?')} cores")
    return list(dict.fromkeys(found))


def _sentences(efficiency: Efficiency, *, mechanical: bool) -> list[str]:
    """Say what is a count, what an estimate, what a measurement, and what nobody measured."""
    prices = energy_table()
    assumed = [name.replace("_", " ") for name, price in prices.operations.items() if price.assumed]
    sentences = [
        "Three kinds of figures stand apart and are never summed. Counts are facts about the equations and networks "
        "that ran. Estimates multiply counts by prices from a table. The host's time is that of one implementation on "
        "one machine: a processor does not profit from spikes that do not come. Nothing was measured on neuromorphic "
        "hardware, so no figure stands for it.",
        f"Prices: {prices.source}; {prices.technology}, {prices.number}, for all alike, though the laws run in 64 bits "
        f"here. It prints no price for {', '.join(assumed)}: those are assumed. Memory traffic counts what outlives a "
        "computation, at the price of the smallest memory that holds a controller's parameters and state.",
        "Left out for everybody: the plan, the state estimate, and what a knowledge level computes to find the load.",
    ]
    if efficiency.uncounted:
        sentences.append(f"Not counted: {', '.join(efficiency.uncounted)}.")
    if not mechanical:
        sentences.append(f"No metric of mechanical energy was computed over the window {WINDOW!r} here.")
    return sentences
