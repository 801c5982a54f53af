"""Claims about one side: slopes, times of recovery, counts, correlations, levels."""

import math

import numpy as np

from ..blocks import block_correlation
from ..intervals import Interval
from ..metrics import METRICS
from ..statistics import sign_flip_test
from .book import Claim
from .measures import by_path, interval_of, mean_over, pooled, slopes
from .readings import READINGS, Evidence, NotEnough, numbers
from .rules import Ruling, correlation_rule, count_rule, level_rule, slope_rule, time_rule
from .verdict import Measured

THRESHOLDS = ("recovery_time_settled_10", "recovery_time_settled", "recovery_time_settled_50")
RATE = "improvement_rate"
"""The one reading that is a slope itself, of a logarithm over events."""


def slope(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge by the mean over trajectories of the slope over the load, or of a rate from event to event."""
    (metric,) = claim.metrics
    values = {a: _values(claim, evidence, a, metric) for a in claim.a}
    if metric == RATE:
        over, scale = pooled([by_path(found) for found in values.values()]), 1.0
    else:
        over = pooled([slopes(found) for found in values.values()])
        scale = float(np.mean([value for found in values.values() for value in found.values()]))
    interval = interval_of(over)
    side = -1.0 if claim.higher else 1.0
    ends = None if interval is None else sorted((side * interval.low, side * interval.high))
    ruling = slope_rule(None if ends is None else Interval(ends[0], ends[1], 0.95, "t"), scale)
    unit = "per event" if metric == RATE else f"{_unit(metric)}/kg"
    mean = f"mean {scale:.3g} {_unit(metric)}".removesuffix(" 1").rstrip()
    measured = Measured(
        value=float(over.mean()), unit=unit, interval=interval, n=len(over), of="trajectories",
        test=f"sign flips, p = {sign_flip_test(over):.3g}", notes=(mean,),
    )  # fmt: skip
    return ruling, measured


def time(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge a time of recovery from the mean curve by its median over seeds."""
    (metric,) = claim.metrics
    rows = evidence.of(claim.a[0], claim)
    times = list(numbers(rows, metric, claim.window).values())
    if not times:
        raise NotEnough(f"no mean curve of {claim.a[0]}, so no {metric}")
    thresholds = [list(numbers(rows, name, claim.window).values()) for name in THRESHOLDS]
    notes = tuple(f"{name}: {_seconds(found)}" for name, found in zip(THRESHOLDS, thresholds, strict=True) if found)
    ruling = time_rule(times, claim.printed or 0.0, thresholds)
    middle = float(np.median(times))
    spread = Interval(min(times), max(times), 1.0, "range") if len(times) > 1 else None
    value = middle if math.isfinite(middle) else None
    return ruling, Measured(value=value, unit="s", interval=spread, n=len(times), of="seeds", notes=notes)


def count(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge a count of peaks against the printed one and against what should not have as many."""
    (metric,) = claim.metrics
    rows = evidence.of(claim.a[0], claim)
    counts = list(numbers(rows, metric, claim.window).values())
    if not counts:
        raise NotEnough(f"no run of {claim.a[0]} has {metric} in window {claim.window}")
    steady = numbers(rows, "recovery_peaks_stable", claim.window)
    nulls = {"the motion without the event": list(numbers(rows, "recovery_peaks_raw_null", claim.window).values())}
    for name in claim.nulls:
        nulls[name] = list(numbers(evidence.of(name, claim), metric, claim.window).values())
    ruling = count_rule(counts, int(claim.printed or 0), stable=len(steady) / len(counts), nulls=nulls)
    notes = tuple(f"{name}: {np.median(found):g}" for name, found in nulls.items() if found)
    spread = Interval(min(counts), max(counts), 1.0, "range")
    return ruling, Measured(
        value=float(np.median(counts)), unit="peaks", interval=spread, n=len(counts), of="runs", notes=notes
    )


def correlation(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge the correlation of a joint's gains, whole laps resampled."""
    runs = evidence.gains.get(claim.a[0], ())
    if not runs:
        raise NotEnough(f"no trace of {claim.a[0]} in {evidence.runs.id} holds its gains")
    joint = claim.joint - 1
    series = [(stiffness[:, joint], damping[:, joint]) for stiffness, damping, _ in runs]
    r, interval = block_correlation(series, runs[0][2])
    ruling = correlation_rule(r, interval, claim.printed or 0.0, claim.band)
    each = [float(np.corrcoef(x, y)[0, 1]) for x, y in series if np.ptp(x) > 0.0 and np.ptp(y) > 0.0]
    notes = (f"single runs {min(each):.2f} to {max(each):.2f}",)
    return ruling, Measured(value=r, unit="r", interval=interval, n=len(runs), of="runs", notes=notes)


def level(claim: Claim, evidence: Evidence) -> tuple[Ruling, Measured]:
    """Judge whether a mean lies within limits, or an error is smallest at a load."""
    (metric,) = claim.metrics
    if claim.at:
        return _best_loads(claim, evidence, metric)
    values = by_path(_values(claim, evidence, claim.a[0], metric))
    over = np.array(list(values.values()))
    measured = Measured(
        value=float(over.mean()), unit=_unit(metric), interval=interval_of(over), n=len(over), of="trajectories",
        notes=_lag(claim, evidence) if metric.startswith("tcp_") else (),
    )  # fmt: skip
    return level_rule(float(over.mean()), claim.low, claim.high), measured


def _best_loads(claim: Claim, evidence: Evidence, metric: str) -> tuple[Ruling, Measured]:
    """Judge at which load each controller errs least."""
    best, notes = [], []
    for label, wanted in zip(claim.a, claim.at, strict=True):
        curve = mean_over(_values(claim, evidence, label, metric), lambda key: key[1])
        if len(curve) < 3:
            raise NotEnough(f"fewer than three loads of {label}")
        best.append(min(curve, key=curve.__getitem__))
        edge = ", the end of the sweep" if best[-1] in (min(curve), max(curve)) else ""
        notes.append(f"{label} is best at {best[-1]:g} kg{edge}, claimed {wanted:g}")
    worst = max(abs(found - wanted) for found, wanted in zip(best, claim.at, strict=True))
    ruling = level_rule(worst, 0.0, claim.band)
    return ruling, Measured(value=best[0], unit="kg", n=len(best), of="controllers", notes=tuple(notes))


def _values(claim: Claim, evidence: Evidence, controller: str, metric: str) -> dict[tuple[str, float, str, int], float]:
    """Return the values of a controller; a failed run counts as its metric says.

    Raises:
        NotEnough: If no run has one.
    """
    rows = evidence.of(controller, claim)
    found = {key: value for key, value in numbers(rows, metric, claim.window).items() if math.isfinite(value)}
    cost = METRICS[metric].fail_value if metric in METRICS else None
    if cost is not None:
        found |= {key: cost for key, row in rows.items() if row.status == "failed"}
    if not found:
        raise NotEnough(f"no run of {controller} has {metric}")
    return found


def _lag(claim: Claim, evidence: Evidence) -> tuple[str, ...]:
    lags = list(numbers(evidence.of(claim.a[0], claim), "time_lag", claim.window).values())
    return (f"mean time lag {1e3 * np.mean(lags):.1f} ms",) if lags else ()


def _unit(metric: str) -> str:
    if metric in METRICS:
        return METRICS[metric].unit
    return "1" if metric in READINGS else ""


def _seconds(times: list[float]) -> str:
    middle = float(np.median(times))
    return f"{middle:.2f} s" if math.isfinite(middle) else "never"
