"""Which of many controllers a figure shows that cannot show all."""

from collections.abc import Sequence

from .findings import Findings
from .worlds import SPIKING


def few(findings: Findings, able: Sequence[str], most: int) -> tuple[list[str], str]:
    """Return the labels to show and words for the title, empty where all are shown.

    The spiking controller is always among them.

    Args:
        findings: The world's findings.
        able: Labels that could be shown, the best first.
        most: How many may be.
    """
    if len(able) <= most:
        return list(able), ""
    controllers = {label: findings.runs_of(label)[0].stored.specification.controller for label in able[most:]}
    spiking = [label for label, controller in controllers.items() if controller == SPIKING][:1]
    first = list(able[: most - len(spiking)])
    return [*first, *spiking], f": the first {len(first)} of {len(able)}{''.join(f' and {name}' for name in spiking)}"
