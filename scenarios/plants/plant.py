r"""What all plants share: the arm's equations with rotor inertia, friction, load and the force sensor.

With rotor inertia A, friction f and a step h every plant moves by

.. math:: (M(q) + A + h \beta) \ddot q + h(q, \dot q) = \tau - f(\dot q), \quad
          \dot q^+ = \dot q + h \ddot q, \quad q^+ = q + h \dot q^+

Friction is linearly implicit: its secant slope beta acts as inertia over one step, so that a step never reverses a
velocity by friction. Pinocchio gives the acceleration; how it is integrated is the plant's own.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numba
import numpy as np
import pinocchio as pin

from ...controllers.kernels import bind
from ..body import Body
from ..robots import Robot
from ..tiers import Tier
from .motors import Motors


class Plant(ABC):
    """A simulated arm that takes joint torques, one control period at a time.

    Attributes:
        q: True joint positions, shape (n,) [rad]; refilled by every step.
        dq: True joint velocities, shape (n,) [rad/s].
        theta: True motor positions, shape (n,) [rad]; ``q`` itself where motor and link are one.
        dtheta: True motor velocities, shape (n,) [rad/s]; ``dq`` itself where motor and link are one.
        torque: What acted over the last step, before friction, shape (n,) [N m]; where joints are elastic, the mean of
            what their springs gave to the links.
        wrench: What hangs on the flange exerts this on the arm, flange axes at its origin, force before torque,
            shape (6,) [N, N m]; that of the last step.
        payload: The load beyond the gripper as ten parameters, shape (10,); refilled by :meth:`set_load`.
    """

    name: str

    def __init__(self, robot: Robot, tier: Tier, slots: Sequence[Body] = ()) -> None:
        """Build the plant.

        Args:
            robot: The arm.
            tier: Constants of drive and friction.
            slots: Bodies that the flange may carry, each switched on and off by :meth:`set_load`.
        """
        self.robot, self.tier, self.slots = robot, tier, tuple(slots)
        model = pin.buildModelFromXML(robot.urdf)
        model.armature = tier.rotor_inertia
        self.model, self.data = model, model.createData()
        self.q, self.dq, self.wrench = np.zeros(model.nv), np.zeros(model.nv), np.zeros(6)
        self.payload = np.zeros(10)
        flange = model.frames[model.getFrameId(robot.flange_frame)]
        self._joint, self._placement = flange.parentJoint, flange.placement.copy()
        self._bare_inertia = model.inertias[self._joint].copy()
        self._gripper = _combined(robot.gripper_bodies)
        self._spatial_inertia = np.zeros((6, 6))
        self._armature = model.armature
        self._drive = np.zeros(model.nv)
        self._torque = np.zeros(model.nv)
        self._motors = None if tier.elasticity is None else Motors(tier, tier.elasticity)
        self.theta, self.dtheta, self.torque = self.q, self.dq, self._torque
        if self._motors is not None:
            self.theta, self.dtheta, self.torque = self._motors.theta, self._motors.dtheta, self._motors.torque
        self._step, self._substeps = tier.step, range(tier.substeps)
        self._take_views()
        self._bind_kernels()
        self.set_load((False,) * len(self.slots))

    def _take_views(self) -> None:
        """Take the views of Pinocchio's results, once."""
        self._ddq = self.data.ddq
        acceleration, velocity = self.data.a_gf[self._joint], self.data.v[self._joint]
        # ABA's acceleration carries minus gravity, as a force sensor feels it.
        self._flange_motion = (acceleration.linear, acceleration.angular, velocity.linear, velocity.angular)
        self._flange_frame = (self._placement.rotation.copy(), self._placement.translation.copy())

    def _bind_kernels(self) -> None:
        """Fix the arguments of what every step calls."""
        tier = self.tier
        friction, constants = (tier.coulomb, tier.viscous, tier.rotor_inertia), (tier.coulomb_velocity, tier.period)
        if self._motors is None:
            self._resist = bind(_resist, self._torque, self.dq, friction, constants, self._drive, self._armature)
        else:
            self._resist = self._motors.bind(self._torque, self.q, self.dq, self._drive, self._armature)
        self._measure = bind(
            _wrench_on_arm, self._flange_motion, self._flange_frame, self._spatial_inertia, self.wrench
        )

    def set_load(self, active: Sequence[bool]) -> None:
        """Switch the slots; joint positions and velocities stay as they are.

        Args:
            active: For each slot whether its body is carried.
        """
        load = _combined([body for body, on in zip(self.slots, active, strict=True) if on])
        self.payload[:] = load.toDynamicParameters()
        self.model.inertias[self._joint] = self._bare_inertia + self._placement.act(load)
        np.copyto(self._spatial_inertia, (self._gripper + load).matrix())

    def reset(self, q: np.ndarray, dq: np.ndarray) -> None:
        """Place the arm.

        Args:
            q: Joint positions, shape (n,) [rad].
            dq: Joint velocities, shape (n,) [rad/s].
        """
        np.copyto(self.q, q)
        np.copyto(self.dq, dq)
        # The reading before the first step is the static one: the arm is held where it is placed.
        pin.aba(self.model, self.data, self.q, np.zeros(self.model.nv), self.gravity())
        self.measure_wrench()
        if self._motors is not None:
            self._motors.rest(self.q, self.dq, self.gravity())

    def gravity(self) -> np.ndarray:
        """Return the gravity torque with the load that is carried, shape (n,) [N m]."""
        return np.array(pin.computeGeneralizedGravity(self.model, self.data, self.q))

    def mass_matrix(self) -> np.ndarray:
        """Return the inertia that the joints have, rotors and load included, shape (n, n) [kg m^2]."""
        self._armature[:] = self.tier.rotor_inertia
        return np.array(pin.crba(self.model, self.data, self.q))

    def step(self, torque: np.ndarray) -> None:
        """Move on by one control period.

        Args:
            torque: What the drives produce, before friction; what torque loops are asked for where joints are
                elastic; shape (n,) [N m].
        """
        np.copyto(self._torque, torque)
        for _ in self._substeps:
            self._resist()
            pin.aba(self.model, self.data, self.q, self.dq, self._drive)
            self._integrate()
        self.measure_wrench()

    def measure_wrench(self) -> None:
        """Refill ``wrench`` from the flange's motion in the last dynamics pass."""
        self._measure()

    @abstractmethod
    def _integrate(self) -> None:
        """Advance ``q`` and ``dq`` by the tier's step from ``_drive``, ``_armature`` and ``_ddq``."""

    def close(self) -> None:  # noqa: B027 - most plants hold nothing
        """Release what the plant holds."""


def _combined(bodies: Sequence[Body]) -> pin.Inertia:
    """Return the spatial inertia of bodies about the flange origin."""
    total = pin.Inertia.Zero()
    for body in bodies:
        total = total + pin.Inertia(body.mass, np.asarray(body.com, dtype=float), np.asarray(body.inertia, dtype=float))
    return total


@numba.njit(cache=True)
def _resist(torque, dq, friction, constants, drive, armature):  # type: ignore[no-untyped-def]
    """Subtract friction from the torque; put rotor inertia and friction's secant slope into the armature."""
    coulomb, viscous, rotor_inertia = friction
    velocity_scale, period = constants
    for i in range(dq.shape[0]):
        speed = abs(dq[i])
        drive[i] = torque[i] - coulomb[i] * np.tanh(dq[i] / velocity_scale) - viscous[i] * dq[i]
        slope = viscous[i] + coulomb[i] / max(speed, velocity_scale)
        armature[i] = rotor_inertia[i] + period * slope


@numba.njit(cache=True)
def _wrench_on_arm(motion, frame, inertia, wrench):  # type: ignore[no-untyped-def]
    """Return minus (P a + v x* P v): what a body of spatial inertia P at the flange exerts on the arm."""
    rotation, position = frame
    a_linear, a_angular, v_linear, v_angular = motion
    acceleration, velocity, momentum = np.empty(6), np.empty(6), np.empty(6)
    _to_flange(rotation, position, a_linear, a_angular, acceleration)
    _to_flange(rotation, position, v_linear, v_angular, velocity)
    for i in range(6):
        force, p = 0.0, 0.0
        for j in range(6):
            force += inertia[i, j] * acceleration[j]
            p += inertia[i, j] * velocity[j]
        wrench[i] = -force
        momentum[i] = p
    v, w, f, m = velocity[:3], velocity[3:], momentum[:3], momentum[3:]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        wrench[i] -= w[j] * f[k] - w[k] * f[j]
        wrench[3 + i] -= w[j] * m[k] - w[k] * m[j] + v[j] * f[k] - v[k] * f[j]


@numba.njit(cache=True)
def _to_flange(rotation, position, linear, angular, out):  # type: ignore[no-untyped-def]
    """Express a spatial motion of the joint frame in the flange frame."""
    for i in range(3):
        total_linear, total_angular = 0.0, 0.0
        for j in range(3):
            k, m = (j + 1) % 3, (j + 2) % 3
            total_linear += rotation[j, i] * (linear[j] + angular[k] * position[m] - angular[m] * position[k])
            total_angular += rotation[j, i] * angular[j]
        out[i], out[3 + i] = total_linear, total_angular
