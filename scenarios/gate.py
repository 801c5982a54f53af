"""The gate: what a plant must prove before it may run anything.

Every check compares a plant with an independent computation and returns the largest deviation. A plant that fails
runs nothing; the figures are stored with the runs.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..controllers import TorquebenchError, discovery
from .loads import LoadSchedule, Payload
from .materials import SAND_DENSITY
from .plants.plant import Plant
from .plants.pybullet_plant import PyBulletPlant
from .robots import Robot
from .tiers import Tier, build_tier, default_tiers


def empty(robot: Robot) -> Payload:
    """Return gripper and empty container, 1.5 kg on the Rizon 4s."""
    return Payload(mass=robot.gripper_mass + robot.container.mass)


def heavy(robot: Robot) -> Payload:
    """Return the container with 2 kg of sand, or nearly full if it holds less."""
    content = min(2.0, 0.9 * SAND_DENSITY * robot.container.volume)
    return Payload(mass=empty(robot).mass + content, material="sand")


class GateFailure(TorquebenchError):
    """A plant that does not compute the arm's equations; carries the failed checks."""

    exit_status = 1

    def __init__(self, checks: tuple["GateCheck", ...]) -> None:
        self.checks = checks
        what = ", ".join(f"{check.name} {check.deviation:.3g} (allowed {check.allowed:.0e})" for check in checks)
        super().__init__(f"the plant fails its gate: {what}")


@dataclass(frozen=True, kw_only=True)
class GateCheck:
    """One check and what it measured.

    Attributes:
        name: What must agree.
        plant: Name of the plant.
        deviation: Largest deviation found, in the check's own unit.
        allowed: Largest deviation allowed.
    """

    name: str
    plant: str
    deviation: float
    allowed: float

    @property
    def passed(self) -> bool:
        """Whether the deviation is allowed; NaN is not."""
        return bool(self.deviation <= self.allowed)


def run_gate(robot: Robot, plant: str, *, states: int = 20) -> tuple[GateCheck, ...]:
    """Check a plant on one robot.

    Args:
        robot: The arm.
        plant: Registered name of the plant.
        states: Random states per check; 20 take a fraction of a second.

    Returns:
        The checks; see :func:`require` to insist on them.
    """
    checks = [*_inertia_checks(robot, plant, states)]
    for name, check, allowed in CHECKS:
        deviation = check(robot, plant, np.random.default_rng(1), states)
        checks.append(GateCheck(name=name, plant=plant, deviation=deviation, allowed=allowed))
    return tuple(checks)


def require(checks: tuple[GateCheck, ...]) -> None:
    """Raise unless every check passed.

    Raises:
        GateFailure: With the failed ones.
    """
    failed = tuple(check for check in checks if not check.passed)
    if failed:
        raise GateFailure(failed)


def one_step(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest relative error of a step's acceleration, with no, a third of and full rotor inertia."""
    worst = 0.0
    for scale in (0.0, 1.0 / 3.0, 1.0):
        body, tier = _plant(robot, plant, heavy(robot), scale)
        oracle = _oracle(robot, tier, heavy(robot))
        for q, dq, torque in _states(robot, rng, states):
            body.reset(q, dq)
            body.step(torque)
            expected = pin.aba(oracle, oracle.createData(), q, dq, torque)
            worst = max(worst, _relative((body.dq - dq) / tier.period, expected))
        body.close()
    return worst


def position_update(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest deviation from q+ = q + h dq+, as far as a float64 can hold it [rad]."""
    body, tier = _plant(robot, plant, heavy(robot))
    worst = 0.0
    for q, dq, torque in _states(robot, rng, states):
        body.reset(q, dq)
        body.step(torque)
        worst = max(worst, float(np.max(np.abs(body.q - (q + tier.period * body.dq)))))
    body.close()
    return worst


def load_switch(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest relative error of the acceleration after a load was put on, and after it was taken off."""
    schedule = LoadSchedule(entries=((0.0, empty(robot)), (1.0, heavy(robot)), (2.0, empty(robot))))
    _, switches = schedule.slots(robot)
    body, tier = _plant(robot, plant, schedule)
    worst = 0.0
    for (_, active), (_, payload) in zip(switches, schedule.entries, strict=True):
        body.set_load(active)
        oracle = _oracle(robot, tier, payload)
        for q, dq, torque in _states(robot, rng, max(2, states // 4)):
            body.reset(q, dq)
            body.step(torque)
            expected = pin.aba(oracle, oracle.createData(), q, dq, torque)
            worst = max(worst, _relative((body.dq - dq) / tier.period, expected))
    body.close()
    return worst


def replay(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return 0 if a fresh plant, the same plant reset and a restart from (q, dq) agree to the bit, else 1."""
    q, dq, _ = next(_states(robot, rng, 1))
    torques = [torque for _, _, torque in _states(robot, rng, max(8, states))]
    first, _ = _plant(robot, plant, heavy(robot))
    path = _trajectory(first, q, 0.1 * dq, torques)
    again = _trajectory(first, q, 0.1 * dq, torques)
    half = len(torques) // 2
    n = robot.n
    restarted = _trajectory(first, path[half - 1, :n].copy(), path[half - 1, n:].copy(), torques[half:])
    second, _ = _plant(robot, plant, heavy(robot))
    fresh = _trajectory(second, q, 0.1 * dq, torques)
    first.close()
    second.close()
    same = np.array_equal(path, again) and np.array_equal(path, fresh) and np.array_equal(path[half:], restarted)
    return 0.0 if same else 1.0


def force_at_rest(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest error of the force reading of a load held at rest [N, N m]."""
    body, _ = _plant(robot, plant, heavy(robot))
    carried = [*robot.gripper_bodies, *heavy(robot).bodies(robot)]
    model = robot.model()
    worst = 0.0
    for q in (robot.home, *(q for q, _, _ in _states(robot, rng, 3))):
        body.reset(q, np.zeros(robot.n))
        down = model.flange_pose(q)[:3, :3].T @ np.array([0.0, 0.0, -9.81])
        force = sum((part.mass * down for part in carried), start=np.zeros(3))
        torque = sum((np.cross(part.com, part.mass * down) for part in carried), start=np.zeros(3))
        worst = max(worst, float(np.max(np.abs(body.wrench - np.concatenate([force, torque])))))
    body.close()
    return worst


def elastic_period(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest relative error of both sides' velocity changes in a period with elastic joints."""
    constants = default_tiers(robot.effort, robot.rotor_inertia)["elastic"] | {"coulomb": 0.0, "viscous": 0.0}
    tier = build_tier("gate", {"gate": constants}, robot.rotor_inertia)
    body, oracle = _plant_on(robot, plant, heavy(robot), tier), _oracle(robot, tier, heavy(robot))
    oracle.armature = np.zeros(robot.n)
    worst = 0.0
    for q, dq, torque in _states(robot, rng, max(2, states // 4)):
        body.reset(q, dq)
        body.step(torque)
        links, motors = _elastic_period(oracle, tier, q, dq, torque)
        worst = max(worst, _relative(body.dq - dq, links - dq), _relative(body.dtheta - dq, motors - dq))
    body.close()
    return worst


CHECKS: tuple[tuple[str, Callable[[Robot, str, np.random.Generator, int], float], float], ...] = (
    ("one step against forward dynamics, relative", one_step, 1e-12),
    ("position update, rad", position_update, 1e-15),
    ("load on and off against a rebuilt model, relative", load_switch, 1e-12),
    ("replay from reset, reload and (q, dq), bitwise", replay, 0.0),
    ("force reading at rest, N", force_at_rest, 1e-9),
    ("a period with elastic joints, relative", elastic_period, 1e-11),
)


def _inertia_checks(robot: Robot, plant: str, states: int) -> Iterator[GateCheck]:
    """Compare PyBullet's own mass matrix and inverse dynamics with Pinocchio's; other plants have no second opinion."""
    body, tier = _plant(robot, plant, heavy(robot), 0.0)
    if not isinstance(body, PyBulletPlant):
        return
    oracle = _oracle(robot, tier, heavy(robot))
    data = oracle.createData()
    mass, torque_error = 0.0, 0.0
    for q, dq, ddq in _states(robot, np.random.default_rng(1), states):
        rows = body.bullet.calculateMassMatrix(body.body, q.tolist(), physicsClientId=body.client)
        mass = max(mass, float(np.max(np.abs(np.asarray(rows) - pin.crba(oracle, data, q)))))
        args = (body.body, q.tolist(), dq.tolist(), ddq.tolist())
        found = np.asarray(body.bullet.calculateInverseDynamics(*args, physicsClientId=body.client))
        torque_error = max(torque_error, float(np.max(np.abs(found - pin.rnea(oracle, data, q, dq, ddq)))))
    body.close()
    yield GateCheck(name="mass matrix, kg m^2", plant=plant, deviation=mass, allowed=1e-12)
    yield GateCheck(name="inverse dynamics, N m", plant=plant, deviation=torque_error, allowed=1e-11)


def _plant(robot: Robot, plant: str, load: Payload | LoadSchedule, scale: float = 1.0 / 3.0) -> tuple[Plant, Tier]:
    """Build a plant without friction, with its first load and a share of the rotor inertia."""
    tier = build_tier("gate", {"gate": {"armature_scale": scale}}, robot.rotor_inertia)
    return _plant_on(robot, plant, load, tier), tier


def _plant_on(robot: Robot, plant: str, load: Payload | LoadSchedule, tier: Tier) -> Plant:
    """Build a plant on a tier with its first load."""
    schedule = load if isinstance(load, LoadSchedule) else LoadSchedule.constant(load)
    slots, switches = schedule.slots(robot)
    body: Plant = discovery.load("plants", plant)(robot, tier, slots)  # type: ignore[operator]
    body.set_load(switches[0][1])
    return body


def _oracle(robot: Robot, tier: Tier, payload: Payload) -> pin.Model:
    """Build a model with the load inside by another way: its bodies appended one by one at the flange."""
    model = pin.buildModelFromXML(robot.urdf)
    flange = model.frames[model.getFrameId(robot.flange_frame)]
    for body in payload.bodies(robot):
        inertia = pin.Inertia(body.mass, np.asarray(body.com, dtype=float), np.asarray(body.inertia, dtype=float))
        model.appendBodyToJoint(flange.parentJoint, inertia, flange.placement)
    model.armature = tier.rotor_inertia
    return model


def _elastic_period(
    oracle: pin.Model, tier: Tier, q: np.ndarray, dq: np.ndarray, torque: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return link and motor velocities after a period that begins with springs that carry gravity, without friction."""
    joints, data = tier.elasticity, oracle.createData()
    assert joints is not None
    current = pin.computeGeneralizedGravity(oracle, data, q).copy()
    theta, dtheta = q + current / joints.stiffness, dq.copy()
    for _ in range(joints.substeps):
        spring = joints.stiffness * (theta - q) + joints.damping * (dtheta - dq)
        feedback = joints.torque_gain * (torque - spring) - joints.rate_gain * joints.stiffness * (dtheta - dq)
        current = current + joints.current_share(tier.step) * (torque + feedback - current)
        dq = dq + tier.step * pin.aba(oracle, data, q, dq, spring)
        dtheta = dtheta + tier.step * (current - spring) / joints.motor_inertia
        q, theta = q + tier.step * dq, theta + tier.step * dtheta
    return dq, dtheta


def _states(robot: Robot, rng: np.random.Generator, count: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield random positions inside the limits, velocities, and a third array for torques or accelerations."""
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    for _ in range(count):
        yield rng.uniform(low, high), rng.normal(size=robot.n), rng.normal(size=robot.n) * 0.2 * robot.effort


def _trajectory(body: Plant, q: np.ndarray, dq: np.ndarray, torques: list[np.ndarray]) -> np.ndarray:
    body.reset(q, dq)
    rows = []
    for torque in torques:
        body.step(torque)
        rows.append(np.concatenate([body.q, body.dq]))
    return np.array(rows)


def _relative(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))
