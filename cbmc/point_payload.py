"""The load that a motor pattern is made for: a point mass on the flange's z axis."""

import numpy as np


def point_payload(mass: float, centre: float) -> np.ndarray:
    """Return a point mass on the flange's z axis as ten parameters.

    Gravity knows mass and centre of a load and nothing else.

    Args:
        mass: Mass [kg].
        centre: Its place along z of the flange [m].

    Returns:
        Mass, first moments and inertia about the flange origin, shape (10,), as ``RobotModel.payload`` orders them.
    """
    inertia = mass * centre**2
    return np.array([mass, 0.0, 0.0, mass * centre, inertia, 0.0, inertia, 0.0, 0.0, 0.0])
