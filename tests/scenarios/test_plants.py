"""The simulated arms: the same equations on two engines."""

import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import InvalidInput, discovery
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.plants import pybullet_plant
from torquebench.scenarios.tiers import build_tier
from torquebench.scenarios.trajectories import Plan, load_path

SAND = Payload(mass=3.5, material="sand")
G = 9.81


@pytest.fixture
def plant_of(rizon):
    """Builds a plant of the Rizon with a tier and a load, closed after the test."""
    opened = []

    def build(name, *, tier="ideal", load=SAND, robot=rizon):
        schedule = load if isinstance(load, LoadSchedule) else LoadSchedule.constant(load)
        slots, switches = schedule.slots(robot)
        constants = build_tier(tier, robot.tiers, robot.rotor_inertia) if isinstance(tier, str) else tier
        plant = discovery.load("plants", name)(robot, constants, slots)
        plant.set_load(switches[0][1])
        opened.append(plant)
        return plant

    yield build
    for plant in opened:
        plant.close()


def follow(plant, rizon, trajectory, seconds):
    """Return joint positions and velocities of a closed loop with feed-forward and a PD law."""
    plan = Plan.build(rizon, load_path(trajectory), lead_in=0.0)
    period = plant.tier.period
    table = plan.rows(np.arange(round(seconds / period)) * period)
    model = rizon.model(rotor_inertia=plant.tier.rotor_inertia)
    plant.reset(table["q"][0], table["dq"][0])
    rows = []
    for row in table:
        acceleration = row["ddq"] + 400.0 * (row["q"] - plant.q) + 40.0 * (row["dq"] - plant.dtheta)
        plant.step(model.inverse_dynamics(plant.q, plant.dq, acceleration))
        rows.append(np.concatenate([plant.q, plant.dq]))
    return np.array(rows)


@pytest.mark.parametrize("tier", ["ideal", "actuated", "tight_rate", "elastic", "paper_bullet"])
def test_both_engines_agree_over_a_closed_loop_second(has_pybullet, plant_of, rizon, tier):
    """T6 with 3.5 kg that the law does not know, friction and rotor inertia in: 1e-9 rad (F13)."""
    bullet = follow(plant_of("pybullet", tier=tier), rizon, "T6", 1.0)
    reference = follow(plant_of("pinocchio", tier=tier), rizon, "T6", 1.0)
    assert np.ptp(reference[:, :7], axis=0).max() > 0.3
    assert np.abs(bullet[:, :7] - reference[:, :7]).max() < 1e-9


def test_both_engines_agree_through_a_load_step(has_pybullet, plant_of, rizon, rng):
    """Sand on and off while the arm moves; positions and velocities go on."""
    schedule = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.1, SAND), (0.2, Payload(mass=1.5))))
    _, switches = schedule.slots(rizon)
    paths = []
    torques = rng.normal(size=(300, 7)) * 5.0
    for name in ("pinocchio", "pybullet"):
        plant = plant_of(name, load=schedule)
        plant.reset(rizon.home, np.full(7, 0.1))
        path = []
        for k, torque in enumerate(torques):
            if k in (100, 200):
                before = plant.q.copy(), plant.dq.copy()
                plant.set_load(switches[k // 100][1])
                assert np.array_equal(before, (plant.q, plant.dq))
            plant.step(torque + plant.gravity())
            path.append(plant.q.copy())
        paths.append(path)
    assert np.abs(np.array(paths[0]) - np.array(paths[1])).max() < 1e-9


def test_an_arm_held_by_its_gravity_torque_stays(plant_name, plant_of, rizon):
    """To rounding, for half a second, load and all."""
    plant = plant_of(plant_name)
    plant.reset(rizon.home, np.zeros(7))
    for _ in range(500):
        plant.step(plant.gravity())
    assert np.abs(plant.q - rizon.home).max() < 1e-11


def test_an_arm_let_go_falls(plant_name, plant_of, rizon):
    """Simulators hold joints by motors unless told not to; friction alone must not hold this arm either."""
    plant = plant_of(plant_name, tier="actuated")
    plant.reset(rizon.home, np.zeros(7))
    for _ in range(200):
        plant.step(np.zeros(7))
    assert np.abs(plant.q - rizon.home).max() > 0.05


def test_semi_implicit_euler_moves_with_the_new_velocity(plant_name, plant_of, rizon, rng):
    """q+ = q + h dq+, and dq+ = dq + h M^-1 (tau - h(q, dq))."""
    plant = plant_of(plant_name)
    q, dq, torque = rizon.home + 0.1, rng.normal(size=7), rng.normal(size=7)
    model = rizon.model(rotor_inertia=plant.tier.rotor_inertia)
    model.set_payload(plant.payload)
    state = model.at(q, dq)
    expected = dq + 0.001 * np.linalg.solve(state.mass_matrix, torque - state.bias)
    plant.reset(q, dq)
    plant.step(torque)
    assert np.allclose(plant.dq, expected, rtol=0, atol=1e-12)
    assert np.allclose(plant.q, q + 0.001 * plant.dq, rtol=0, atol=1e-15)


def test_the_mass_matrix_is_the_plants_own(plant_name, plant_of, rizon):
    """Rotors and load included, friction's implicit part not: what designs are judged by."""
    plant = plant_of(plant_name, tier="actuated")
    plant.reset(rizon.home, np.full(7, 0.1))
    plant.step(plant.gravity())
    model = rizon.model(rotor_inertia=plant.tier.rotor_inertia)
    model.set_payload(plant.payload)
    assert np.allclose(plant.mass_matrix(), model.mass_matrix(plant.q), rtol=0, atol=1e-12)


def test_friction_never_reverses_a_velocity(plant_of, tmp_path, urdf_of):
    """An arm in the horizontal plane coasts to rest and stays on its side of zero, however small the speed."""
    from torquebench.scenarios.robots import read_robot

    file = tmp_path / "flat.urdf"
    file.write_text(urdf_of("z"))
    robot = read_robot(file)
    tier = build_tier(
        "dry", {"dry": {"coulomb": (50.0,), "viscous": (1.0,), "coulomb_velocity_scale": 0.001}}, np.zeros(1)
    )
    plant = plant_of("pinocchio", tier=tier, load=Payload(mass=0.0), robot=robot)
    for speed in (3.0, 0.1, 1e-3, 1e-6):
        plant.reset(np.zeros(1), np.array([speed]))
        speeds = [speed]
        for _ in range(400):
            plant.step(np.zeros(1))
            speeds.append(plant.dq[0])
        assert np.all(np.diff(speeds) <= 0)
        assert np.min(speeds) >= 0
        assert speeds[-1] < 0.01 * speed


def test_friction_is_coulomb_and_viscous_at_speed(plant_of, tmp_path, urdf_of):
    """On one vertical axis: (I + h beta) a = -tau_C tanh(v / v_s) - b v, with beta = b + tau_C / |v|."""
    from torquebench.scenarios.robots import read_robot

    file = tmp_path / "flat.urdf"
    file.write_text(urdf_of("z"))
    robot = read_robot(file)
    tier = build_tier(
        "dry", {"dry": {"coulomb": (0.6,), "viscous": (0.4,), "coulomb_velocity_scale": 0.02}}, np.zeros(1)
    )
    plant = plant_of("pinocchio", tier=tier, load=Payload(mass=0.0), robot=robot)
    inertia = float(robot.model().mass_matrix(np.zeros(1))[0, 0])
    for speed in (-2.0, 0.5, 0.001):
        plant.reset(np.zeros(1), np.array([speed]))
        plant.step(np.zeros(1))
        slope = 0.4 + 0.6 / max(abs(speed), 0.02)
        force = -0.6 * np.tanh(speed / 0.02) - 0.4 * speed
        expected = speed + 0.001 * force / (inertia + 0.001 * slope)
        assert plant.dq[0] == pytest.approx(expected, rel=1e-12)


def test_the_force_sensor_reads_the_weight_tool_down(plant_name, plant_of, rizon):
    """(0, 0, m g, 0, 0, 0) with m the whole load, gripper included (F9)."""
    plant = plant_of(plant_name)
    plant.reset(rizon.home, np.zeros(7))
    # Home is given to seven digits of a radian: the tool is not down to the last bit.
    assert np.allclose(plant.wrench, [0.0, 0.0, 3.5 * G, 0.0, 0.0, 0.0], rtol=0, atol=2e-5)
    level = rizon.home.copy()
    level[[1, 3, 5]] = np.deg2rad([-40.0, 90.0, 40.0])
    plant.reset(level, np.zeros(7))
    assert np.allclose(plant.wrench, [0.0, 0.0, 3.5 * G, 0.0, 0.0, 0.0], rtol=0, atol=1e-9)


def test_the_force_sensor_reads_newton_and_euler_in_motion(plant_name, plant_of, rizon, rng):
    """Minus what the arm exerts on the load, by recursive Newton-Euler on a tree that ends in the load."""
    plant = plant_of(plant_name)
    q, dq, torque = rizon.home + 0.2, rng.normal(size=7), rng.normal(size=7) * 10
    plant.reset(q, dq)
    plant.step(torque)
    acceleration = (plant.dq - dq) / plant.tier.period
    with_load, without = (pin.buildModelFromXML(rizon.urdf) for _ in range(2))
    flange = with_load.frames[with_load.getFrameId(rizon.flange_frame)]
    gripper = pin.Inertia(rizon.gripper.mass, np.array(rizon.gripper.com), np.array(rizon.gripper.inertia))
    for body in SAND.bodies(rizon):
        inertia = pin.Inertia(body.mass, np.array(body.com), np.array(body.inertia))
        with_load.appendBodyToJoint(flange.parentJoint, inertia, flange.placement)
    joint = flange.parentJoint
    bare = without.inertias[joint] - flange.placement.act(gripper)
    without.inertias[joint] = bare
    forces = []
    for model in (with_load, without):
        data = model.createData()
        pin.rnea(model, data, q, dq, acceleration)
        forces.append(data.f[joint].copy())
    on_load = flange.placement.actInv(forces[0] - forces[1])
    assert np.allclose(plant.wrench, -np.array(on_load.vector), rtol=0, atol=1e-9)


def test_the_payload_is_shown_as_ten_parameters(plant_name, plant_of, rizon):
    """What the oracle may see: the sum of the bodies that are on, the gripper not among them."""
    plant = plant_of(plant_name)
    assert np.allclose(plant.payload, sum(body.parameters for body in SAND.bodies(rizon)), rtol=0, atol=1e-12)
    plant.set_load((False,) * len(plant.slots))
    assert not plant.payload.any()


@pytest.mark.parametrize("tier", ["actuated", "elastic"])
def test_position_and_velocity_are_the_complete_state(plant_name, plant_of, rizon, rng, tier):
    """A plant that is placed again goes the same way to the bit, whatever it did before (F5)."""
    plant = plant_of(plant_name, tier=tier)
    torques = rng.normal(size=(50, 7)) * 10

    def path():
        plant.reset(rizon.home, np.full(7, 0.2))
        found = []
        for torque in torques:
            plant.step(torque)
            found.append(np.concatenate([plant.q, plant.dq, plant.wrench]))
        return np.array(found)

    assert np.array_equal(path(), path())


def test_two_plants_of_one_process_do_not_disturb_each_other(plant_name, plant_of, rizon, rng):
    """Twins run in one worker; Bullet caches files by name and clients by number."""
    torques = rng.normal(size=(40, 7)) * 10

    def path(*plants):
        for plant in plants:
            plant.reset(rizon.home, np.zeros(7))
        for torque in torques:
            for plant in plants:
                plant.step(torque)
        return plants[0].q.copy()

    alone = path(plant_of(plant_name))
    assert np.array_equal(path(plant_of(plant_name), plant_of(plant_name, load=Payload(mass=1.5))), alone)


def test_the_number_of_switches_is_the_number_of_slots(plant_of):
    """A forgotten slot is a slip of the harness and must not pass."""
    plant = plant_of("pinocchio")
    with pytest.raises(ValueError, match="zip"):
        plant.set_load((True,))


def test_a_speed_of_150_rad_per_second_is_not_clamped(has_pybullet, plant_of, rizon):
    """Bullet stops joints at 100 rad/s unless told not to: a divergence must be seen as one."""
    plant = plant_of("pybullet", tier="paper_bullet", load=Payload(mass=1.5))
    speed = np.zeros(7)
    speed[6] = 150.0
    plant.reset(rizon.home, speed)
    plant.step(np.zeros(7))
    assert plant.dq[6] > 140.0


def test_no_joint_stop_bounces_the_arm(has_pybullet, plant_of, rizon):
    """Beyond its limit the arm goes on, and the harness ends the run."""
    plant = plant_of("pybullet", load=Payload(mass=1.5))
    q, speed = rizon.home.copy(), np.zeros(7)
    q[6], speed[6] = rizon.upper[6], 3.0
    plant.reset(q, speed)
    for _ in range(20):
        plant.step(plant.gravity())
    assert plant.q[6] > rizon.upper[6] + 0.04


def test_without_pybullet_the_message_names_the_other_plant(monkeypatch):
    """On Python 3.12 there is no wheel, and one word on the command line is enough."""
    monkeypatch.setitem(sys.modules, "pybullet", None)
    monkeypatch.delitem(sys.modules, "pybullet")
    monkeypatch.setattr("builtins.__import__", _without_pybullet(__import__))
    with pytest.raises(InvalidInput, match=r"PyBullet is not installed.*use --plant pinocchio"):
        pybullet_plant.load_pybullet()


def _without_pybullet(real):
    """Return an import that knows no PyBullet."""

    def guarded(name, *rest):
        if name == "pybullet":
            raise ImportError(name)
        return real(name, *rest)

    return guarded


def test_another_period_is_another_step(plant_of, rizon):
    """The plant's step is the tier's period."""
    fine = replace(build_tier("ideal", rizon.tiers, rizon.rotor_inertia), period=0.0005)
    plant = plant_of("pinocchio", tier=fine)
    plant.reset(rizon.home, np.ones(7))
    plant.step(plant.gravity())
    assert np.allclose(plant.q, rizon.home + 0.0005 * plant.dq, rtol=0, atol=1e-15)


def test_shorter_steps_converge_on_one_motion(plant_of, rizon, plant_name):
    """First order in the step, at one control period: halving it halves what is left."""
    tiers = [replace(build_tier("ideal", rizon.tiers, rizon.rotor_inertia), substeps=n) for n in (1, 2, 4, 32)]
    *coarse, fine = (follow(plant_of(plant_name, tier=tier), rizon, "T6", 0.3)[-1, :7] for tier in tiers)
    left = [np.abs(end - fine).max() for end in coarse]
    assert left[0] / left[1] == pytest.approx(31 / 15, rel=0.1)
    assert left[1] / left[2] == pytest.approx(15 / 7, rel=0.1)
