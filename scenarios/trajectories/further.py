r"""Sixteen further motions, drawn by a rule that knows nothing of any controller.

Candidate k is a closed Fourier path of three harmonics from the random stream (seed, k). The first sixteen candidates
that stay in the space of T1 to T8 and use at most a share of the arm are M1 to M16; ``data/further_motions.toml`` holds
them, rounded as the rule rounds, so that another version of NumPy's generator moves none.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import count, islice

import numpy as np

from ...controllers import InvalidInput
from ..loads import Payload
from ..robots import Robot
from .feasibility import Allowance, Motion, check_motion
from .kinematics import Lap, solve_lap
from .paths import HarmonicPath, fourier

SEED = 1
COUNT = 16
HARMONICS = 3
GROUP = "further"
REACH, TURN, HEIGHT = (0.34, 0.82), (-33.0, 98.0), (-0.2, 0.5)
"""The space that T1 to T8 span about the base's axis: distance [m], azimuth [deg], height [m]."""
PERIOD = (2.0, 4.0)
"""Shortest and longest period; T1 to T8 have 2 to 4 [s]."""
EXTENT = (0.14, 0.20)
"""Largest distance from the centre; T1 to T8 have 0.14 to 0.20 [m]."""
ALLOWED = Allowance(room=0.3, share=0.7, singular=0.1)
"""What a motion may use of the arm with :data:`LOAD` and the rotor inertia of most tiers."""
LOAD = Payload(mass=3.5, material="sand")
ROTOR_SHARE = 1.0 / 3.0
STEP = 0.01
"""Spacing at which candidates are judged [s]; the tests judge the sixteen at a millisecond."""


def candidate(number: int) -> HarmonicPath:
    r"""Return a candidate, tool down; harmonic h is a normal draw divided by h squared, all scaled to the extent.

    Args:
        number: Number k of the candidate, from 0.
    """
    rng = np.random.default_rng((SEED, number))
    period = round(float(rng.uniform(*PERIOD)), 1)
    reach, turn, height = (rng.uniform(*span) for span in (REACH, np.deg2rad(TURN), HEIGHT))
    order = np.arange(1, HARMONICS + 1)
    draws = rng.standard_normal((2, HARMONICS, 3)) / order[:, None] ** 2
    angles = np.outer(np.arange(0.0, 1.0, 1e-3), 2.0 * np.pi * order)
    shape = np.cos(angles) @ draws[0] + np.sin(angles) @ draws[1]
    cosine, sine = np.round(draws * rng.uniform(*EXTENT) / np.linalg.norm(shape, axis=1).max(), 4).tolist()
    centre = np.round((reach * np.cos(turn), reach * np.sin(turn), height), 3).tolist()
    return fourier(name=f"candidate {number}", period=period, centre=centre, cosine=cosine, sine=sine, group=GROUP)


def inside(path: HarmonicPath) -> bool:
    """Return whether a path stays in the space of T1 to T8."""
    x, y, z = path.pose(np.arange(0.0, path.period, STEP))[:, :3, 3].T
    spans = ((np.hypot(x, y), REACH), (np.rad2deg(np.arctan2(y, x)), TURN), (z, HEIGHT))
    return all(low <= values.min() and values.max() <= high for values, (low, high) in spans)


def draw_further(robot: Robot) -> tuple[HarmonicPath, ...]:
    """Draw M1 to M16 again; takes some seconds.

    Args:
        robot: The Rizon 4s; another arm gives other motions.
    """
    found = islice(_accepted(robot), COUNT)
    return tuple(replace(path, name=f"M{place}") for place, path in enumerate(found, start=1))


def _accepted(robot: Robot) -> Iterator[HarmonicPath]:
    """Yield the candidates that the rule takes, in their order."""
    for path in filter(inside, map(candidate, count())):
        try:
            lap = solve_lap(robot.model(), path, home=robot.home, step=STEP)
            check_motion(motion_of(robot, path.name, lap, step=STEP), ALLOWED)
        except InvalidInput:
            continue
        yield path


def motion_of(robot: Robot, name: str, lap: Lap, *, step: float) -> Motion:
    """Return a lap as the rule judges it: with 3.5 kg of sand and a third of the rotor inertia."""
    inertia = ROTOR_SHARE * robot.rotor_inertia
    return Motion(name=name, lap=lap, step=step, robot=robot, load=LOAD, rotor_inertia=inertia)
