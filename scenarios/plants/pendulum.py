"""A liquid's pendulum in a plant: two joints below the flange without inertia of their own, and a point mass.

While its liquid is not there the point mass is zero and the joints have an inertia of their own, so that they neither
move nor act: an arm with an idle pendulum goes the same way, to the bit, as an arm without one.
"""

import numba
import numpy as np
import pinocchio as pin

from ...controllers.kernels import bind
from ..liquid import Liquid
from ..robots import slosh_names


class Pendulum:
    """One liquid in a Pinocchio model.

    Attributes:
        liquid: The liquid.
        slot: Its number among the slots of the plant.
        joints: The positions of its two joints in the model's vectors, about x and y of the flange.
        active: Whether the liquid is there.
    """

    def __init__(self, model: pin.Model, flange: pin.Frame, slot: int, liquid: Liquid) -> None:
        """Hang the pendulum on a model whose data are not made yet.

        Args:
            model: The arm; gets two joints more.
            flange: Where it hangs.
            slot: Number of the liquid among the slots.
            liquid: The liquid.
        """
        self.liquid, self.slot, self.active = liquid, slot, False
        hinge = flange.placement * pin.SE3(np.eye(3), np.array([0.0, 0.0, liquid.hinge_z]))
        about_x, about_y = slosh_names(slot)
        across = model.addJoint(flange.parentJoint, pin.JointModelRX(), hinge, about_x)
        self._joint = model.addJoint(across, pin.JointModelRY(), pin.SE3.Identity(), about_y)
        first = model.idx_vs[across]
        self.joints = slice(first, first + 2)

    def bind(self, data: pin.Data, state: tuple[np.ndarray, np.ndarray], drive: np.ndarray, wrench: np.ndarray) -> None:
        """Fix the arguments of what every step calls, :meth:`resist` and :meth:`add_to_wrench`.

        Args:
            data: Results of the model.
            state: Positions and velocities of all joints, each of shape (n + 2 k,) [rad, rad/s].
            drive: Torques on all joints, shape (n + 2 k,) [N m].
            wrench: The force sensor's reading, shape (6,) [N, N m].
        """
        acceleration, velocity = data.a_gf[self._joint], data.v[self._joint]
        motion = (acceleration.linear, acceleration.angular, velocity.linear, velocity.angular)
        angles, rates = (part[self.joints] for part in state)
        self._bob = np.array([0.0, self.liquid.length, self.liquid.hinge_z])
        self.resist = bind(_resist, rates, self.liquid.damping, drive[self.joints])
        self.add_to_wrench = bind(_bob_on_arm, motion, angles, self._bob, wrench)

    def switch(self, model: pin.Model, *, active: bool, step: float) -> None:
        """Put the liquid in or take it away.

        Args:
            model: The model on which it hangs.
            active: Whether it is there.
            step: Integration step [s].
        """
        self.active = active
        self._bob[0] = mass = self.liquid.bob_mass if active else 0.0
        place = np.array([0.0, 0.0, self.liquid.length])
        model.inertias[self._joint] = pin.Inertia(mass, place, np.zeros((3, 3)))
        # Damping is linearly implicit, as friction is. An idle joint has no other inertia: any will do.
        model.armature[self.joints] = step * self.liquid.damping if active else 1.0

    def rest(self, down: np.ndarray) -> tuple[float, float]:
        """Return the angles at which the pendulum hangs, zero while the liquid is not there [rad].

        Args:
            down: Direction of gravity in flange axes, shape (3,).
        """
        x, y, z = down
        return (float(np.arctan2(-y, z)), float(np.arcsin(x))) if self.active else (0.0, 0.0)


@numba.njit(cache=True)
def _resist(rates, damping, drive):  # type: ignore[no-untyped-def]
    """Fill the torque of the liquid's damping."""
    for i in range(2):
        drive[i] = -damping * rates[i]


@numba.njit(cache=True)
def _bob_on_arm(motion, angles, bob, wrench):  # type: ignore[no-untyped-def]
    """Add minus m (a - g) of the bob, and its moment about the flange's origin, in flange axes."""
    a_linear, a_angular, v_linear, v_angular = motion
    mass, length, hinge = bob
    arm = np.array([0.0, 0.0, length])
    # The joint's acceleration carries minus gravity, and is spatial: w x v makes it that of a point.
    speed = v_linear + np.cross(v_angular, arm)
    force = -mass * (a_linear + np.cross(a_angular, arm) + np.cross(v_angular, speed))
    (sin_x, sin_y), (cos_x, cos_y) = np.sin(angles), np.cos(angles)
    along = cos_y * force[2] - sin_y * force[0]
    x, y, z = cos_y * force[0] + sin_y * force[2], cos_x * force[1] - sin_x * along, sin_x * force[1] + cos_x * along
    r_x, r_y, r_z = length * sin_y, -length * sin_x * cos_y, hinge + length * cos_x * cos_y
    wrench[0] += x
    wrench[1] += y
    wrench[2] += z
    wrench[3] += r_y * z - r_z * y
    wrench[4] += r_z * x - r_x * z
    wrench[5] += r_x * y - r_y * x
