"""Error by lap as a figure: who wins depends on how long one learns."""

import numpy as np

from ..metrics import METRICS
from .charts import Axis, Chart, Curve, around
from .few import few
from .findings import HEADLINES, Findings
from .numbers import significant, unit_on_page
from .sentences import SUBJECTS

FEW_LAPS = 3
"""Up to so many laps the table is enough."""
MOST_CURVES = 12


def lap_charts(findings: Findings) -> list[Chart]:
    """Return the headline errors by lap on logarithmic axes; empty for a few laps.

    Args:
        findings: The world's findings.
    """
    laps = int(findings.world.facts["Laps"])
    return [chart for metric in HEADLINES if (chart := _chart(findings, metric, laps))] if laps > FEW_LAPS else []


def _chart(findings: Findings, metric: str, laps: int) -> Chart | None:
    shown, subject = unit_on_page(METRICS[metric].unit), SUBJECTS[metric]
    found = {label: np.array(means) * shown.factor for label, means in findings.by_lap.get(metric, {}).items()}
    able = {label: means for label, means in found.items() if (means > 0.0).all()}
    labels, which = few(findings, list(able), MOST_CURVES)
    if not labels:
        return None
    listed = [(label, able[label]) for label in labels]
    numbers = np.arange(1.0, laps + 1.0)
    curves = [Curve(label=label, x=numbers, y=means, style=i, dots=True) for i, (label, means) in enumerate(listed)]
    words = "; ".join(
        f"{label}: {significant(float(means[0]))} in lap 1, {significant(float(means[-1]))} in lap {laps}"
        for label, means in listed
    )
    return Chart(
        id=f"{findings.world.id}-by-lap-{subject}",
        title=f"Mean {subject} error by lap{which}",
        description=f"Mean over the runs in the common cells that finished, in {shown.text}, on two logarithmic axes. "
        + words,
        x=Axis("lap, logarithmic", 1.0, float(laps) * 1.02, log=True),
        y=around(f"mean {subject} error [{shown.text}], logarithmic", [curve.y for curve in curves], log=True),
        curves=curves,
        direct=True,
        width=600,
        height=max(300, 60 + 14 * len(curves)),
    )
