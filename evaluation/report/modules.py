"""What the modules of spiking controllers did in a world: weights and errors by load, gains, spikes, operations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...scenarios.store import Store
from ..metrics import METRICS, gain_correlation_by_joint, less_lap_mean
from .spread import Spread
from .traces import GAINS, Curves, read_curves
from .worlds import Run, World

SWEPT = ("light_only", "heavy_only", "cbmc_v3")
"""Controllers of the figures by load, as in the paper's panels."""
MODULES, ALL_MODULES = ("cerebellum", "thalamus", "brainstem", "spinal_cord"), "all_modules"
"""How the names of counted operations begin, and that of their sums."""
MOST_TRACES = 24
"""Runs of a controller whose gains are read from their traces."""
START_UP = 3.0
"""What the third correlation leaves out: gains rise together while the arm starts [s]."""
JOINT_ERROR, STEADY = "joint_error_mean", "steady"
PATTERNS_APART = 3.0
"""Load between the light and the heavy pattern [kg]."""
LAYERS = {
    "spikes_granule": ("Cerebellum, granule cells", 300, 10),
    "spikes_purkinje": ("Cerebellum, Purkinje cells", 200, 10),
    "spikes_thalamus": ("Thalamus, hidden", 0, 10),
    "spikes_brainstem": ("Brainstem, hidden", 0, 15),
}
"""Layer of a diagnostic, neurons behind each of its entries (0: an entry is a neuron), and steps of a window."""


@dataclass(frozen=True, kw_only=True)
class Gains:
    """The gains of one controller.

    Attributes:
        run: The run that its curves come from.
        curves: That run's trace.
        correlations: What was left out of the series, to a spread over runs for each joint.
        variation: Variation of the stiffness in each run.
        runs: How many traces were read.
    """

    run: Run
    curves: Curves
    correlations: Mapping[str, Sequence[Spread]]
    variation: Spread
    runs: int


@dataclass(frozen=True, kw_only=True)
class Modules:
    """What the modules did in one world.

    Attributes:
        errors: Controller of the sweep to load to the mean joint error of each seed [rad].
        weights: The spiking controller's load to the heavy pattern's weight of each seed, last lap.
        right: Load to the weight that is right for it; empty if no run noted its payload.
        slopes: The spiking controller's slope of weight by load, one for each trajectory and seed.
        gains: Controller to its gains.
        spikes: Controller to layer to share of steps with a spike, over runs.
        operations: Controller to counted operation to how many a second, over runs.
    """

    errors: Mapping[str, Mapping[float, Sequence[float]]]
    weights: Mapping[float, Sequence[float]]
    right: Mapping[float, float]
    slopes: Spread
    gains: Mapping[str, Gains]
    spikes: Mapping[str, Mapping[str, Spread]]
    operations: Mapping[str, Mapping[str, Spread]]


def modules_of(world: World, store: Store) -> Modules | None:
    """Return what the modules did; None if no run of the world shows any.

    Args:
        world: The world.
        store: The open store that it comes from.
    """
    able = {label: _finished(world, label) for label in world.labels}
    showing = {label: runs for label, runs in able.items() if any(_shown(run) for run in runs)}
    if not showing:
        return None
    # Of several variants of one controller the first by name is shown.
    ran = [(runs[0].stored.specification.controller, label) for label, runs in sorted(able.items()) if runs]
    named = dict(reversed(ran))
    constant = not world.runs[0].stored.specification.schedule.events
    swept = [named[name] for name in SWEPT if name in named and constant]
    spiking = showing.get(named.get("cbmc_v3", ""), [])
    gains = {label: _gains(runs, store, int(world.facts["Laps"])) for label, runs in showing.items()}
    return Modules(
        errors={label: _errors(able[label]) for label in swept},
        weights=_by_load(spiking, _heavy_weight) if constant else {},
        right=_right_weights(spiking) if constant else {},
        slopes=_slopes(spiking) if constant else Spread(),
        gains={label: found for label, found in gains.items() if found is not None},
        spikes={label: _spikes(runs) for label, runs in showing.items()},
        operations={label: found for label, runs in showing.items() if (found := _operations(runs))},
    )


def _finished(world: World, label: str) -> list[Run]:
    return [run for run in world.runs if run.row.controller == label and run.row.status == "ok"]


def _shown(run: Run) -> Mapping[str, Mapping[str, Any]]:
    """Return the figures of what a run's controller showed; empty in a store that has none."""
    shown = getattr(run.stored.result, "diagnostics", {})
    return shown if isinstance(shown, Mapping) else {}


def figure_of(run: Run, name: str, figure: str) -> np.ndarray | None:
    """Return one figure of one diagnostic; None if it is missing or no number."""
    values = _shown(run).get(name, {}).get(figure)
    if values is None:
        return None
    array = np.asarray(values, dtype=float)
    return array if array.size and np.isfinite(array).all() else None


def _heavy_weight(run: Run) -> float | None:
    weights = figure_of(run, "weights", "last_lap_mean")
    return None if weights is None or weights.size < 2 else float(weights.ravel()[-1])


def _joint_error(run: Run) -> float | None:
    entry = run.row.metrics.get(STEADY, {}).get(JOINT_ERROR)
    return float(entry["value"]) if entry and entry.get("status") == "ok" else None


def _errors(runs: Sequence[Run]) -> dict[float, list[float]]:
    return _by_load(runs, _joint_error)


def _by_load(runs: Sequence[Run], read: Any) -> dict[float, list[float]]:
    """Return, for each load, the mean over trajectories (and materials) of each seed."""
    found: dict[float, dict[int, list[float]]] = {}
    for run in runs:
        value = read(run)
        if value is not None:
            found.setdefault(run.row.mass, {}).setdefault(run.row.repetition, []).append(value)
    return {mass: [float(np.mean(v)) for _, v in sorted(seeds.items())] for mass, seeds in sorted(found.items())}


def _load(run: Run) -> float | None:
    """Return what hangs beyond the gripper, as the run noted it [kg]."""
    payload = run.stored.result.provenance.get("payload")
    if isinstance(payload, list) and payload and isinstance(payload[0], int | float):
        return float(payload[0])
    return None


def _right_weights(runs: Sequence[Run]) -> dict[float, float]:
    """Return the weight that is right for each load: the patterns are 3 kg apart."""
    return {mass: float(np.mean(w)) / PATTERNS_APART for mass, w in _by_load(runs, _load).items()}


def _slopes(runs: Sequence[Run]) -> Spread:
    groups: dict[tuple[str, int], list[tuple[float, float]]] = {}
    for run in runs:
        weights = figure_of(run, "weights", "run_mean")
        if weights is not None and weights.size > 1:
            groups.setdefault((run.row.trajectory, run.row.repetition), []).append(
                (float(weights.ravel()[-1]), run.row.mass)
            )
    found = Spread()
    for points in groups.values():
        weights, masses = np.array(points).T
        value = METRICS["thalamus_weight_slope"].value_of({"weights": weights, "masses": masses})
        found.add(value.value, value.status)
    return found


def _gains(runs: Sequence[Run], store: Store, laps: int) -> Gains | None:
    """Return the gains of a controller from the first of its traces, spread over them evenly."""
    chosen = runs if len(runs) <= MOST_TRACES else [runs[i * len(runs) // MOST_TRACES] for i in range(MOST_TRACES)]
    read = [(run, curves) for run in chosen if (curves := read_curves(store, run, GAINS)) is not None]
    able = [(run, curves) for run, curves in read if set(GAINS) <= set(curves.shown)]
    moving = [(run, c) for run, c in able if np.ptp(c.shown["stiffness"], axis=0).any()]
    if not moving:
        return None
    joints = moving[0][1].shown["stiffness"].shape[1]
    found = {cut: [Spread() for _ in range(joints)] for cut in ("raw", "laps", "late")}
    variation = Spread()
    for _, curves in moving:
        for cut, values in _correlations(curves, laps).items():
            for joint, r in enumerate(values):
                found[cut][joint].add(float(r), "ok" if np.isfinite(r) else "undefined")
        value = METRICS["gain_variation"].value_of({"stiffness": curves.shown["stiffness"]})
        variation.add(value.value, value.status)
    longest = max(moving, key=lambda item: (item[1].duration, -abs(item[0].row.mass - 2.5)))
    return Gains(run=longest[0], curves=longest[1], correlations=found, variation=variation, runs=len(moving))


def _correlations(curves: Curves, laps: int) -> dict[str, np.ndarray]:
    """Return each joint's correlation: as it is, less its lap means, and without the start-up."""
    gains = [curves.shown[name] for name in GAINS]
    gains = [gain[: min(map(len, gains))] for gain in gains]
    dt, start = curves.periods["stiffness"], curves.starts["stiffness"]
    late = max(0, int(np.ceil((START_UP - start) / dt)))
    cut = {"raw": gains, "laps": [less_lap_mean(g, curves.duration / laps, dt) for g in gains]}
    cut["late"] = [gain[late:] for gain in gains]
    return {name: gain_correlation_by_joint(*pair) for name, pair in cut.items()}


def _spikes(runs: Sequence[Run]) -> dict[str, Spread]:
    found = {}
    for name, (_, neurons, steps) in LAYERS.items():
        spread = Spread()
        for run in runs:
            mean = figure_of(run, name, "run_mean")
            if mean is not None:
                fields = {"spikes": mean.ravel(), "neurons": mean.size * (neurons or 1), "steps": steps}
                value = METRICS["spike_rate"].value_of(fields)
                spread.add(value.value, value.status)
        if spread.values:
            found[name] = spread
    return found


def _operations(runs: Sequence[Run]) -> dict[str, Spread]:
    """Return every counted operation by simulated second, lead-in included, of each module and of all together."""
    found: dict[str, Spread] = {}
    for run in runs:
        counted = run.stored.result.counts.get("operations")
        simulated = run.stored.result.timing.get("simulated_s")
        if isinstance(counted, Mapping) and isinstance(simulated, int | float) and simulated > 0.0:
            counts = {str(name): float(count) for name, count in counted.items()}
            for name, count in (counts | _together(counts)).items():
                found.setdefault(name, Spread()).add(count / float(simulated), "ok")
    return found


def _together(counts: Mapping[str, float]) -> dict[str, float]:
    """Return the sums over modules: those of one run, since a sum of medians is the count of no run."""
    found: dict[str, float] = {}
    for module in MODULES:
        for name in (name for name in counts if name.startswith(f"{module}_")):
            together = f"{ALL_MODULES}_{name.removeprefix(f'{module}_')}"
            found[together] = found.get(together, 0.0) + counts[name]
    return found
