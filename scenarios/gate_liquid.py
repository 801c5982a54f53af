"""The gate's checks with water on the flange.

The oracle is read from the text that describes arm and pendulum to a simulator; the plants hang the pendulum on
their model joint by joint.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .gate_bench import build_plant, empty, random_states, relative, replays, rigid_oracle, watery
from .liquid import Liquid
from .loads import LoadSchedule, Payload
from .plants.plant import Plant
from .robots import Robot, slosh_names
from .tiers import Tier

CONTENT = 1
"""Slot of the water: the container comes first."""


@dataclass(frozen=True, kw_only=True)
class LiquidOracle:
    """Arm, container and water as one tree of an independent model.

    Attributes:
        model: The tree.
        order: Where the plant's joints stand in the tree's vectors, shape (n + 2,).
        resistance: Torque of the water's damping at unit rate, shape (n + 2,) [N m s/rad].
    """

    model: pin.Model
    order: np.ndarray
    resistance: np.ndarray

    @classmethod
    def build(cls, robot: Robot, tier: Tier, payload: Payload) -> "LiquidOracle":
        """Read the tree of a robot that carries water."""
        model = pin.buildModelFromXML(robot.simulator_urdf(payload.bodies(robot)))
        order = np.array([model.idx_vs[model.getJointId(name)] for name in (*robot.joint_names, *slosh_names(CONTENT))])
        resistance, inertia = np.zeros(robot.n + 2), np.zeros(robot.n + 2)
        resistance[robot.n :] = water_of(robot, payload).damping
        inertia[order] = np.concatenate([tier.rotor_inertia, np.zeros(2)]) + tier.period * resistance
        model.armature = inertia
        return cls(model=model, order=order, resistance=resistance)

    def acceleration(self, positions: np.ndarray, velocities: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return the acceleration of all joints in the plant's order, shape (n + 2,) [rad/s^2]."""
        q, dq, tau = np.zeros((3, self.order.shape[0]))
        q[self.order], dq[self.order] = positions, velocities
        tau[self.order] = np.concatenate([torque, np.zeros(2)]) - self.resistance * velocities
        return np.asarray(pin.aba(self.model, self.model.createData(), q, dq, tau)[self.order])


def water_of(robot: Robot, payload: Payload) -> Liquid:
    """Return the liquid of a load."""
    return next(body for body in payload.bodies(robot) if isinstance(body, Liquid))


def liquid_step(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest relative error of a step's acceleration, with no, a third of and full rotor inertia."""
    worst = 0.0
    for scale in (0.0, 1.0 / 3.0, 1.0):
        body, tier = build_plant(robot, plant, watery(robot), scale)
        worst = max(worst, _step_error(body, LiquidOracle.build(robot, tier, watery(robot)), rng, states))
        body.close()
    return worst


def liquid_frozen(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest difference between the torques of water held at rest and of the same water frozen [N m]."""
    body, tier = build_plant(robot, plant, watery(robot), 0.0)
    frozen = rigid_oracle(robot, tier, watery(robot))
    data, worst = frozen.createData(), 0.0
    for q, dq, ddq in random_states(robot, rng, states):
        held = pin.rnea(body.model, body.data, *(np.concatenate([part, np.zeros(2)]) for part in (q, dq, ddq)))
        worst = max(worst, float(np.max(np.abs(held[: robot.n] - pin.rnea(frozen, data, q, dq, ddq)))))
    body.close()
    return worst


def liquid_switch(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest relative error of the acceleration before water is there, while it is, and after."""
    schedule = LoadSchedule(entries=((0.0, empty(robot)), (1.0, watery(robot)), (2.0, empty(robot))))
    _, switches = schedule.slots(robot)
    body, tier = build_plant(robot, plant, schedule)
    wet, dry = LiquidOracle.build(robot, tier, watery(robot)), rigid_oracle(robot, tier, empty(robot))
    data, worst, few = dry.createData(), 0.0, max(2, states // 4)
    for _, active in switches:
        body.set_load(active)
        if active[CONTENT]:
            worst = max(worst, _step_error(body, wet, rng, few))
            continue
        for q, dq, torque in random_states(robot, rng, few):
            body.reset(q, dq)
            body.step(torque)
            worst = max(worst, relative((body.dq - dq) / tier.period, pin.aba(dry, data, q, dq, torque)))
    body.close()
    return worst


def liquid_replay(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return 0 if a fresh plant, the same plant reset and a restart from its whole state agree to the bit, else 1."""
    positions, velocities, _ = next(_sloshing_states(robot, rng, 1))
    torques = [torque for _, _, torque in random_states(robot, rng, max(8, states))]
    return replays(robot, plant, watery(robot), np.concatenate([positions, 0.1 * velocities]), torques)


def liquid_force(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest error of the force reading of water that gravity holds, tool roughly down [N, N m].

    The bob hangs straight below its hinge, so its weight has the hinge's moment.
    """
    body, _ = build_plant(robot, plant, watery(robot))
    water, model, worst = water_of(robot, watery(robot)), robot.model(), 0.0
    rigid = [*robot.gripper_bodies, *(part.rigid for part in watery(robot).bodies(robot))]
    for q in (robot.home, *(q for q, _, _ in random_states(robot, rng, states))):
        down = model.flange_pose(q)[:3, :3].T @ np.array([0.0, 0.0, -9.81])
        if down[2] < 0.6 * 9.81:
            continue
        body.reset(q, np.zeros(robot.n))
        weights = [(part.mass, part.com) for part in rigid]
        weights.append((water.bob_mass, np.array([0.0, 0.0, water.hinge_z])))
        force = sum((mass * down for mass, _ in weights), start=np.zeros(3))
        torque = sum((np.cross(point, mass * down) for mass, point in weights), start=np.zeros(3))
        worst = max(worst, float(np.max(np.abs(body.wrench - np.concatenate([force, torque])))))
    body.close()
    return worst


LIQUID_CHECKS: tuple[tuple[str, Callable[[Robot, str, np.random.Generator, int], float], float], ...] = (
    ("one step with water against forward dynamics, relative", liquid_step, 1e-12),
    ("water held at rest against frozen water, N m", liquid_frozen, 1e-11),
    ("water in and out against rebuilt models, relative", liquid_switch, 1e-12),
    ("replay with water from its whole state, bitwise", liquid_replay, 0.0),
    ("force reading of water at rest, N", liquid_force, 1e-9),
)


def _step_error(body: Plant, oracle: LiquidOracle, rng: np.random.Generator, states: int) -> float:
    """Return the largest relative error of a step's acceleration, the liquid's joints included."""
    n, worst = body.robot.n, 0.0
    for positions, velocities, torque in _sloshing_states(body.robot, rng, states):
        body.reset(positions[:n], velocities[:n], slosh=(positions[n:], velocities[n:]))
        body.step(torque)
        expected = oracle.acceleration(positions, velocities, torque)
        worst = max(worst, relative((body.velocities - velocities) / body.tier.period, expected))
    return worst


def _sloshing_states(
    robot: Robot, rng: np.random.Generator, count: int
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield random positions and velocities of arm and water, and torques on the arm."""
    for q, dq, torque in random_states(robot, rng, count):
        angles, rates = rng.uniform(-0.5, 0.5, 2), rng.normal(size=2)
        yield np.concatenate([q, angles]), np.concatenate([dq, rates]), torque
