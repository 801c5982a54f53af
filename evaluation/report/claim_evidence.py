"""The runs behind the paper's claims: worlds of a store matched with the sets, and figures of runs made readings."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...scenarios.store import Store
from ..claims import Book, Evidence, RunSet
from ..metrics import METRICS, gain_correlation_by_joint
from ..rows import RunRow
from .efficiency import computing_of
from .gravity import GRAVITY, GravityErrors
from .modules import figure_of
from .panels import Panels
from .resilience import REPEATED, Resilience, events_of, values_by_seed
from .traces import GAINS, Curves, read_curves
from .worlds import CONSTANT, Run, World

ROBOT = "rizon4s"
"""The arm that the paper speaks of."""
MEAN_CURVE = "mean curve"
"""What stands for a trajectory where a figure comes from the mean over trajectories."""
RECOVERY = "recovery_time_paper_style"
RUN = "run"
HELD_OUT = "gravity_heldout"
"""The set of motions on which patterns are judged, which no benchmark runs."""


def evidence_of(worlds: Sequence[World], panels: Sequence[Panels], store: Store, book: Book) -> dict[str, Evidence]:
    """Return the runs of each set of which the store holds any.

    Several worlds may fit a set, on two plants or with two seeds: the one with the most runs is taken.

    Args:
        worlds: The worlds of the store, that with the most runs first.
        panels: What the section of each world has besides.
        store: The open store that they come from.
        book: The claims with their sets.
    """
    gains = {claim.runs for claim in book.claim if any(name.startswith("gain_") for name in claim.metrics)}
    found = {}
    for runs in book.set:
        fitting = [pair for pair in zip(worlds, panels, strict=True) if _fits(pair[0], runs)]
        if fitting:
            world, panel = fitting[0]
            found[runs.id] = _evidence(world, panel, store if runs.id in gains else None, runs)
    known = [panel.modules.known for panel in panels if panel.modules is not None and panel.modules.known]
    if known:
        runs = next(runs for runs in book.set if runs.id == HELD_OUT)
        found[HELD_OUT] = Evidence(runs=runs, rows=_of_gravity(known[0], runs))
    return found


def _fits(world: World, runs: RunSet) -> bool:
    """Return whether a world's runs are runs of a set."""
    wanted = {
        "Robot": ROBOT,
        "Tier": runs.tier,
        "Load history": runs.history or CONSTANT,
        "Laps": str(runs.laps),
        "Lead-in": f"{runs.lead_in:g} s",
        "Protocol": "fresh",
        "Latency": "none",
    }
    alike = all(world.facts[name] == value for name, value in wanted.items())
    return alike and any(_belongs(run, runs) for run in world.runs)


def _belongs(run: Run, runs: RunSet) -> bool:
    return run.row.trajectory in runs.trajectories and (not runs.masses or run.row.mass in runs.masses)


def _evidence(world: World, panels: Panels, store: Store | None, runs: RunSet) -> Evidence:
    members = [run for run in world.runs if _belongs(run, runs)]
    changes = _repeated(world)
    rows, gains = [], dict[str, list[tuple[np.ndarray, np.ndarray, int]]]()
    for run in members:
        figures = {**_of_run(run), **_rate(run, changes), **_of_arithmetic(run, panels)}
        curves = read_curves(store, run, GAINS) if store is not None else None
        if curves is not None and set(GAINS) <= set(curves.shown):
            stiffness, damping, lap = _gains(curves, int(world.facts["Laps"]))
            gains.setdefault(run.row.controller, []).append((stiffness, damping, lap))
            figures |= _of_gains(stiffness, damping)
        rows.append(_with(run.row, figures))
    if panels.resilience is not None:
        rows += rows_of_curves(panels.resilience.resilience, members[0].row, int(world.facts["Laps"]))
    return Evidence(runs=runs, rows=rows, gains=gains)


def _of_run(run: Run) -> dict[str, float]:
    """Return the heavy pattern's mean weight and the wall time of a slow tick, where a run noted them."""
    found = {}
    weights, slow = figure_of(run, "weights", "run_mean"), run.stored.result.timing.get("call_us_p99")
    if weights is not None and weights.size > 1:
        found["heavy_weight"] = float(weights.ravel()[-1])
    if isinstance(slow, int | float):
        found["tick_time_p99"] = 1e-6 * float(slow)
    return found


def _of_arithmetic(run: Run, panels: Panels) -> dict[str, float]:
    """Return what a run's arithmetic is estimated to cost, where its controller was counted."""
    counted = {} if panels.efficiency is None else panels.efficiency.efficiency.found
    if run.row.controller not in counted or run.row.status != "ok":
        return {}
    computing = computing_of([run], counted[run.row.controller].costs)
    return {} if computing is None else {"op_energy_estimate": computing.estimate.arithmetic}


def _of_gravity(known: GravityErrors, runs: RunSet) -> list[RunRow]:
    """Return a row for each motion of the set and each pattern, in place of a run."""
    return [
        RunRow(
            controller=known.controller,
            trajectory=motion,
            group="",
            mass=load,
            material="",
            repetition=0,
            status="ok",
            metrics={RUN: {GRAVITY: {"value": error, "status": "ok"}}},
        )
        for motion, errors in known.errors.items()
        if motion in runs.trajectories
        for load, error in errors.items()
    ]


def _repeated(world: World) -> list[str]:
    """Return the windows of the first change of the load that is repeated; empty if none is."""
    changes: dict[str, list[str]] = {}
    for event in events_of(world)[1:]:
        changes.setdefault(event.words, []).append(event.window)
    return next((windows for windows in changes.values() if len(windows) >= REPEATED), [])


def _rate(run: Run, windows: Sequence[str]) -> dict[str, float]:
    """Return how the cost of a repeated change develops."""
    costs = [run.row.metrics.get(window, {}).get("excess_integral", {}).get("value") for window in windows]
    if not costs or any(cost is None for cost in costs):
        return {}
    rate = METRICS["improvement_rate"].value_of({"excess_integrals": np.array(costs, dtype=float)})
    return {"improvement_rate": rate.value} if rate.status == "ok" else {}


def _gains(curves: Curves, laps: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Return stiffness and damping at the same updates, and how many make a lap."""
    count = min(len(curves.shown["stiffness"]), len(curves.shown["damping"]))
    lap = round(curves.duration / laps / curves.periods["stiffness"])
    return curves.shown["stiffness"][:count], curves.shown["damping"][:count], lap


def _of_gains(stiffness: np.ndarray, damping: np.ndarray) -> dict[str, float]:
    found = {
        f"gain_correlation_j{joint}": float(r)
        for joint, r in enumerate(gain_correlation_by_joint(stiffness, damping), start=1)
        if math.isfinite(r)
    }
    variation = METRICS["gain_variation"].value_of({"stiffness": stiffness})
    return found | ({"gain_variation": variation.value} if variation.status == "ok" else {})


def _with(row: RunRow, figures: Mapping[str, float]) -> RunRow:
    """Return a row with further figures in its run window."""
    entries: dict[str, Mapping[str, Any]] = {name: {"value": v, "status": "ok"} for name, v in figures.items()}
    return replace(row, metrics={**row.metrics, RUN: {**row.metrics.get(RUN, {}), **entries}}) if figures else row


def rows_of_curves(resilience: Resilience, like: RunRow, laps: int) -> list[RunRow]:
    """Return a row for each seed's mean curve with the figures that come from it."""
    found: dict[tuple[str, int], dict[str, dict[str, dict[str, Any]]]] = {}
    for label, curve in resilience.curves.items():
        for event in resilience.events:
            values = values_by_seed(curve, RECOVERY, event, laps)
            for repetition, value in zip(curve.repetitions, values, strict=True):
                entry = {RECOVERY: {"value": value.value, "status": value.status}}
                found.setdefault((label, repetition), {})[event.window or f"event@{event.time:g}"] = entry
    return [
        replace(
            like,
            controller=label,
            trajectory=MEAN_CURVE,
            group="",
            repetition=repetition,
            status="ok",
            metrics=metrics,
        )
        for (label, repetition), metrics in found.items()
    ]
