"""What disturbs sensors and commands tick by tick; a run without it calls nothing of this."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbance:
    """Noise on the measured velocity, a wrong gain, and a torque added to the command.

    Attributes:
        velocity: Added to the measured velocities, shape (ticks, n) [rad/s].
        gain: Factor on what the controller returned.
        torque: Added after that and before the limiter, shape (ticks, n) [N m].
    """

    velocity: np.ndarray
    gain: float
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

    def on_command(self, end: Callable[[int], int], frame: np.ndarray, log: np.ndarray) -> Callable[[int], int]:
        """Return the end of a tick with gain and torque on the command; the log keeps what the controller returned.

        Args:
            end: Limits the frame's command, drives, and writes the log's row.
            frame: Record of the tick, shape (1,).
            log: The run's log.
        """
        command, commands, torque, gain = frame["command"][0], log["command"], self.torque, self.gain
        returned = np.zeros_like(command)

        def disturbed(k: int) -> int:
            returned[:] = command
            np.multiply(command, gain, out=command)
            np.add(command, torque[k], out=command)
            verdict = end(k)
            commands[k] = command[:] = returned
            return verdict

        return disturbed
