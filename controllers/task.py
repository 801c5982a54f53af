"""What a controller is told once, before an episode."""

from dataclasses import dataclass

import numpy as np

from .robot_model import RobotModel
from .target import Reference


@dataclass(frozen=True, kw_only=True)
class Actuation:
    """The tier's published facts about the drives, equal for all controllers.

    Attributes:
        tier: Name of the tier.
        delay_ticks: Ticks between command and torque.
        torque_lag: Time constant of the torque loop, 0 if there is none [s]; of the current loop where joints are
            elastic.
        velocity_filter_hz: Corner of the velocity filter, None if velocity is exact [Hz].
        effort: Torque limits, shape (n,) [N m].
        torque_rate: Torque rate limits, shape (n,), None if the tier has none [N m/s].
        rotor_inertia: Apparent rotor inertia at the joints, shape (n,) [kg m^2].
        joint_stiffness: Stiffness between motor and link, shape (n,), None where they are one [N m/rad]. Where they
            are not, measured positions are the links' and measured velocities the motors'.
    """

    tier: str
    delay_ticks: int
    torque_lag: float
    velocity_filter_hz: float | None
    effort: np.ndarray
    torque_rate: np.ndarray | None
    rotor_inertia: np.ndarray
    joint_stiffness: np.ndarray | None = None


@dataclass(frozen=True, kw_only=True)
class Task:
    """One episode, as far as a controller may know it.

    Attributes:
        robot: The model of arm and gripper, with whatever payload the knowledge level grants.
        reference: The plan.
        actuation: The tier's published facts.
        period: Time between two calls of ``compute`` [s].
        duration: Time from the end of the lead-in to the end of the episode [s].
        initial_q: Joint positions at the first tick, shape (n,) [rad].
        seed: Seed of the controller's own random stream.
        knowledge: Name of the knowledge level.
        repetition: Number of the repetition, from 0.
    """

    robot: RobotModel
    reference: Reference
    actuation: Actuation
    period: float
    duration: float
    initial_q: np.ndarray
    seed: int
    knowledge: str
    repetition: int = 0
