"""Robustness margins: what is made worse, in which steps, and how far."""

from dataclasses import dataclass

import numpy as np

LOOP_RESPONSE = "loop_response"
"""The study that measures the loops of the joints in place of a margin."""

HOLD = "hold"
"""The motion at rest at the robot's home, on which loops are measured."""


@dataclass(frozen=True, kw_only=True)
class Margin:
    """One kind of margin.

    Attributes:
        id: Its name in tables.
        field: Field of :class:`~.perturbation.Perturbation` that is made worse.
        grid: Values of the field from the nominal one on, ever worse; neighbours are the margin's resolution apart.
        unit: Unit of the margin; a delay is given in seconds.
        resolution: The distance of neighbours in words.
        origin: Value of the field at which the margin is 0.
    """

    id: str
    field: str
    grid: tuple[float, ...]
    unit: str
    resolution: str
    origin: float = 0.0

    def of(self, step: int, period: float) -> float:
        """Return the margin at a step of the grid.

        Args:
            step: Place on the grid.
            period: Control period, the length of a tick of delay [s].
        """
        value = abs(self.grid[step] - self.origin)
        return round(value * period if self.field == "delay" else value, 9)

    def change(self, step: int) -> dict[str, float]:
        """Return the perturbation's field at a step of the grid by name."""
        value = self.grid[step]
        return {self.field: int(value) if self.field == "delay" else value}


def _steps(start: float, step: float, count: int) -> tuple[float, ...]:
    return tuple(round(float(value), 9) for value in start + step * np.arange(count + 1))


MARGINS = {
    margin.id: margin
    for margin in (
        Margin(id="load_margin", field="payload", grid=_steps(0.0, 0.1, 100), unit="kg", resolution="0.1 kg"),
        Margin(id="delay_margin", field="delay", grid=_steps(0.0, 1.0, 64), unit="s", resolution="1 tick"),
        Margin(id="gain_margin_up", field="gain", grid=_steps(1.0, 0.05, 80), unit="1", resolution="5 %", origin=1.0),
        Margin(
            id="gain_margin_down", field="gain", grid=_steps(1.0, -0.05, 20), unit="1", resolution="5 %", origin=1.0
        ),
        Margin(
            id="noise_margin",
            field="velocity_noise",
            grid=(0.0, *(float(f"{1e-3 * 1.5**power:.6g}") for power in range(24))),
            unit="rad/s",
            resolution="factor 1.5",
        ),
        Margin(id="friction_margin", field="friction", grid=_steps(1.0, 0.5, 78), unit="times", resolution="0.5"),
        Margin(id="init_offset_margin", field="offset", grid=_steps(0.0, 0.02, 49), unit="rad", resolution="0.02 rad"),
    )
}
"""Every margin by its name, in the order of tables."""

STUDIES = (*MARGINS, LOOP_RESPONSE)
"""What may stand in a benchmark's ``studies``."""
