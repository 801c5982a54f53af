"""What a reader must not take from a page: sentences that depend on what the store holds."""

from collections.abc import Sequence

from .findings import Findings
from .panels import Panels

SENTENCES = {
    "simulated": "Every figure is of a simulation; none is of a real arm. The plants know friction, rotor inertia, "
    "delays, limits and sensor noise as models, and no contact with anything.",
    "tier": "Drives and sensors are those of the tiers {tiers}; an order of controllers need not hold in another.",
    "nominal": "Runs without draws are of the nominal arm, which all laws that use a model know exactly: they say "
    "nothing of a model that is wrong.",
    "stand-in": "The factory controller is a product; an impedance law after its documentation stands in, with "
    "rates and gains chosen here. What is said against it is said of the stand-in.",
    "readings": "CBMC-V3 is built from its paper, which prints its tables completely and its loop not quite: where "
    "it is silent a reading was chosen, and one constant was fitted to the recovery times that it prints.",
    "told": "Rows with the knowledge {told} were told or measured more of the load than rows without: they show "
    "what the knowledge is worth, not who is the better law.",
    "water": "Water is the first slosh mode of its container, without waves of higher order, splashing or air.",
    "energy": "Energy of computing is counted operations at the prices of a table. Nothing ran on neuromorphic "
    "hardware, and times of interpreted and compiled code are no comparison of laws.",
    "conventions": "Thresholds of recovery and of peaks are conventions; a statement that changes with them is not "
    "decided.",
}
STAND_INS = {"flexiv_factory", "flexiv_factory_dd", "flexiv_full_ff", "compliant"}
"""Presets of the law that stands in for a product."""


def limitations(findings: Sequence[Findings], panels: Sequence[Panels]) -> list[str]:
    """Return what limits the statements of a page, one or two sentences for each.

    Args:
        findings: Findings of each world.
        panels: What the section of each world has besides.
    """
    runs = [run for found in findings for run in found.world.runs]
    asked = [run.stored.specification for run in runs]
    names, told = {run.controller for run in asked}, {run.knowledge for run in asked} - {"none"}
    holds = {
        "simulated": True,
        "tier": bool(runs),
        "nominal": not all(run.draws for run in asked),
        "stand-in": bool(names & STAND_INS),
        "readings": "cbmc_v3" in names,
        "told": bool(told),
        "water": any(run.row.material == "water" for run in runs),
        "energy": any(panel.efficiency is not None for panel in panels),
        "conventions": any(panel.resilience is not None for panel in panels),
    }
    words = {"tiers": ", ".join(sorted({run.tier for run in asked})), "told": ", ".join(sorted(told))}
    return [text.format(**words) for name, text in SENTENCES.items() if holds[name]]
