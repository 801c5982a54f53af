"""What travels between the modules: the ascending and the descending pathway as data.

Arrays are filled in place and handed on; a module reads what ascends to it and writes what descends from it.
Source: the paper's section on information pathways and its Algorithm 1.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(slots=True)
class Ascending:
    """Proprioception, touch and the plan, as one tick sees them.

    Attributes:
        q: Joint positions, shape (n,) [rad].
        dq: Joint velocities, shape (n,) [rad/s].
        q_desired: Planned positions, shape (n,) [rad].
        dq_desired: Planned velocities, shape (n,) [rad/s].
        wrench: Load on the flange, flange frame, force before torque, shape (6,) [N, N m].
    """

    q: np.ndarray
    dq: np.ndarray
    q_desired: np.ndarray
    dq_desired: np.ndarray
    wrench: np.ndarray

    @classmethod
    def of(cls, joints: int) -> "Ascending":
        """Return a pathway at rest."""
        return cls(*(np.zeros(size) for size in (joints, joints, joints, joints, 6)))


@dataclass(slots=True)
class Descending:
    """What the levels send down.

    Attributes:
        compensation: Gravity torques of the patterns, T_cb, third order, shape (patterns, n) [N m].
        weights: Weights of the patterns, w, second order, shape (patterns,).
        gravity_torque: Filtered mixture, tau_g, second order, shape (n,) [N m].
        stiffness: Feedback gains on position, K_P, second order, shape (n,) [N m/rad].
        damping: Feedback gains on velocity, K_V, second order, shape (n,) [N m s/rad].
        torque: Torque command, tau, first order, shape (n,) [N m].
    """

    compensation: np.ndarray
    weights: np.ndarray
    gravity_torque: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    torque: np.ndarray

    @classmethod
    def of(cls, joints: int, patterns: int) -> "Descending":
        """Return a pathway at rest."""
        return cls(
            compensation=np.zeros((patterns, joints)),
            weights=np.full(patterns, 1.0 / patterns),
            gravity_torque=np.zeros(joints),
            stiffness=np.zeros(joints),
            damping=np.zeros(joints),
            torque=np.zeros(joints),
        )
