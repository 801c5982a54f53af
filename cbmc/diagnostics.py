"""What the stack shows of itself: live arrays with their periods, and the ledger of its settings."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..controllers import LedgerEntry
from .guard import Caps
from .online_kernels import SKIPPED
from .stack import Schedule, Stack

if TYPE_CHECKING:
    from .controller import CbmcV3

Shown = dict[str, tuple[np.ndarray, int]]


def live_arrays(stack: Stack, schedule: Schedule) -> Shown:
    """Return name to an array that is refilled in place, and its period in ticks.

    Args:
        stack: The stack.
        schedule: Its periods.

    Returns:
        ``weights``, ``stiffness``, ``damping``, ``gravity_torque``, ``compensation``, ``losses`` always; spikes by
        layer, clamp hits and skipped updates of the modules that are there.
    """
    down, second, third = stack.descending, schedule.second, schedule.third
    shown: Shown = {
        "weights": (down.weights, second),
        "stiffness": (down.stiffness, second),
        "damping": (down.damping, second),
        "gravity_torque": (down.gravity_torque, second),
        "compensation": (down.compensation, third),
        "losses": (stack.gradients.losses, second),
        "spikes_spinal": (_of(stack.spinal_cord, "spikes"), second),
        "spikes_granule": (_of(stack.cerebellum, "granule_spikes"), third),
        "spikes_purkinje": (_of(stack.cerebellum, "purkinje_spikes"), third),
        "clamp_hits": (_of(stack.brainstem, "clamped"), second),
    }
    for name, module in (("thalamus", stack.thalamus), ("brainstem", stack.brainstem)):
        network = getattr(module, "network", None)
        if network is not None:
            shown[f"spikes_{name}"] = (network.hidden_spikes, second)
            shown[f"skipped_updates_{name}"] = (network.tally[SKIPPED : SKIPPED + 1], second)
    return {name: (array, period) for name, (array, period) in shown.items() if array.size}


def _of(module: object, name: str) -> np.ndarray:
    """Return an array of a module, empty where a stand-in has none."""
    return np.asarray(getattr(module, name, np.zeros(0)))


def ledger(controller: "CbmcV3", caps: Caps, notes: Mapping[str, object]) -> Sequence[LedgerEntry]:
    """Return where each setting comes from: the paper's tables, a reading of it, the guard, the patterns.

    Args:
        controller: After reset.
        caps: The guard's caps.
        notes: How the patterns were made.
    """
    table = "the paper's tables, as printed"
    capped = {
        f"joint {joint + 1}": {"limit": round(float(caps.limit[joint]), 3), "cap": round(float(cap), 3)}
        for joint, cap in enumerate(caps.damping)
        if np.isfinite(cap)
    }
    below = [name for name, cap in capped.items() if cap["cap"] < controller.damping_range[0]]
    chosen = notes.get("training_set")
    named = chosen.get("name", "unknown") if isinstance(chosen, Mapping) else "unknown"
    trained = f"set {named}, preset {notes.get('preset', 'unknown')}, seed {notes.get('seed', 'unknown')}"
    return (
        LedgerEntry(
            setting="layers, membranes, thresholds, windows", value="as printed", source="published", note=table
        ),
        LedgerEntry(setting="learning rates, momentum, decay", value="as printed", source="published", note=table),
        LedgerEntry(
            setting="sensitivity",
            value=controller.sensitivity,
            source="tuned",
            note="the one constant of the learning rule; fitted by hand to the paper's recovery times",
            trials=6,
        ),
        LedgerEntry(setting="spike gain", value="2 Delta / k", source="chosen", note="decodes the error in rad"),
        LedgerEntry(setting="start", value=controller.start, source="chosen", note="scores depend on it"),
        LedgerEntry(setting="force_scale", value=list(controller.force_scale), source="chosen", note="order 1"),
        LedgerEntry(setting="stiffness_range", value=list(controller.stiffness_range), source="chosen", note="clamp"),
        LedgerEntry(setting="damping_range", value=list(controller.damping_range), source="chosen", note="clamp"),
        LedgerEntry(
            setting="gain caps",
            value=capped,
            source="rule",
            note="0.6 of the sampled loop's limit where that is below 25 N m s/rad"
            + (f"; below the clamp's floor: {', '.join(below)}" if below else ""),
        ),
        LedgerEntry(
            setting="patterns",
            value=[float(load) for load in controller.loads],
            source="rule",
            note="loads beyond the gripper [kg]",
            learnt_before=f"cerebellum patterns: {trained}",
        ),
    )
