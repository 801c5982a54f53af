"""Joins studies and evaluation: when a perturbed run counts as failed, and what loop records say."""

import numpy as np

from .evaluation.loops import (
    broken_loops,
    closed_loop,
    disk_margin,
    loop_margins,
    multiloop_disk_margin,
    scatter,
)
from .evaluation.metrics import success, tcp_position_error_mean
from .scenarios.log import RunLog
from .scenarios.studies import Judges, LoopRecords, LoopScores

LARGEST_ERROR = 0.1
"""Mean position error over the run above which a controller has not come through [m]."""


def objection(log: RunLog) -> str:
    """Say in one line why a run that came to its end still counts as failed; empty if it does not.

    Args:
        log: The run.
    """
    # The lead-in counts: an offset at the start is worst there.
    if success(log.q, log.q_ref, log.lower, log.upper) != 1.0:
        return "a joint passed a limit or the joint error norm reached 1 rad"
    scored = log.t >= -0.5 * log.dt
    error = tcp_position_error_mean(log.p[scored], log.p_ref[scored])
    return "" if error <= LARGEST_ERROR else f"the mean position error is {1e3 * error:.0f} mm"


def judge_loops(records: LoopRecords) -> LoopScores:
    """Return the margins of every joint's loop and of all together; every period after the first counts.

    Args:
        records: What was measured.
    """
    # The first period holds the transient of the injection's beginning.
    periods = closed_loop(records.commands[:, 1:], records.injection, records.lines)
    closed = periods.mean(axis=0)
    omega = 2.0 * np.pi * records.lines / (records.injection.shape[1] * records.period)
    loops, spread = broken_loops(closed), scatter(periods)
    count = len(omega)
    metrics = {f"loop {j + 1}": _single(loops[:, j], omega, float(spread[j])) for j in range(loops.shape[1])}
    together = multiloop_disk_margin(closed, omega)
    metrics["loops"] = {
        "multiloop_disk_margin": _entry(together.alpha, "times", count),
        "multiloop_disk_gain_margin": _entry(together.gain, "times", count),
        "multiloop_disk_phase_margin": _entry(together.phase, "deg", count),
    }
    arrays = {"omega": omega, "closed_real": periods.real, "closed_imag": periods.imag}
    return LoopScores(metrics=metrics, arrays=arrays)


def _single(response: np.ndarray, omega: np.ndarray, spread: float) -> dict[str, dict[str, object]]:
    """Return the margins of one loop by metric id."""
    margins, disk, count = loop_margins(response, omega), disk_margin(response, omega), len(omega)
    return {
        "gain_margin": _entry(margins.gain, "times", count),
        "phase_margin": _entry(margins.phase, "deg", count),
        "loop_delay_margin": _entry(margins.delay, "s", count),
        "modulus_margin": _entry(margins.modulus, "times", count),
        "crossover": _entry(margins.crossover, "rad/s", count),
        "disk_margin": _entry(disk.alpha, "times", count),
        "disk_gain_margin": _entry(disk.gain, "times", count),
        "disk_phase_margin": _entry(disk.phase, "deg", count),
        "scatter": _entry(spread, "1", count),
    }


def _entry(value: float, unit: str, count: int) -> dict[str, object]:
    """Return a stored metric; what the measured band does not hold is undefined."""
    return {"value": value, "unit": unit, "status": "ok" if np.isfinite(value) else "undefined", "n": count}


JUDGES = Judges(objection=objection, loops=judge_loops)
"""The judges of every campaign."""
