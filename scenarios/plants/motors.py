"""The motor side of an arm with elastic joints: rotors behind springs and the torque loop around them."""

from collections.abc import Callable

import numba
import numpy as np

from ...controllers.kernels import bind
from ..elasticity import Elasticity
from ..tiers import Tier


class Motors:
    """The rotors of one arm.

    Attributes:
        theta: Motor positions at the joint's side of the gear, shape (n,) [rad].
        dtheta: Motor velocities, shape (n,) [rad/s].
        torque: Mean torque of the springs over the last control period, shape (n,) [N m].
    """

    def __init__(self, tier: Tier, elasticity: Elasticity) -> None:
        """Build the rotors of a tier with elastic joints."""
        n = elasticity.stiffness.shape[0]
        self.theta, self.dtheta, self.torque = np.zeros(n), np.zeros(n), np.zeros(n)
        self._current, self._substep = np.zeros(n), np.zeros(1, np.int64)
        self._tier, self._elasticity = tier, elasticity

    def bind(
        self, asked: np.ndarray, q: np.ndarray, dq: np.ndarray, drive: np.ndarray, armature: np.ndarray
    ) -> Callable[[], None]:
        """Return what does one integration step of all motors and fills the torque on the links.

        Args:
            asked: Torque that the torque loops are asked for, shape (n,) [N m].
            q: Link positions, shape (n,) [rad].
            dq: Link velocities, shape (n,) [rad/s].
            drive: Torque on the links, refilled [N m].
            armature: Rotor inertia that the links carry, set to zero: the rotors move on their own [kg m^2].
        """
        tier, joints = self._tier, self._elasticity
        motors = (self.theta, self.dtheta, self._current, self.torque, self._substep)
        rows = (joints.stiffness, joints.damping, joints.motor_inertia, joints.rate_gain, tier.coulomb, tier.viscous)
        share = joints.current_share(tier.step)
        scalars = (joints.torque_gain, share, tier.coulomb_velocity, tier.step, joints.substeps)
        return bind(_turn, asked, q, dq, motors, rows, scalars, drive, armature)

    def rest(self, q: np.ndarray, dq: np.ndarray, torque: np.ndarray) -> None:
        """Let the springs carry a torque, the motors turn with the links.

        Args:
            q: Link positions, shape (n,) [rad].
            dq: Link velocities, shape (n,) [rad/s].
            torque: What the springs carry, shape (n,) [N m].
        """
        self.theta[:] = q + torque / self._elasticity.stiffness
        self.dtheta[:] = dq
        self._current[:] = self.torque[:] = torque
        self._substep[:] = 0


@numba.njit(cache=True)
def _turn(asked, q, dq, motors, rows, scalars, drive, armature):  # type: ignore[no-untyped-def]
    """Move all motors by one integration step; the springs' torque is that of its beginning, on both sides."""
    theta, dtheta, current, mean, substep = motors
    stiffness, damping, inertia, rate_gain, coulomb, viscous = rows
    torque_gain, current_share, velocity_scale, step, substeps = scalars
    if substep[0] == 0:
        mean[:] = 0.0
    for i in range(theta.shape[0]):
        slip = dtheta[i] - dq[i]
        spring = stiffness[i] * (theta[i] - q[i]) + damping[i] * slip
        wanted = asked[i] + torque_gain * (asked[i] - spring) - rate_gain[i] * stiffness[i] * slip
        current[i] += current_share * (wanted - current[i])
        # Friction's secant slope acts as inertia over one step, so that a step never reverses a velocity by friction.
        friction = coulomb[i] * np.tanh(dtheta[i] / velocity_scale) + viscous[i] * dtheta[i]
        slope = viscous[i] + coulomb[i] / max(abs(dtheta[i]), velocity_scale)
        dtheta[i] += step * (current[i] - spring - friction) / (inertia[i] + step * slope)
        theta[i] += step * dtheta[i]
        drive[i], armature[i] = spring, 0.0
        mean[i] += spring / substeps
    substep[0] = (substep[0] + 1) % substeps
