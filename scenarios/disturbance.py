"""What disturbs sensors and commands tick by tick; a run without it calls nothing of this."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbance:
    """Noise on the measured velocity, and a torque added to the command.

    Attributes:
        velocity: Added to the measured velocities, shape (ticks, n) [rad/s].
        torque: Added before the limiter, shape (ticks, n) [N m].
    """

    velocity: np.ndarray
    torque: np.ndarray

    def on_sensors(self, begin: Callable[[int], None], frame: np.ndarray) -> Callable[[int], None]:
        """Return the begin of a tick with noise on the velocity.

        Args:
            begin: Reads the sensors into the frame.
            frame: Record of the tick, shape (1,).
        """
        measured, velocity = frame["dq_measured"][0], self.velocity

        def noisy(k: int) -> None:
            begin(k)
            np.add(measured, velocity[k], out=measured)

        return noisy

    def on_command(self, end: Callable[[int], int], memory: np.ndarray) -> Callable[[int], int]:
        """Return the end of a tick with a torque on the command; the log keeps what the controller returned.

        Args:
            end: Limits the frame's command, drives, and writes the log's row.
            memory: What drives remember, shape (1,).
        """
        injection, torque = memory["injection"][0], self.torque

        def injected(k: int) -> int:
            injection[:] = torque[k]
            return end(k)

        return injected
