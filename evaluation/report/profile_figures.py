"""Performance profiles as figures: the whole distribution behind a ratio, failures included."""

import numpy as np

from ..errors import NothingToCompare
from ..profiles import MULTIPLES, Profile, score_profile
from .charts import Axis, Chart, Curve
from .few import few
from .findings import HEADLINES, WINDOW, Findings
from .sentences import SUBJECTS

MOST_PROFILES = 6
"""Controllers of a figure; more lines cannot be told apart."""


def profile_charts(findings: Findings) -> list[Chart]:
    """Return the share of runs within each multiple of the reference's error, a chart for each headline metric.

    Args:
        findings: The world's findings; empty if nothing is compared in it.
    """
    return [chart for metric in HEADLINES if (chart := _chart(findings, metric)) is not None]


def _chart(findings: Findings, metric: str) -> Chart | None:
    """Return the chart of a metric; None if the reference has no value to be a multiple of, or nothing is compared."""
    world, subject = findings.world, SUBJECTS[metric]
    able = [label for label in findings.order if label in findings.comparisons[metric]]
    labels, which = few(findings, able, MOST_PROFILES)
    try:
        found = [score_profile(world.rows, label, world.reference, metric, WINDOW) for label in labels]
    except NothingToCompare:
        return None
    if not found:
        return None
    bands = len(found) <= 2
    curves = [
        Curve(label=p.controller, x=MULTIPLES, y=100.0 * p.share, style=i, band=_band(p) if bands else None)
        for i, p in enumerate(found)
    ]
    at_one = int(abs(MULTIPLES - 1.0).argmin())
    words = "; ".join(f"{p.controller}: {100.0 * p.share[at_one]:.0f} %" for p in found)
    return Chart(
        id=f"{world.id}-profile-{subject}",
        title=f"Share of runs within a multiple of the {subject} error of {world.reference}{which}",
        description=f"A failed run is within none. Within the reference's own mean error in the same cell: {words}",
        x=Axis(
            "multiple of the reference's mean error in the cell, logarithmic", MULTIPLES[0], MULTIPLES[-1], log=True
        ),
        y=Axis("share of runs [%]", 0.0, 104.0),
        curves=curves,
    )


def _band(profile: Profile) -> tuple[np.ndarray, np.ndarray] | None:
    return None if profile.band is None else (100.0 * profile.band[0], 100.0 * profile.band[1])
