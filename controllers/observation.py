"""What a controller is told about the arm at one tick."""

from dataclasses import dataclass

import numpy as np


@dataclass(slots=True)
class Observation:
    """Measurements at one tick, as the tier's sensors give them.

    The arrays are read-only views that the harness refills every tick: copy what has to be kept.

    Attributes:
        time: Seconds since the end of the lead-in; negative before [s].
        q: Measured joint positions, shape (n,) [rad].
        dq: Measured joint velocities, shape (n,) [rad/s].
        wrench: What hangs on the flange exerts this on the arm, flange axes at the flange origin, force before
            torque, gripper included, shape (6,) [N, N m]. Tool down at rest it reads (0, 0, m g, 0, 0, 0).
        command: The last command after the limiter, shape (n,) [N m]. What a perturbed drive does to it is not in it.
        torque: What acted at the joints in the last tick, after delay and lag, before friction, shape (n,) [N m];
            where joints are elastic, what their torque loops were asked for. With the published rotor inertia it is
            the right-hand side of M a + bias = tau. At the first tick both are the gravity torque of arm and gripper.
    """

    time: float
    q: np.ndarray
    dq: np.ndarray
    wrench: np.ndarray
    command: np.ndarray
    torque: np.ndarray
