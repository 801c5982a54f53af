"""What the kept traces of a store hold for the page: error curves and what controllers showed of themselves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...controllers import InvalidInput
from ...scenarios.store import Store
from .worlds import Run

DRAWN = ("t", "q", "q_ref")
"""What every curve is made of."""
GAINS = ("stiffness", "damping")
"""Diagnostics of a controller that regulates its gains."""
TICK = 1e-3
"""Control period where a run did not note it [s]."""


@dataclass(frozen=True)
class Curves:
    """A run's trace from the end of the lead-in on.

    Attributes:
        dt: Time between samples [s].
        error: Norm of the joint error, shape (N,) [rad].
        shown: Name to what the controller showed, a row for each update from time 0 on.
        periods: Name to the time between two of its rows [s].
        starts: Name to the time of its first row, less than one period [s].
    """

    dt: float
    error: np.ndarray
    shown: Mapping[str, np.ndarray]
    periods: Mapping[str, float]
    starts: Mapping[str, float]

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return len(self.error) * self.dt


def read_curves(store: Store, run: Run, shown: Sequence[str] = ()) -> Curves | None:
    """Return a run's trace; None if it did not finish, or its trace was not kept, is missing or damaged.

    Args:
        store: An open store.
        run: One of its runs.
        shown: What of the controller's diagnostics is read too.
    """
    if run.stored.result.status != "ok" or not run.stored.trace:
        return None
    try:
        trace = store.trace(run.stored.trace, {*DRAWN, *(f"diagnostics/{name}" for name in shown)})
        return _curves(trace, run)
    except (InvalidInput, KeyError, ValueError, IndexError):
        # A trace that cannot be read costs its curve, not the page.
        return None


def _curves(trace: Mapping[str, np.ndarray], run: Run) -> Curves:
    t = trace["t"].astype(float)
    dt = float(np.round((t[-1] - t[0]) / (len(t) - 1), 9))
    scored = t >= -0.5 * dt
    error = np.linalg.norm(trace["q_ref"].astype(float) - trace["q"].astype(float), axis=1)[scored]
    noted = run.stored.result.provenance
    ticks = noted.get("diagnostics")
    tick = noted.get("tick_s")
    period = float(tick) if isinstance(tick, int | float) else TICK
    shown, periods, starts = {}, {}, {}
    for name, every in ticks.items() if isinstance(ticks, Mapping) else ():
        rows = trace.get(f"diagnostics/{name}")
        if rows is None or not isinstance(every, int) or every < 1:
            continue
        step = every * period
        times = t[0] + np.arange(len(rows)) * step
        first = int(np.searchsorted(times, -0.5 * period))
        if first < len(rows):
            shown[name], periods[name], starts[name] = rows[first:].astype(float), step, float(times[first])
    return Curves(dt, error, shown, periods, starts)
