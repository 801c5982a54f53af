"""What a controller showed during a run, in figures: means over the run and its laps, spread once it has settled."""

from collections.abc import Mapping

import numpy as np

LARGEST = 64
"""Entries of the largest diagnostic that has figures; larger ones are pictures, and stay in the trace."""


def figures(
    diagnostics: Mapping[str, tuple[np.ndarray, int]], t: np.ndarray, lap: float
) -> dict[str, dict[str, object]]:
    """Return figures of each diagnostic, entry by entry, as nested lists of its shape; NaN where a window has no row.

    ``run_mean`` and ``lap_means`` are means over all whole laps and over each of them, ``last_lap_mean`` is the last of
    these, ``steady_std`` the standard deviation from the second lap on.

    Args:
        diagnostics: Name to rows, shape (rows, ...), and their period in ticks.
        t: Time since the end of the lead-in of every tick of a run that is over, shape (N,) [s].
        lap: Duration of one lap [s].
    """
    found: dict[str, dict[str, object]] = {}
    for name, (rows, period) in diagnostics.items():
        if rows[:1].size > LARGEST:
            continue
        # Half a tick of grace: a time is a rounded decimal, the end of a lap may not be.
        grace = 0.5 * (t[1] - t[0])
        laps = np.floor((t[::period] + grace) / lap).astype(int)
        total = int(np.floor((t[-1] + 2.0 * grace) / lap + 1e-6))
        means = [_mean(rows[laps == number]) for number in range(total)]
        found[name] = {
            "run_mean": _mean(rows[laps >= 0]),
            "lap_means": means,
            "last_lap_mean": means[-1] if means else _mean(rows[:0]),
            "steady_std": _spread(rows[laps >= 1]),
        }
    return found


def _mean(rows: np.ndarray) -> object:
    return _listed(np.mean(rows, axis=0, dtype=float) if len(rows) else np.full(rows.shape[1:], np.nan))


def _spread(rows: np.ndarray) -> object:
    return _listed(np.std(rows, axis=0, dtype=float) if len(rows) else np.full(rows.shape[1:], np.nan))


def _listed(values: np.ndarray) -> object:
    """Return values as nested lists, a single number as a list of one."""
    return np.atleast_1d(values).tolist()
