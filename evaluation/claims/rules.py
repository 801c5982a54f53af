"""Verdict rules: from an estimate, its interval and the number of units to one word, and why it is no higher one.

The rules know neither claims nor runs. Sides are signed so that the claimed one is negative: a controller that claims a
smaller error has a negative logarithm of its ratio.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from ..intervals import Interval
from ..statistics import sign_flip_floor

Word = Literal[
    "reproduced",
    "same direction but smaller",
    "not reproduced",
    "opposite",
    "not enough to decide",
    "cannot be tested here",
    "in parts",
]
REPRODUCED: Word = "reproduced"
SMALLER: Word = "same direction but smaller"
NOT_REPRODUCED: Word = "not reproduced"
OPPOSITE: Word = "opposite"
UNDECIDED: Word = "not enough to decide"
UNTESTABLE: Word = "cannot be tested here"
IN_PARTS: Word = "in parts"

ALPHA = 0.05
FRACTION = 0.5
"""Share of a printed logarithmic effect from which on it counts as reproduced."""
MOST_CELLS, FEWEST_CELLS = 0.8, 0.2
FLAT = 0.02
"""Half-width of a slope, as a share of the mean for each unit, below which an interval around zero means no slope."""
OFTEN = 0.8
"""Share of runs that must show a count."""


@dataclass(frozen=True)
class Ruling:
    """A word, and why it is not the next higher one; for ``reproduced``, what it does not say."""

    word: Word
    reason: str = ""


def ratio_rule(
    estimate: float,
    interval: Interval | None,
    n: int,
    printed: float | None,
    *,
    averages_agree: bool = True,
) -> Ruling:
    """Judge a ratio over trajectories.

    Args:
        estimate: Logarithm of the ratio, negative on the claimed side.
        interval: Its interval; None if there is none.
        n: Number of trajectories.
        printed: Logarithm of the printed ratio, negative; None if no number is printed.
        averages_agree: Whether the geometric mean and the ratio of means lie on one side of one.
    """
    if interval is None or sign_flip_floor(n) > ALPHA:
        return Ruling(UNDECIDED, f"trajectories: {n}; no test of fewer than six can reach 5 %")
    if not averages_agree:
        return Ruling(UNDECIDED, "depends on the average used")
    return effect_rule(estimate, interval, printed)


def effect_rule(estimate: float, interval: Interval | None, printed: float | None) -> Ruling:
    """Judge an effect by its interval alone, for example a ratio of ranges by the interval of this suite."""
    if interval is None:
        return Ruling(UNDECIDED, "one repetition: no interval for these trajectories")
    wanted = None if printed is None else FRACTION * printed
    if interval.high < 0.0:
        if wanted is None or estimate <= wanted:
            return Ruling(REPRODUCED)
        return Ruling(SMALLER, "the effect is below half of the printed one")
    if interval.low > 0.0:
        return Ruling(OPPOSITE, "the interval lies on the other side")
    if wanted is not None and interval.low > wanted:
        return Ruling(NOT_REPRODUCED, "the interval holds no effect and excludes half of the printed one")
    return Ruling(UNDECIDED, "the interval holds no effect" + (" and half of the printed one" if wanted else ""))


def interaction_rule(interval: Interval | None) -> Ruling:
    """Judge whether an effect is larger in one group of trajectories than in the other."""
    if interval is None:
        return Ruling(UNDECIDED, "a group has fewer than two trajectories")
    if interval.high < 0.0:
        return Ruling(REPRODUCED)
    if interval.low > 0.0:
        return Ruling(OPPOSITE, "the interval lies on the other side")
    return Ruling(UNDECIDED, "the interval of the difference holds zero")


def cells_rule(held: Mapping[str, bool], pooled: Interval | None) -> Ruling:
    """Judge a statement about every cell of a grid.

    Args:
        held: Cell to whether the statement holds in it.
        pooled: Interval of the pooled effect, negative on the claimed side.
    """
    if pooled is None:
        return Ruling(UNDECIDED, "the pooled effect has no interval")
    if pooled.contains(0.0):
        return Ruling(UNDECIDED, "the interval of the pooled effect holds no effect")
    share = sum(held.values()) / len(held)
    failing = ", ".join(name for name, holds in held.items() if not holds)
    counted = f"holds in {sum(held.values())} of {len(held)} cells"
    if pooled.high < 0.0 and share == 1.0:
        return Ruling(REPRODUCED)
    if pooled.high < 0.0 and share >= MOST_CELLS:
        return Ruling(SMALLER, f"{counted}, not in {failing}")
    if pooled.low > 0.0 and share <= FEWEST_CELLS:
        return Ruling(OPPOSITE, f"{counted}, and the pooled effect is on the other side")
    return Ruling(NOT_REPRODUCED, counted)


def slope_rule(interval: Interval | None, scale: float) -> Ruling:
    """Judge the sign of a slope.

    Args:
        interval: Interval of the mean slope over trajectories, negative on the claimed side.
        scale: Mean of what the slope is of; a half-width below 2 % of it for each unit is no slope.
    """
    if interval is None:
        return Ruling(UNDECIDED, "one trajectory: the slope has no interval")
    if interval.high < 0.0:
        return Ruling(REPRODUCED)
    if interval.low > 0.0:
        return Ruling(OPPOSITE, "the interval of the slope lies on the other side")
    if (interval.high - interval.low) / 2.0 < FLAT * abs(scale):
        return Ruling(NOT_REPRODUCED, "the slope is zero within 2 % of the mean")
    return Ruling(UNDECIDED, "the interval of the slope holds zero and is wider than 2 % of the mean")


def time_rule(times: Sequence[float], printed: float, by_threshold: Sequence[Sequence[float]] = ()) -> Ruling:
    """Judge a time of recovery.

    Args:
        times: Time of each run or seed, infinite if it never came [s].
        printed: The printed time [s].
        by_threshold: The same at other thresholds of recovery; a conclusion that changes with them is none.
    """
    if not times:
        return Ruling(UNDECIDED, "no run has a time of recovery")
    words = {_time_word(found, printed) for found in by_threshold if found}
    if len(words) > 1:
        return Ruling(UNDECIDED, f"changes with the threshold of recovery: {', '.join(sorted(words))}")
    word = _time_word(times, printed)
    reasons = {SMALLER: "median beyond 1.5 times the printed time", NOT_REPRODUCED: "median beyond 3 times, or never"}
    return Ruling(word, reasons.get(word, ""))


def _time_word(times: Sequence[float], printed: float) -> Word:
    ordered = sorted(times)
    middle = ordered[len(ordered) // 2] if len(ordered) % 2 else sum(ordered[len(ordered) // 2 - 1 :][:2]) / 2.0
    if sum(map(math.isinf, times)) > 0.5 * len(times) or middle > 3.0 * printed:
        return NOT_REPRODUCED
    return REPRODUCED if middle <= 1.5 * printed else SMALLER


def count_rule(counts: Sequence[float], printed: int, *, stable: float, nulls: Mapping[str, Sequence[float]]) -> Ruling:
    """Judge a count of peaks.

    Args:
        counts: Count of each run.
        printed: The printed count.
        stable: Share of runs whose count does not depend on what is called a peak.
        nulls: Name to the counts of what should not have them: the motion without any event, a plain controller.
    """
    if not counts or any(not found for found in nulls.values()):
        without = [name for name, found in nulls.items() if not found]
        return Ruling(UNDECIDED, f"no counts of {', '.join(without)}" if counts else "no run has a count")
    if stable < OFTEN:
        return Ruling(
            UNDECIDED, f"in {100 * (1 - stable):.0f} % of the runs the count depends on what is called a peak"
        )
    usual, times = Counter(counts).most_common(1)[0]
    if usual != printed or times < OFTEN * len(counts):
        return Ruling(NOT_REPRODUCED, f"{usual:g} peaks in {times} of {len(counts)} runs")
    alike = [name for name, found in nulls.items() if Counter(found).most_common(1)[0][0] == printed]
    return Ruling(SMALLER, f"{', '.join(alike)} has as many") if alike else Ruling(REPRODUCED)


def correlation_rule(r: float, interval: Interval, printed: float, band: float) -> Ruling:
    """Judge a correlation against the printed one and a band around it."""
    if interval.contains(0.0):
        return Ruling(NOT_REPRODUCED, "the interval over blocks of a lap holds zero")
    if r * printed < 0.0:
        return Ruling(OPPOSITE, "the sign is the other one")
    if abs(r - printed) > band:
        return Ruling(SMALLER, f"more than {band:g} from the printed value")
    return Ruling(REPRODUCED)


def level_rule(value: float, low: float, high: float) -> Ruling:
    """Judge whether a value lies within limits, limits included."""
    if low <= value <= high:
        return Ruling(REPRODUCED)
    return Ruling(NOT_REPRODUCED, f"outside {low:.3g} to {high:.3g}")


def agreement_rule(pairs: Mapping[str, tuple[Word, Word]]) -> Ruling:
    """Judge whether claims have the same class of verdict in two conditions.

    Args:
        pairs: Claim to its word in each; what is reproduced and what is smaller are one class.
    """
    open_ones = [name for name, words in pairs.items() if {UNDECIDED, UNTESTABLE} & set(words)]
    if open_ones or not pairs:
        return Ruling(UNDECIDED, f"undecided: {', '.join(open_ones)}")
    different = [name for name, (a, b) in pairs.items() if _kind(a) != _kind(b)]
    if not different:
        return Ruling(REPRODUCED)
    share = 1.0 - len(different) / len(pairs)
    word = SMALLER if share >= MOST_CELLS else NOT_REPRODUCED
    return Ruling(word, f"{len(pairs) - len(different)} of {len(pairs)} agree, not {', '.join(different)}")


def _kind(word: Word) -> Word:
    return REPRODUCED if word == SMALLER else word
