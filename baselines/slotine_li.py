"""Slotine and Li's adaptive law: the load is learnt from the tracking error, with a proof."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numba
import numpy as np

from ..controllers import Controller, DesignInertia, InvalidInput, LedgerEntry, Observation, RobotModel, Target, Task
from .payload_regressor import ALL, MASS_AND_MOMENT, PayloadRegressor
from .rest import tick_at_rest
from .settings import require_not_negative, require_positive

LARGEST_MASS, ARM = 5.0, 0.3
"""A large load [kg], and how far it extends from the flange [m]: bounds of the projection, scale of the learning."""

SCALE = np.array([1.0, *(ARM,) * 3, *(ARM**2,) * 6])
"""Inertial parameters of 1 kg at that distance, by magnitude [kg, kg m, kg m^2]."""

NOT_NEGATIVE = (0, 4, 6, 9)
"""Mass and moments of inertia among the ten parameters; the others may have either sign."""

TUNED_GAIN, TRIALS = 20.0, 13
"""Learning gain of the mass that was searched [kg^2/(N m)], and how many sets of gain and parameters were tried."""


@dataclass(kw_only=True)
class SlotineLi(Controller):
    r"""Adaptive passivity-based control of arm and unknown payload.

    .. math:: s = \dot e + \lambda e, \quad \dot q_r = \dot q_d + \lambda e, \quad
        \ddot q_r = \ddot q_d + \lambda \dot e

    .. math:: \tau = M \ddot q_r + C(q, \dot q) \dot q_r + g + Y_\phi \hat\phi + K_D s, \quad
        \dot{\hat\phi} = \Gamma Y_\phi^T s

    M, C, g are the known part; phi are the inertial parameters of what the model lacks. With
    :math:`V = \tfrac12 s^T M_{true} s + \tfrac12 \tilde\phi^T \Gamma^{-1} \tilde\phi` the law gives
    :math:`\dot V = -s^T K_D s`. K_D = lambda M(q) is positive definite, and makes the arm of known load the critically
    damped double integrator of computed torque at the same bandwidth. Rotational inertia is learnt too: on paths of
    constant orientation the plan does not show it, but the feedback does, and four parameters alone ring on a light
    wrist (62 mrad in place of 4 on T6 with 3.5 kg and no rotors).
    Source: Slotine, Li, On the adaptive control of robot manipulators, Int. J. Robotics Research 6 (1987).

    Attributes:
        bandwidth: lambda [rad/s].
        mass_gain: Gamma's entry for the mass; those of the other parameters follow from a length of 0.3 m [kg^2/(N m)].
        parameters: How many of the load's inertial parameters are learnt: 10, or 4 for mass and first moment.
    """

    estimates_load: ClassVar[bool] = True

    bandwidth: float = 20.0
    mass_gain: float = TUNED_GAIN
    parameters: int = ALL

    def __post_init__(self) -> None:
        """Check the settings."""
        require_positive("bandwidth", self.bandwidth)
        require_not_negative("mass_gain", self.mass_gain)
        if type(self.parameters) is not int or self.parameters not in (MASS_AND_MOMENT, ALL):
            raise InvalidInput(f"{self.parameters!r} parameters", "setting 'parameters'", "expected 4 or 10")

    def reset(self, task: Task) -> None:
        """Take the model and forget what was learnt."""
        self.robot, self.initial_q = task.robot, task.initial_q.copy()
        n = task.robot.n
        self.regressor, self.dynamics = PayloadRegressor(task.robot, self.parameters), MixedDynamics(task.robot)
        self.estimate = np.zeros(self.parameters)
        self.gain = self.mass_gain * SCALE[: self.parameters] ** 2
        self._rate = self.gain * task.period
        self._upper = LARGEST_MASS * SCALE[: self.parameters]
        self._lower = -self._upper
        self._lower[[k for k in NOT_NEGATIVE if k < self.parameters]] = 0.0
        self._slide, self._velocity, self._acceleration, self._drive = (np.zeros(n) for _ in range(4))
        self.compute(*tick_at_rest(task))
        self.estimate[:] = 0.0

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        q, dq = observation.q, observation.dq
        goal = target.q, target.dq, target.ddq
        slide, velocity, acceleration, drive = self._slide, self._velocity, self._acceleration, self._drive
        refer(q, dq, goal, self.bandwidth, slide, velocity, acceleration, drive)
        regressor = self.regressor.fill(q, dq, velocity, acceleration)
        torque = self.dynamics.torque(q, dq, velocity, drive)
        adapt(regressor, slide, self._rate, self._lower, self._upper, self.robot.payload, self.estimate, torque)
        return torque

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return the load that the model lacks: shape (4,) or (10,) [kg, kg m, kg m^2], every 10 ticks."""
        return {"estimate": (self.estimate, 10)}

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from."""
        bounds = f"known and learnt together within {LARGEST_MASS:g} kg at {ARM:g} m, mass not negative"
        slope = "lambda, K_D = lambda M: the double pole of computed torque [rad/s]"
        scale = f"Gamma: mass_gain times (1, ({ARM:g} m)^2, ({ARM:g} m)^4)"
        return (
            LedgerEntry(setting="bandwidth", value=self.bandwidth, source="chosen", note=slope),
            _searched("mass_gain", self.mass_gain, TUNED_GAIN, f"[kg^2/(N m)]; {bounds}"),
            _searched("parameters", self.parameters, ALL, "10 with inertia, 4 without"),
            LedgerEntry(setting="gain", value=self.gain.tolist(), source="rule", note=scale),
        )

    def design_inertia(self) -> DesignInertia:
        """Return the model's mass matrix at the start: lambda from the slide's slope and lambda from K_D damp it."""
        return DesignInertia(mass_matrix=self.robot.mass_matrix(self.initial_q), damping=2.0 * self.bandwidth)


def _searched(setting: str, value: float, tuned: float, note: str) -> LedgerEntry:
    """Return the origin of a setting: tuned where it is what the search found."""
    if value != tuned:
        return LedgerEntry(setting=setting, value=value, source="chosen", note=note)
    note = f"T1 and T6 with 3.5 kg; {note}"
    return LedgerEntry(setting=setting, value=value, source="tuned", trials=TRIALS, note=note)


class MixedDynamics:
    r"""Inverse dynamics with two velocities, by polarisation of Pinocchio's with one.

    .. math:: M a + C(q, \dot q) \dot q_r + g = f(q, 0, a) + \tfrac14 [f(q, \dot q + \dot q_r, 0)
        - f(q, \dot q - \dot q_r, 0)]

    C is the matrix of Christoffel symbols, so that dM/dt - 2 C is skew: the only symmetric bilinear form whose square
    is the velocity term.
    """

    def __init__(self, robot: RobotModel) -> None:
        """Prepare for one arm.

        Args:
            robot: The arm; its payload and disturbance enter as they do in its inverse dynamics.
        """
        self.robot = robot
        self._sum, self._difference, self._still, self._torque = (np.zeros(robot.n) for _ in range(4))

    def torque(self, q: np.ndarray, dq: np.ndarray, dq_r: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
        """Return the torque, shape (n,) [N m]; an own buffer, valid until the next call.

        Args:
            q: Joint positions, shape (n,) [rad].
            dq: Joint velocities, shape (n,) [rad/s].
            dq_r: Reference velocities, shape (n,) [rad/s].
            acceleration: a, shape (n,) [rad/s^2].
        """
        torque, still, dynamics = self._torque, self._still, self.robot.inverse_dynamics
        np.add(dq, dq_r, out=self._sum)
        np.subtract(dq, dq_r, out=self._difference)
        np.copyto(torque, dynamics(q, self._sum, still))
        torque -= dynamics(q, self._difference, still)
        torque *= 0.25
        torque += dynamics(q, still, acceleration)
        return torque


@numba.njit(cache=True)
def refer(
    q: np.ndarray,
    dq: np.ndarray,
    goal: tuple[np.ndarray, np.ndarray, np.ndarray],
    slope: float,
    slide: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    drive: np.ndarray,
) -> None:
    r"""Write the reference motion and the slide.

    Args:
        q: Joint positions, shape (n,) [rad].
        dq: Joint velocities, shape (n,) [rad/s].
        goal: The plan's positions, velocities and accelerations, each of shape (n,).
        slope: lambda [rad/s].
        slide: Receives s, shape (n,) [rad/s].
        velocity: Receives the reference velocity, shape (n,) [rad/s].
        acceleration: Receives the reference acceleration, shape (n,) [rad/s^2].
        drive: Receives the reference acceleration plus lambda s, shape (n,) [rad/s^2].
    """
    for i in range(q.shape[0]):
        error, error_rate = goal[0][i] - q[i], goal[1][i] - dq[i]
        slide[i] = error_rate + slope * error
        velocity[i] = goal[1][i] + slope * error
        acceleration[i] = goal[2][i] + slope * error_rate
        drive[i] = acceleration[i] + slope * slide[i]


@numba.njit(cache=True)
def adapt(
    regressor: np.ndarray,
    slide: np.ndarray,
    rate: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    known: np.ndarray,
    estimate: np.ndarray,
    torque: np.ndarray,
) -> None:
    r"""Add the estimated load's torque, then learn and project onto what a load can be.

    .. math:: \tau \leftarrow \tau + Y \hat\phi, \quad \hat\phi \leftarrow P(\hat\phi + h \Gamma Y^T s)

    The bounds hold for known and estimated load together. They are a box and Gamma is diagonal, so clipping never
    leads away from a true load inside them, and V still falls.

    Args:
        regressor: Y, shape (n, p) [N m/kg, N m/(kg m), N m/(kg m^2)].
        slide: s, shape (n,) [rad/s].
        rate: h times Gamma's diagonal, shape (p,).
        lower: Lower bounds, shape (p,) [kg, kg m, kg m^2].
        upper: Upper bounds, shape (p,).
        known: The model's payload, shape (10,).
        estimate: Estimated parameters, changed in place, shape (p,).
        torque: Changed in place, shape (n,) [N m].
    """
    for k in range(estimate.shape[0]):
        push = 0.0
        for i in range(slide.shape[0]):
            torque[i] += regressor[i, k] * estimate[k]
            push += regressor[i, k] * slide[i]
        total = known[k] + estimate[k] + rate[k] * push
        estimate[k] = min(max(total, lower[k]), upper[k]) - known[k]
