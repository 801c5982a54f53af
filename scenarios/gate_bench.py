"""What the gate's checks stand on: loads, plants without friction, independent models, random states."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from ..controllers import discovery
from .loads import LoadSchedule, Payload
from .materials import SAND_DENSITY, WATER_DENSITY
from .plants.plant import Plant
from .robots import Robot
from .tiers import Tier, build_tier


def empty(robot: Robot) -> Payload:
    """Return gripper and empty container, 1.5 kg on the Rizon 4s."""
    return Payload(mass=robot.gripper_mass + robot.container.mass)


def heavy(robot: Robot) -> Payload:
    """Return the container with 2 kg of sand, or nearly full if it holds less."""
    content = min(2.0, 0.9 * SAND_DENSITY * robot.container.volume)
    return Payload(mass=empty(robot).mass + content, material="sand")


def watery(robot: Robot) -> Payload:
    """Return the container with 2 kg of water, or nearly full if it holds less."""
    content = min(2.0, 0.9 * WATER_DENSITY * robot.container.volume)
    return Payload(mass=empty(robot).mass + content, material="water")


def build_plant(robot: Robot, plant: str, load: Payload | LoadSchedule, scale: float = 1.0 / 3.0) -> tuple[Plant, Tier]:
    """Build a plant without friction, with its first load and a share of the rotor inertia."""
    tier = build_tier("gate", {"gate": {"armature_scale": scale}}, robot.rotor_inertia)
    return build_plant_on(robot, plant, load, tier), tier


def build_plant_on(robot: Robot, plant: str, load: Payload | LoadSchedule, tier: Tier) -> Plant:
    """Build a plant on a tier with its first load."""
    schedule = load if isinstance(load, LoadSchedule) else LoadSchedule.constant(load)
    slots, switches = schedule.slots(robot)
    body: Plant = discovery.load("plants", plant)(robot, tier, slots)  # type: ignore[operator]
    body.set_load(switches[0][1])
    return body


def rigid_oracle(robot: Robot, tier: Tier, payload: Payload) -> pin.Model:
    """Build a model with the load inside by another way: its bodies appended one by one at the flange."""
    model = pin.buildModelFromXML(robot.urdf)
    flange = model.frames[model.getFrameId(robot.flange_frame)]
    for body in payload.bodies(robot):
        inertia = pin.Inertia(body.mass, np.asarray(body.com, dtype=float), np.asarray(body.inertia, dtype=float))
        model.appendBodyToJoint(flange.parentJoint, inertia, flange.placement)
    model.armature = tier.rotor_inertia
    return model


def random_states(
    robot: Robot, rng: np.random.Generator, count: int
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield random positions inside the limits, velocities, and a third array for torques or accelerations."""
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    for _ in range(count):
        yield rng.uniform(low, high), rng.normal(size=robot.n), rng.normal(size=robot.n) * 0.2 * robot.effort


def path_of(body: Plant, start: np.ndarray, torques: list[np.ndarray]) -> np.ndarray:
    """Return the states that a plant goes through under torques, one row each.

    Args:
        body: The plant.
        start: Its first state: positions of all joints, then velocities [rad, rad/s].
        torques: On the arm, one each step [N m].
    """
    n = body.robot.n
    positions, velocities = np.split(start, 2)
    body.reset(positions[:n], velocities[:n], slosh=(positions[n:], velocities[n:]))
    rows = []
    for torque in torques:
        body.step(torque)
        rows.append(np.concatenate([body.positions, body.velocities]))
    return np.array(rows)


def replays(robot: Robot, plant: str, payload: Payload, start: np.ndarray, torques: list[np.ndarray]) -> float:
    """Return 0 if a fresh plant, the same plant reset and a restart from half-way agree to the bit, else 1."""
    first, _ = build_plant(robot, plant, payload)
    path, again = path_of(first, start, torques), path_of(first, start, torques)
    half = len(torques) // 2
    restarted = path_of(first, path[half - 1], torques[half:])
    second, _ = build_plant(robot, plant, payload)
    fresh = path_of(second, start, torques)
    first.close()
    second.close()
    same = np.array_equal(path, again) and np.array_equal(path, fresh) and np.array_equal(path[half:], restarted)
    return 0.0 if same else 1.0


def relative(found: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest deviation as a share of the largest value."""
    return float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))
