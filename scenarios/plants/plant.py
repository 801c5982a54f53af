r"""What all plants share: the arm's equations with rotor inertia, friction, load and the force sensor.

With rotor inertia A, friction f and a step h every plant moves by

.. math:: (M(q) + A + h \beta) \ddot q + h(q, \dot q) = \tau - f(\dot q), \quad
          \dot q^+ = \dot q + h \ddot q, \quad q^+ = q + h \dot q^+

Friction is linearly implicit: its secant slope beta acts as inertia over one step, so that a step never reverses a
velocity by friction. Pinocchio gives the acceleration; how it is integrated is the plant's own.

A liquid on the flange adds two joints, see :mod:`~torquebench.scenarios.plants.pendulum`; they obey the same
equations, its damping stands where friction does.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numba
import numpy as np
import pinocchio as pin

from ...controllers import InvalidInput
from ...controllers.kernels import bind
from ..body import Body
from ..liquid import Liquid
from ..robots import Robot
from ..tiers import Tier
from .motors import Motors
from .pendulum import Pendulum

MOST_TILT = 60.0
"""Tilt of the container beyond which no run with a liquid begins [deg]."""


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
        payload: The load beyond the gripper as ten parameters, liquids frozen at rest, shape (10,); refilled by
            :meth:`set_load`.
        positions: Positions of all joints, the arm's and two of each liquid's pendulum, shape (n + 2 k,) [rad].
        velocities: Their velocities, shape (n + 2 k,) [rad/s].
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
        flange = model.frames[model.getFrameId(robot.flange_frame)]
        liquids = [(slot, body) for slot, body in enumerate(self.slots) if isinstance(body, Liquid)]
        self.pendulums = tuple(Pendulum(model, flange, slot, liquid) for slot, liquid in liquids)
        self.model, self.data = model, model.createData()
        self.positions, self.velocities = np.zeros(model.nv), np.zeros(model.nv)
        self.q, self.dq = self.positions[: robot.n], self.velocities[: robot.n]
        self.payload, self.wrench = np.zeros(10), np.zeros(6)
        self._joint, self._placement = flange.parentJoint, flange.placement.copy()
        self._bare_inertia = model.inertias[self._joint].copy()
        self._gripper = _combined(robot.gripper_bodies)
        self._spatial_inertia = np.zeros((6, 6))
        self._armature = model.armature
        self._armature[: robot.n] = tier.rotor_inertia
        self._drive, self._torque = np.zeros(model.nv), np.zeros(robot.n)
        self._motors = None if tier.elasticity is None else Motors(tier, tier.elasticity)
        self.theta, self.dtheta, self.torque = self.q, self.dq, self._torque
        if self._motors is not None:
            self.theta, self.dtheta, self.torque = self._motors.theta, self._motors.dtheta, self._motors.torque
        self._step = tier.step
        self._is_last = tuple(k == tier.substeps - 1 for k in range(tier.substeps))
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
        tier, n = self.tier, self.robot.n
        friction, constants = (tier.coulomb, tier.viscous, tier.rotor_inertia), (tier.coulomb_velocity, tier.step)
        drive, armature = self._drive[:n], self._armature[:n]
        if self._motors is None:
            self._resist = bind(_resist, self._torque, self.dq, friction, constants, drive, armature)
        else:
            self._resist = self._motors.bind(self._torque, self.q, self.dq, drive, armature)
        self._measure = bind(
            _wrench_on_arm, self._flange_motion, self._flange_frame, self._spatial_inertia, self.wrench
        )
        for pendulum in self.pendulums:
            pendulum.bind(self.data, (self.positions, self.velocities), self._drive, self.wrench)

    def set_load(self, active: Sequence[bool]) -> None:
        """Switch the slots; joint positions and velocities stay as they are.

        A liquid that was not there before starts at rest in the container, where gravity holds it.

        Args:
            active: For each slot whether its body is carried.
        """
        carried = [body for body, on in zip(self.slots, active, strict=True) if on]
        rigid = _combined([body.rigid for body in carried])
        self.payload[:] = _combined(carried).toDynamicParameters()
        self.model.inertias[self._joint] = self._bare_inertia + self._placement.act(rigid)
        np.copyto(self._spatial_inertia, (self._gripper + rigid).matrix())
        for pendulum in self.pendulums:
            changed = pendulum.active != active[pendulum.slot]
            pendulum.switch(self.model, active=active[pendulum.slot], step=self.tier.step)
            if changed:
                self._calm(pendulum)

    def _calm(self, pendulum: Pendulum) -> None:
        """Put a pendulum to rest where gravity holds it."""
        self.positions[pendulum.joints] = pendulum.rest(self._down())
        self.velocities[pendulum.joints] = 0.0

    def _down(self) -> np.ndarray:
        """Return the direction of gravity in flange axes, shape (3,)."""
        pin.forwardKinematics(self.model, self.data, self.positions)
        flange = self.data.oMi[self._joint] * self._placement
        gravity = self.model.gravity.linear
        return np.asarray(np.clip(flange.rotation.T @ (gravity / np.linalg.norm(gravity)), -1.0, 1.0))

    def reset(self, q: np.ndarray, dq: np.ndarray, *, slosh: tuple[np.ndarray, np.ndarray] | None = None) -> None:
        """Place the arm.

        Args:
            q: Joint positions, shape (n,) [rad].
            dq: Joint velocities, shape (n,) [rad/s].
            slosh: Angles and rates of the pendulums, each of shape (2 k,) [rad, rad/s]; None for liquids at rest.

        Raises:
            InvalidInput: If a liquid is to rest in a container that is tilted so far that it runs out.
        """
        np.copyto(self.q, q)
        np.copyto(self.dq, dq)
        if slosh is None:
            self._check_upright()
            for pendulum in self.pendulums:
                self._calm(pendulum)
        else:
            self.positions[self.robot.n :], self.velocities[self.robot.n :] = slosh
        # The reading before the first step is the static one: arm and liquid are held where they are placed.
        held = pin.computeGeneralizedGravity(self.model, self.data, self.positions)
        pin.aba(self.model, self.data, self.positions, np.zeros(self.model.nv), held)
        self.measure_wrench()
        if self._motors is not None:
            self._motors.rest(self.q, self.dq, self.gravity())

    def _check_upright(self) -> None:
        """Refuse to start with a liquid in a container that does not hold it."""
        if not any(pendulum.active for pendulum in self.pendulums):
            return
        tilt = np.rad2deg(np.arccos(self._down()[2]))
        if tilt > MOST_TILT:
            came = f"a liquid in a container that is tilted by {tilt:.0f} degrees"
            raise InvalidInput(came, "load", f"start with its axis within {MOST_TILT:g} degrees of upright")

    def gravity(self) -> np.ndarray:
        """Return the gravity torque with the load that is carried, shape (n,) [N m]."""
        return np.array(pin.computeGeneralizedGravity(self.model, self.data, self.positions)[: self.robot.n])

    def mass_matrix(self) -> np.ndarray:
        """Return the inertia that the joints have, rotors and load included, shape (n, n) [kg m^2].

        What sloshes is free to stay behind: it counts with what it holds against a torque, not with its mass.
        """
        self._armature[: self.robot.n] = self.tier.rotor_inertia
        rest, n = np.zeros(self.model.nv), self.robot.n
        held = np.array(pin.rnea(self.model, self.data, self.positions, rest, rest))
        # Column by column: a liquid's joints may stand out of the order that the composite-body algorithm needs.
        rows = [pin.rnea(self.model, self.data, self.positions, rest, unit) - held for unit in np.eye(self.model.nv)]
        inertia = np.array(rows)
        coupled = inertia[:n, n:]
        return np.asarray(inertia[:n, :n] - coupled @ np.linalg.solve(inertia[n:, n:], coupled.T))

    def step(self, torque: np.ndarray) -> None:
        """Move on by one control period.

        Args:
            torque: What the drives produce, before friction; what torque loops are asked for where joints are
                elastic; shape (n,) [N m].
        """
        np.copyto(self._torque, torque)
        for is_last in self._is_last:
            self._resist()
            for pendulum in self.pendulums:
                pendulum.resist()
            pin.aba(self.model, self.data, self.positions, self.velocities, self._drive)
            if is_last:
                # Before the step moves on: what a pendulum adds depends on where it was.
                self.measure_wrench()
            self._integrate()

    def measure_wrench(self) -> None:
        """Refill ``wrench`` from the flange's motion in the last dynamics pass."""
        self._measure()
        for pendulum in self.pendulums:
            pendulum.add_to_wrench()

    @abstractmethod
    def _integrate(self) -> None:
        """Advance ``positions`` and ``velocities`` by the tier's step from ``_drive``, ``_armature`` and ``_ddq``."""

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
