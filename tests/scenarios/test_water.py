"""Water on the flange: a pendulum that both engines integrate alike, that comes and goes, and that the arm feels."""

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import Controller, InvalidInput, Oracle, discovery
from torquebench.scenarios.events import event_window
from torquebench.scenarios.execution import execute
from torquebench.scenarios.liquid import Liquid
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import Scores
from torquebench.scenarios.tiers import build_tier
from torquebench.scenarios.trajectories import Plan, load_path

EMPTY, FULL, HALF = Payload(mass=1.5), Payload(mass=3.5, material="water"), Payload(mass=2.5, material="water")
SAND = Payload(mass=3.5, material="sand")
TIERS = ["ideal", "actuated", "tight_rate", "paper_bullet"]
G = 9.81


@pytest.fixture
def plant_of(rizon):
    """Builds a plant of the Rizon with a tier and a load history, closed after the test; `switches` are its stages."""
    opened = []

    def build(name, *, tier="ideal", load=FULL):
        schedule = load if isinstance(load, LoadSchedule) else LoadSchedule.constant(load)
        slots, switches = schedule.slots(rizon)
        constants = build_tier(tier, rizon.tiers, rizon.rotor_inertia) if isinstance(tier, str) else tier
        plant = discovery.load("plants", name)(rizon, constants, slots)
        plant.switches = [active for _, active in switches]
        plant.set_load(plant.switches[0])
        opened.append(plant)
        return plant

    yield build
    for plant in opened:
        plant.close()


def history(*payloads):
    """One load after the other."""
    return LoadSchedule(entries=tuple(enumerate(payloads)))


def held(rizon):
    """A tier whose rotors nothing moves: the arm is held."""
    return build_tier("held", {"held": {"armature_scale": 1.0}}, np.full(rizon.n, 1e9))


def tilted(rizon, angle):
    """Home with the last but one joint turned."""
    q = rizon.home.copy()
    q[5] += angle
    return q


def follow(plant, rizon, trajectory, seconds, changes=()):
    """Return all positions of a closed loop with feed-forward and a PD law that knows arm and gripper."""
    plan = Plan.build(rizon, load_path(trajectory), lead_in=0.0)
    period = plant.tier.period
    table = plan.rows(np.arange(round(seconds / period)) * period)
    model = rizon.model(rotor_inertia=plant.tier.rotor_inertia)
    plant.reset(table["q"][0], table["dq"][0])
    stages, rows = dict(zip(changes, plant.switches[1:], strict=True)), []
    for k, row in enumerate(table):
        if k in stages:
            plant.set_load(stages[k])
        acceleration = row["ddq"] + 400.0 * (row["q"] - plant.q) + 40.0 * (row["dq"] - plant.dq)
        plant.step(model.inverse_dynamics(plant.q, plant.dq, acceleration))
        rows.append(plant.positions.copy())
    return np.array(rows)


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize(
    ("load", "changes"),
    [(FULL, ()), (history(EMPTY, FULL, HALF, EMPTY), (250, 500, 750))],
    ids=["full throughout", "in, half out, out"],
)
def test_both_engines_agree_over_a_closed_loop_second(has_pybullet, plant_of, rizon, tier, load, changes):
    """T6, the liveliest path, to 1e-9 rad in joints and liquid (F13 with water)."""
    bullet, reference = (
        follow(plant_of(name, tier=tier, load=load), rizon, "T6", 1.0, changes) for name in ("pybullet", "pinocchio")
    )
    assert np.ptp(reference[:, :7], axis=0).max() > 0.3
    assert np.abs(reference[:, 7:]).max() > 0.03
    assert np.abs(bullet - reference).max() < 1e-9


@pytest.mark.parametrize("tier", TIERS)
def test_both_engines_agree_behind_drives_and_sensors_too(has_pybullet, world_of, play, tier):
    """The same with delay, lag, encoders and noise in the loop, water in and out."""
    schedule = LoadSchedule(entries=((0.0, EMPTY), (0.2, FULL), (0.6, EMPTY)))
    bullet, reference = (
        play(world_of(seconds=1.2, tier=tier, schedule=schedule, plant=name), Law(), Oracle()).log
        for name in ("pybullet", "pinocchio")
    )
    assert bullet.shape == reference.shape == (1200,)
    assert np.abs(bullet["q"] - reference["q"]).max() < 1e-9
    assert np.abs(bullet["wrench_measured"] - reference["wrench_measured"]).max() < 1e-6


@pytest.mark.parametrize("mass", [1.7, 2.0, 3.5])
def test_bullets_own_tree_with_water_at_rest_is_the_frozen_load(has_pybullet, plant_of, rizon, rng, mass):
    """Its inverse dynamics of nine joints against Pinocchio's of seven with the water as ice, shallow too (F6)."""
    load = Payload(mass=mass, material="water")
    plant = plant_of("pybullet", tier="paper_bullet", load=load)
    frozen = rizon.model()
    frozen.set_payload(plant.payload)
    none = np.zeros(2)
    for _ in range(20):
        q, dq, ddq = rng.uniform(-1.5, 1.5, 7), rng.normal(size=7), rng.normal(size=7)
        states = [np.concatenate([part, none]).tolist() for part in (q, dq, ddq)]
        found = plant.bullet.calculateInverseDynamics(plant.body, *states, physicsClientId=plant.client)
        assert np.allclose(found[:7], frozen.inverse_dynamics(q, dq, ddq), rtol=0, atol=1e-11)


@pytest.mark.parametrize("mass", [2.0, 3.5])
def test_slosh_has_its_frequency_and_its_decay(plant_name, plant_of, rizon, mass):
    """Eight seconds of free decay from 0.05 rad on a held arm: 0.1 percent and 2 percent (F7)."""
    load = Payload(mass=mass, material="water")
    plant = plant_of(plant_name, tier=held(rizon), load=load)
    liquid = next(body for body in plant.slots if isinstance(body, Liquid))
    plant.reset(rizon.home, np.zeros(7), slosh=(np.array([0.05, 0.0]), np.zeros(2)))
    gravity, angles = plant.gravity(), []
    for _ in range(8000):
        plant.step(gravity)
        angles.append(plant.positions[7])
    angles = np.array(angles)
    assert np.abs(plant.q - rizon.home).max() < 1e-6
    k = np.flatnonzero((angles[:-1] < 0) & (angles[1:] >= 0))
    crossings = (k + angles[k] / (angles[k] - angles[k + 1])) * plant.tier.period
    damped = 2 * np.pi / np.mean(np.diff(crossings))
    natural = liquid.frequency * np.sqrt(1 - liquid.damping_ratio**2)
    assert damped == pytest.approx(natural, rel=1e-3)
    peaks = [angles[a:b].max() for a, b in pairwise(k)]
    decay = -np.polyfit(np.arange(len(peaks)), np.log(peaks), 1)[0] * damped / (2 * np.pi)
    assert decay == pytest.approx(liquid.damping_ratio * liquid.frequency, rel=0.02)


def test_slosh_on_the_fast_paths_stays_where_the_model_holds(plant_of, rizon):
    """About ten degrees on T6: the linear mode is good for that and not for more."""
    angles = np.rad2deg(np.abs(follow(plant_of("pinocchio"), rizon, "T6", 4.0)[2000:, 7:9]))
    assert 5.0 < angles.max() < 15.0


class Holds(Controller):
    """The joint law of the manufacturer's torque example: PD on the start position, gravity added."""

    stiffness = np.array([3000.0, 3000.0, 800.0, 800.0, 200.0, 200.0, 200.0])
    damping = np.array([80.0, 80.0, 40.0, 40.0, 8.0, 8.0, 8.0])

    def reset(self, task):
        self.robot, self.place = task.robot, task.initial_q

    def compute(self, observation, target):
        q, dq = observation.q, observation.dq
        return self.stiffness * (self.place - q) - self.damping * dq + self.robot.gravity(q)


@pytest.mark.parametrize("load", [EMPTY, FULL, SAND], ids=["empty", "water", "sand"])
@pytest.mark.parametrize("tier", TIERS)
def test_ordinary_gains_hold_with_rotor_inertia_and_not_without(plant_name, world_of, play, rng, tier, load):
    """From 0.05 rad/s in the tool-down pose, 0.8 s (F11); torque limits make a limit cycle of what would diverge."""
    schedule = LoadSchedule.constant(load)
    world = world_of(seconds=0.8, tier=tier, schedule=schedule, trajectory="T1", plant=plant_name, lead_in=1.0)
    world.plant.reset(world.table["q"][0], 0.05 * rng.uniform(-1.0, 1.0, 7))
    outcome = play(world, Holds(), Oracle())
    speed = np.abs(outcome.log["dq"][-200:]).max()
    if tier == "paper_bullet":
        assert speed > 1.0
    else:
        assert outcome.failure is None
        assert speed < 0.01


def test_held_water_stays_where_gravity_holds_it(plant_name, plant_of, rizon):
    """In a container that is tilted by 20 degrees too: arm and liquid are in balance, to rounding."""
    plant = plant_of(plant_name)
    q = tilted(rizon, np.deg2rad(20.0))
    plant.reset(q, np.zeros(7))
    start = plant.positions.copy()
    assert np.abs(start[7:]).max() == pytest.approx(np.deg2rad(20.0), abs=1e-6)
    for _ in range(300):
        plant.step(plant.gravity())
    assert np.abs(plant.positions - start).max() < 1e-10


def test_water_that_comes_changes_no_velocity_and_comes_at_rest(plant_name, plant_of, rizon):
    """As a mass at rest relative to the hand is attached; gone and back, it has forgotten how it moved."""
    plant = plant_of(plant_name, load=history(EMPTY, FULL, EMPTY, FULL))
    plant.reset(tilted(rizon, 0.2), np.full(7, 0.3))
    for active in plant.switches[1:]:
        before = plant.q.copy(), plant.dq.copy()
        plant.set_load(active)
        assert np.array_equal(before, (plant.q, plant.dq))
        assert not plant.velocities[7:].any()
        flange = rizon.model().flange_pose(plant.q)[:3, :3]
        hangs = plant.positions[7:]
        if any(pendulum.active for pendulum in plant.pendulums):
            bob = np.array(
                [np.sin(hangs[1]), -np.sin(hangs[0]) * np.cos(hangs[1]), np.cos(hangs[0]) * np.cos(hangs[1])]
            )
            assert np.allclose(flange @ bob, [0.0, 0.0, -1.0], rtol=0, atol=1e-12)
        else:
            assert not hangs.any()
        for _ in range(50):
            plant.step(plant.gravity() + 5.0)
        moved = np.abs(plant.velocities[7:]).max()
        assert moved > 0.1 if hangs.any() else moved == 0.0


def test_an_idle_pendulum_is_not_there(plant_name, plant_of, rizon, rng):
    """A run whose water comes later is to the bit the run without, or twins would be of no use."""
    torques = rng.normal(size=(200, 7)) * 10

    def path(load):
        plant = plant_of(plant_name, tier="actuated", load=load)
        plant.reset(rizon.home, np.full(7, 0.2))
        rows = []
        for torque in torques:
            plant.step(torque)
            rows.append(np.concatenate([plant.q, plant.dq, plant.wrench]))
        return np.array(rows)

    assert np.array_equal(path(history(SAND, FULL)), path(SAND))


def test_the_force_sensor_reads_arm_and_water_in_motion(plant_name, plant_of, rizon, rng):
    """Minus what the arm exerts on load and pendulum, by recursive Newton-Euler on a tree that ends in them."""
    plant = plant_of(plant_name)
    q, dq, torque = tilted(rizon, 0.3), rng.normal(size=7), rng.normal(size=7) * 10
    angles, rates = np.array([0.3, -0.2]), np.array([1.0, 2.0])
    plant.reset(q, dq, slosh=(angles, rates))
    plant.step(torque)
    acceleration = (plant.velocities - np.concatenate([dq, rates])) / plant.tier.period
    tree, bare = pin.buildModelFromXML(rizon.simulator_urdf(plant.slots)), pin.buildModelFromXML(rizon.urdf)
    flange = bare.frames[bare.getFrameId(rizon.flange_frame)]
    gripper = pin.Inertia(rizon.gripper.mass, np.array(rizon.gripper.com), np.array(rizon.gripper.inertia))
    bare.inertias[flange.parentJoint] = bare.inertias[flange.parentJoint] - flange.placement.act(gripper)
    forces = []
    moving = [np.concatenate(part) for part in ((q, angles), (dq, rates))] + [acceleration]
    for model in (tree, bare):
        data = model.createData()
        pin.rnea(model, data, *(part[: model.nv] for part in moving))
        forces.append(data.f[flange.parentJoint].copy())
    on_load = flange.placement.actInv(forces[0] - forces[1])
    assert np.allclose(plant.wrench, -np.array(on_load.vector), rtol=0, atol=1e-9)


def test_the_force_sensor_reads_the_weight_tool_down(plant_name, plant_of, rizon):
    """Water weighs what sand of the same mass does."""
    level = rizon.home.copy()
    level[[1, 3, 5]] = np.deg2rad([-40.0, 90.0, 40.0])
    for load in (FULL, SAND):
        plant = plant_of(plant_name, load=load)
        plant.reset(level, np.zeros(7))
        assert np.allclose(plant.wrench, [0.0, 0.0, 3.5 * G, 0.0, 0.0, 0.0], rtol=0, atol=1e-9)


def test_the_payload_is_told_frozen_at_rest(plant_name, plant_of, rizon):
    """What the oracle knows, whatever the water does."""
    plant = plant_of(plant_name)
    frozen = sum(body.parameters for body in FULL.bodies(rizon))
    plant.reset(rizon.home, np.zeros(7), slosh=(np.full(2, 0.3), np.ones(2)))
    plant.step(plant.gravity())
    assert np.allclose(plant.payload, frozen, rtol=0, atol=1e-12)


def test_what_sloshes_stays_behind_when_the_arm_is_pushed(plant_name, plant_of, rizon):
    """The mass matrix is what turns a torque into an acceleration: less than with ice, never more."""
    plant = plant_of(plant_name, tier="paper_bullet")
    plant.reset(rizon.home, np.zeros(7))
    gravity, pushed = plant.gravity(), []
    for unit in np.eye(7):
        plant.reset(rizon.home, np.zeros(7))
        plant.step(gravity + unit)
        pushed.append(plant.dq / plant.tier.period)
    plant.reset(rizon.home, np.zeros(7))
    free = plant.mass_matrix()
    assert np.allclose(free @ np.array(pushed).T, np.eye(7), rtol=0, atol=1e-9)
    frozen = rizon.model()
    frozen.set_payload(plant.payload)
    lighter = np.linalg.eigvalsh(frozen.mass_matrix(rizon.home) - free)
    assert lighter.min() > -1e-9 and lighter.max() > 0.1


def test_the_whole_state_is_arm_and_water(plant_name, plant_of, rizon, rng):
    """A restart from the middle goes the same way to the bit; the water's angles and rates are part of it (F5)."""
    plant = plant_of(plant_name, tier="actuated")
    torques = rng.normal(size=(60, 7)) * 10
    plant.reset(rizon.home, np.full(7, 0.2))
    for torque in torques[:30]:
        plant.step(torque)
    positions, velocities = plant.positions.copy(), plant.velocities.copy()
    for torque in torques[30:]:
        plant.step(torque)
    end = plant.positions.copy()
    plant.reset(positions[:7], velocities[:7], slosh=(positions[7:], velocities[7:]))
    for torque in torques[30:]:
        plant.step(torque)
    assert np.array_equal(plant.positions, end)


def test_no_run_begins_with_water_in_a_container_that_lies_down(plant_name, plant_of, rizon):
    """It runs out; sand of today does not."""
    with pytest.raises(InvalidInput, match=r"load: a liquid in a container that is tilted by 75 degrees; .* within 60"):
        plant_of(plant_name).reset(tilted(rizon, np.deg2rad(75.0)), np.zeros(7))
    plant_of(plant_name, load=SAND).reset(tilted(rizon, np.deg2rad(75.0)), np.zeros(7))


class Law(Controller):
    """Computed torque."""

    def reset(self, task):
        self.robot = task.robot

    def compute(self, observation, target):
        error, error_rate = target.q - observation.q, target.dq - observation.dq
        return self.robot.inverse_dynamics(observation.q, observation.dq, target.ddq + 400 * error + 40 * error_rate)


@pytest.mark.parametrize("knowledge", ["none", "oracle"])
def test_a_run_with_water_in_and_out_is_judged_against_its_twins(run_of, plant_name, knowledge):
    """Until the event both are one simulation to the bit, and afterwards the water tells."""
    seen = []

    def evaluate(log, events):
        seen.extend(events)
        return {event_window(event.time): {"a5": {"status": "ok"}} for event in events}

    specification = run_of(
        schedule=LoadSchedule(entries=((0.0, EMPTY), (0.5, FULL), (1.25, EMPTY))),
        twins=True,
        tier="actuated",
        plant=plant_name,
        knowledge=knowledge,
    )
    row, *_ = execute(
        specification,
        evaluate=lambda _: Scores(metrics={"run": {}}),
        evaluate_events=evaluate,
        traces="none",
        plug_ins={"mine": Law},
    )
    assert row.status == "ok"
    assert [note["status"] for note in row.provenance["events"]] == ["ok", "ok"]
    up, _ = seen
    assert np.linalg.norm(up.new.wrench[-1, :3]) == pytest.approx(3.5 * G, rel=0.15)
