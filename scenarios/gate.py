"""The gate: what a plant must prove before it may run anything.

Every check compares a plant with an independent computation and returns the largest deviation. A plant that fails
runs nothing; the figures are stored with the runs.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..controllers import TorquebenchError
from .gate_bench import build_plant, build_plant_on, empty, heavy, random_states, relative, replays, rigid_oracle
from .gate_liquid import LIQUID_CHECKS
from .loads import LoadSchedule
from .plants.pybullet_plant import PyBulletPlant
from .robots import Robot
from .tiers import Tier, build_tier, default_tiers


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
    for name, check, allowed in (*CHECKS, *LIQUID_CHECKS):
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
        body, tier = build_plant(robot, plant, heavy(robot), scale)
        oracle = rigid_oracle(robot, tier, heavy(robot))
        for q, dq, torque in random_states(robot, rng, states):
            body.reset(q, dq)
            body.step(torque)
            expected = pin.aba(oracle, oracle.createData(), q, dq, torque)
            worst = max(worst, relative((body.dq - dq) / tier.period, expected))
        body.close()
    return worst


def position_update(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest deviation from q+ = q + h dq+, as far as a float64 can hold it [rad]."""
    body, tier = build_plant(robot, plant, heavy(robot))
    worst = 0.0
    for q, dq, torque in random_states(robot, rng, states):
        body.reset(q, dq)
        body.step(torque)
        worst = max(worst, float(np.max(np.abs(body.q - (q + tier.period * body.dq)))))
    body.close()
    return worst


def load_switch(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest relative error of the acceleration after a load was put on, and after it was taken off."""
    schedule = LoadSchedule(entries=((0.0, empty(robot)), (1.0, heavy(robot)), (2.0, empty(robot))))
    _, switches = schedule.slots(robot)
    body, tier = build_plant(robot, plant, schedule)
    worst = 0.0
    for (_, active), (_, payload) in zip(switches, schedule.entries, strict=True):
        body.set_load(active)
        oracle = rigid_oracle(robot, tier, payload)
        for q, dq, torque in random_states(robot, rng, max(2, states // 4)):
            body.reset(q, dq)
            body.step(torque)
            expected = pin.aba(oracle, oracle.createData(), q, dq, torque)
            worst = max(worst, relative((body.dq - dq) / tier.period, expected))
    body.close()
    return worst


def replay(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return 0 if a fresh plant, the same plant reset and a restart from (q, dq) agree to the bit, else 1."""
    q, dq, _ = next(random_states(robot, rng, 1))
    torques = [torque for _, _, torque in random_states(robot, rng, max(8, states))]
    return replays(robot, plant, heavy(robot), np.concatenate([q, 0.1 * dq]), torques)


def force_at_rest(robot: Robot, plant: str, rng: np.random.Generator, states: int) -> float:
    """Return the largest error of the force reading of a load held at rest [N, N m]."""
    body, _ = build_plant(robot, plant, heavy(robot))
    carried = [*robot.gripper_bodies, *heavy(robot).bodies(robot)]
    model = robot.model()
    worst = 0.0
    for q in (robot.home, *(q for q, _, _ in random_states(robot, rng, 3))):
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
    body, oracle = build_plant_on(robot, plant, heavy(robot), tier), rigid_oracle(robot, tier, heavy(robot))
    oracle.armature = np.zeros(robot.n)
    worst = 0.0
    for q, dq, torque in random_states(robot, rng, max(2, states // 4)):
        body.reset(q, dq)
        body.step(torque)
        links, motors = _elastic_period(oracle, tier, q, dq, torque)
        worst = max(worst, relative(body.dq - dq, links - dq), relative(body.dtheta - dq, motors - dq))
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
    body, tier = build_plant(robot, plant, heavy(robot), 0.0)
    if not isinstance(body, PyBulletPlant):
        return
    oracle = rigid_oracle(robot, tier, heavy(robot))
    data = oracle.createData()
    mass, torque_error = 0.0, 0.0
    for q, dq, ddq in random_states(robot, np.random.default_rng(1), states):
        rows = body.bullet.calculateMassMatrix(body.body, q.tolist(), physicsClientId=body.client)
        mass = max(mass, float(np.max(np.abs(np.asarray(rows) - pin.crba(oracle, data, q)))))
        args = (body.body, q.tolist(), dq.tolist(), ddq.tolist())
        found = np.asarray(body.bullet.calculateInverseDynamics(*args, physicsClientId=body.client))
        torque_error = max(torque_error, float(np.max(np.abs(found - pin.rnea(oracle, data, q, dq, ddq)))))
    body.close()
    yield GateCheck(name="mass matrix, kg m^2", plant=plant, deviation=mass, allowed=1e-12)
    yield GateCheck(name="inverse dynamics, N m", plant=plant, deviation=torque_error, allowed=1e-11)


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
