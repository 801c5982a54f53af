"""Load events and modules for programs: every figure of their tables, in stored units."""

import math
from collections.abc import Mapping
from dataclasses import asdict

from ..energy import energy_table
from .efficiency_panel import EfficiencyPanel
from .panels import Panels
from .spread import Spread


def panel_figures(panels: Panels) -> dict[str, object]:
    """Return what a world's section shows besides the comparison; empty without load events and modules."""
    found: dict[str, object] = {}
    if panels.resilience is not None:
        resilience = panels.resilience.resilience
        found["resilience"] = {
            "curve_period_s": resilience.dt,
            "events": [
                {
                    "time_s": event.time,
                    "change": event.words,
                    "controllers": {
                        label: _spreads(spreads) for (at, label), spreads in resilience.found.items() if at == event
                    },
                }
                for event in resilience.events
            ],
            "improvement_rate": {
                f"{words}, {label}": _spread(rate) for (words, label), rate in resilience.rates.items()
            },
            "without_curve": dict(resilience.without),
            "not_judged": len(resilience.unjudged),
        }
    if panels.modules is not None:
        modules, known = panels.modules.modules, panels.modules.known
        found["modules"] = {
            "joint_error_by_load": {label: _by_load(errors) for label, errors in modules.errors.items()},
            "heavy_weight_by_load": _by_load(modules.weights),
            "weight_slope_per_kg": _spread(modules.slopes),
            "gain_correlation": {
                label: {cut: [_spread(joint) for joint in joints] for cut, joints in gains.correlations.items()}
                for label, gains in modules.gains.items()
            },
            "spike_rate": {label: _spreads(layers) for label, layers in modules.spikes.items()},
            "operations_per_s": {label: _spreads(counts) for label, counts in modules.operations.items()},
            "gravity_torque_nrmse": {} if known is None else {known.controller: known.errors},
        }
    if panels.robustness is not None:
        robustness = panels.robustness.robustness
        found["robustness"] = {
            "margins": [
                {"controller": label, "trajectory": trajectory, "margins": dict(margins)}
                for (label, trajectory), margins in robustness.margins.items()
            ],
            "loops": {label: dict(windows) for label, windows in robustness.loops.items()},
            "without": len(robustness.without),
        }
    if panels.efficiency is not None:
        found["efficiency"] = _efficiency(panels.efficiency)
    return found


def _efficiency(panel: EfficiencyPanel) -> dict[str, object]:
    """Return counts and estimates; the host's time is in the runs, and no figure here is a measurement of energy."""
    found = panel.efficiency
    return {
        "estimates_measured": energy_table().measured,
        "not_counted": list(found.uncounted),
        "controllers": {
            label: {
                "operations_per_s": asdict(computing.counts),
                "parameters": computing.costs.parameters,
                "state": computing.costs.state,
                "how": computing.costs.how,
                "estimate_inference_uW": computing.estimate.inference,
                "estimate_learning_uW": computing.estimate.learning,
                "estimate_with_memory_uW": computing.estimate.with_memory,
                "estimate_memory": computing.estimate.level,
                "on_front": [label in front for front in found.fronts],
            }
            for label, computing in found.found.items()
        },
    }


def _spreads(found: Mapping[str, Spread]) -> dict[str, object]:
    return {name: _spread(spread) for name, spread in found.items()}


def _spread(spread: Spread) -> dict[str, object]:
    """Return a spread; a value that never came about counts in ``never``, and a median of that kind is null."""
    finite = [value for value in spread.values if math.isfinite(value)]
    return {
        "median": spread.median,
        "low": min(finite, default=None),
        "high": max(finite, default=None),
        "n": len(spread.values),
        "never": len(spread.values) - len(finite),
        "without_value": dict(spread.others),
    }


def _by_load(found: Mapping[float, object]) -> dict[str, object]:
    return {f"{mass:g}": values for mass, values in found.items()}
