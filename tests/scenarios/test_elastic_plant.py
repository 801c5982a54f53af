"""Arms with elastic joints: conservation, limits, and what the harness sees of both sides of the spring."""

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import Oracle, discovery
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.robots import read_robot
from torquebench.scenarios.tiers import build_tier


@pytest.fixture
def plant_of():
    """Builds a plant of any arm with a tier from constants, closed after the test."""
    opened = []

    def build(name, robot, tier, load=0.0):
        schedule = load if isinstance(load, LoadSchedule) else LoadSchedule.constant(Payload(mass=load))
        slots, switches = schedule.slots(robot)
        if isinstance(tier, dict):
            tier = build_tier("spring", {"spring": tier}, robot.rotor_inertia)
        plant = discovery.load("plants", name)(robot, tier, slots)
        plant.set_load(switches[0][1])
        opened.append(plant)
        return plant

    yield build
    for plant in opened:
        plant.close()


@pytest.fixture(scope="module")
def turntable(tmp_path_factory, urdf_of):
    """One joint on a vertical axis: gravity does nothing, the equations are linear."""
    file = tmp_path_factory.mktemp("arms") / "turntable.urdf"
    file.write_text(urdf_of("z"))
    return read_robot(file)


def inertia_of(robot):
    """Return the link's inertia about the turntable's axis [kg m^2]."""
    return float(robot.model().mass_matrix(np.zeros(1))[0, 0])


SPRING = {"joint_stiffness": (300.0,), "motor_inertia": (0.5,), "substeps": 4}


def test_rotor_and_link_swing_against_each_other_at_the_closed_form(plant_name, plant_of, turntable):
    """omega^2 = K (1/J + 1/M), to the integrator's own frequency: 2 - (omega h)^2 links three samples of the slip."""
    plant = plant_of(plant_name, turntable, SPRING | {"substeps": 1, "joint_stiffness": (60.0,)})
    plant.reset(np.zeros(1), np.zeros(1))
    plant.theta[:] = 0.01
    slip = []
    for _ in range(300):
        plant.step(np.zeros(1))
        slip.append(plant.theta[0] - plant.q[0])
    slip, square = np.array(slip), 60.0 * (1.0 / 0.5 + 1.0 / inertia_of(turntable))
    assert np.allclose(slip[2:], (2.0 - square * 1e-6) * slip[1:-1] - slip[:-2], rtol=0, atol=1e-13)
    assert np.ptp(np.sign(slip)) == 2


def test_momentum_is_what_the_motor_was_given(plant_name, plant_of, turntable):
    """The spring takes from the rotor what it gives to the link: M dq + J dtheta = u t, the rotor counted once."""
    plant = plant_of(plant_name, turntable, SPRING | {"joint_damping_time": 0.001})
    plant.reset(np.zeros(1), np.array([0.3]))
    start = (inertia_of(turntable) + 0.5) * 0.3
    for k in range(1, 200):
        plant.step(np.array([0.7]))
        momentum = inertia_of(turntable) * plant.dq[0] + 0.5 * plant.dtheta[0]
        assert momentum == pytest.approx(start + 0.7 * 0.001 * k, rel=1e-11)


def test_behind_a_torque_loop_the_rotor_feels_a_third(plant_of, turntable):
    """Once the spring is wound up, a steady torque u accelerates M + J / (1 + k_T)."""
    loop = {"torque_feedback_gain": 2.0, "torque_feedback_damping_ratio": 1.0}
    plant = plant_of("pinocchio", turntable, SPRING | loop)
    plant.reset(np.zeros(1), np.zeros(1))
    for _ in range(3000):
        before = plant.dq[0]
        plant.step(np.array([0.2]))
    expected = 0.2 / (inertia_of(turntable) + 0.5 / 3.0)
    assert (plant.dq[0] - before) / 0.001 == pytest.approx(expected, rel=1e-6)
    assert plant.tier.rotor_inertia[0] == pytest.approx(0.5 / 3.0)


def test_the_torque_of_a_step_is_the_mean_that_moved_the_link(plant_name, plant_of, turntable):
    """M (dq+ - dq) / T over all substeps; a sample of the last would miss what the others gave."""
    plant = plant_of(plant_name, turntable, SPRING)
    plant.reset(np.zeros(1), np.zeros(1))
    for asked in (0.5, -2.0, 1.0):
        before = plant.dq.copy()
        plant.step(np.array([asked]))
        assert np.allclose(plant.torque, inertia_of(turntable) * (plant.dq - before) / 0.001, rtol=1e-9, atol=1e-12)


def energy(plant, model):
    """Return the energy of links, rotors, springs and height [J]."""
    joints, q, dq = plant.tier.elasticity, plant.q, plant.dq
    turning = 0.5 * dq @ model.mass_matrix(q) @ dq + 0.5 * joints.motor_inertia @ plant.dtheta**2
    height = pin.computePotentialEnergy(model.model, model.data, q)
    return float(turning + 0.5 * joints.stiffness @ (plant.theta - q) ** 2 + height)


def test_energy_is_conserved_to_the_first_order_of_the_step(plant_name, plant_of, planar_robot):
    """An arm let go, without friction, damping or command: half the step, half the error, and no drift."""
    model, errors = planar_robot.model(), []
    for substeps in (4, 8, 16):
        constants = {"joint_stiffness": (4000.0, 1500.0), "motor_inertia": (0.6, 0.3), "substeps": substeps}
        plant = plant_of(plant_name, planar_robot, constants)
        plant.reset(np.array([0.4, 0.9]), np.zeros(2))
        plant.theta[:] += 0.01
        before = energy(plant, model)
        found = []
        for _ in range(600):
            plant.step(np.zeros(2))
            found.append(energy(plant, model) - before)
        errors.append(np.abs(found).max())
    assert np.abs(plant.q - [0.4, 0.9]).max() > 1.0
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.1)


def path_of(plant, rate):
    """Return 0.1 s of an arm that is let go and shaken."""
    plant.reset(np.array([0.4, 0.9]), np.zeros(2))
    rows = []
    for k in range(round(0.1 / plant.tier.period)):
        plant.step(np.array([2.0, -1.0]) * np.sin(rate * k * plant.tier.period))
        rows.append(plant.q.copy())
    return np.array(rows)


@pytest.mark.parametrize(("loop", "order"), [({}, 4.0), ({"torque_feedback_gain": 2.0}, 4.0)])
def test_with_stiff_springs_the_arm_is_the_rigid_one(plant_of, planar_robot, loop, order):
    """Four times the stiffness, a quarter of the difference; the rotor that is left is J / (1 + k_T)."""
    step, rotors = 2e-5, np.array([0.6, 0.3])
    share = 1.0 / (1.0 + loop.get("torque_feedback_gain", 0.0))
    rigid = build_tier("rigid", {"rigid": {"dt": step, "armature_scale": share}}, rotors)
    reference = path_of(plant_of("pinocchio", planar_robot, rigid), 20.0)
    gaps = []
    for factor in (1.0, 4.0):
        stiffness = (2e4 * factor, 8e3 * factor)
        damping = {"joint_damping_time": 0.002 / factor}
        table = {"dt": step, "joint_stiffness": stiffness, "motor_inertia": tuple(rotors)} | damping | loop
        gaps.append(np.abs(path_of(plant_of("pinocchio", planar_robot, table), 20.0) - reference).max())
    assert gaps[0] / gaps[1] == pytest.approx(order, rel=0.25)
    assert gaps[1] < 1e-2 * np.ptp(reference, axis=0).max()


def test_the_arm_starts_in_the_springs_sag_and_stays(plant_name, plant_of, rizon):
    """theta = q + g / K under 3.5 kg: about 5 mrad in joint 4, and no kick when it is let go."""
    tier = build_tier("elastic", rizon.tiers, rizon.rotor_inertia)
    heavy = LoadSchedule.constant(Payload(mass=3.5, material="sand"))
    plant = plant_of(plant_name, rizon, tier, heavy)
    plant.reset(rizon.home, np.zeros(7))
    sag = plant.gravity() / tier.elasticity.stiffness
    assert np.allclose(plant.theta - plant.q, sag, rtol=0, atol=1e-15)
    assert 0.003 < np.abs(sag[3]) < 0.006
    for _ in range(300):
        plant.step(plant.gravity())
    assert np.abs(plant.q - rizon.home).max() < 1e-10
    assert np.allclose(plant.torque, plant.gravity(), rtol=0, atol=1e-6)


def test_a_load_step_moves_neither_side_of_a_spring(plant_name, plant_of, rizon):
    """Positions and velocities of links and motors go on; the springs find their new sag by themselves."""
    schedule = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.1, Payload(mass=3.5, material="sand"))))
    _, switches = schedule.slots(rizon)
    plant = plant_of(plant_name, rizon, build_tier("elastic", rizon.tiers, rizon.rotor_inertia), schedule)
    plant.reset(rizon.home, np.full(7, 0.1))
    for _ in range(20):
        plant.step(plant.gravity())
    before = [array.copy() for array in (plant.q, plant.dq, plant.theta, plant.dtheta)]
    plant.set_load(switches[1][1])
    assert np.array_equal(before, [plant.q, plant.dq, plant.theta, plant.dtheta])


def test_designs_are_judged_by_links_load_and_the_apparent_rotor(plant_name, plant_of, rizon):
    """Between steps the engine itself carries links and load alone: their rotors turn on their own."""
    plant = plant_of(plant_name, rizon, build_tier("elastic", rizon.tiers, rizon.rotor_inertia), 1.5)
    plant.reset(rizon.home, np.full(7, 0.1))
    plant.step(plant.gravity())
    model = rizon.model(rotor_inertia=rizon.rotor_inertia / 3.0)
    model.set_payload(plant.payload)
    assert np.allclose(plant.mass_matrix(), model.mass_matrix(plant.q), rtol=0, atol=1e-12)
    q, dq, drive = plant.q.copy(), plant.dq.copy(), plant.gravity()
    plant.step(drive)
    assert not plant.model.armature.any()
    assert not np.array_equal(q, plant.q) and not np.array_equal(dq, plant.dq)


def test_the_log_has_what_the_springs_gave_and_controllers_what_was_asked(world_of, play, follows, rizon):
    """A law's model has the apparent rotor in it; the springs' torque has not, and beside it would count it twice."""
    world = world_of(tier="elastic", seconds=0.3)
    log = play(world, follows).log
    asked = np.array([seen["torque"] for seen in follows.seen])
    assert np.allclose(asked[2:], log["limited"][:-2], rtol=0, atol=1e-12)
    model = rizon.model()
    model.set_payload(world.truth.parameters)
    acceleration = np.diff(log["dq"], axis=0) / 0.001
    needed = [
        model.inverse_dynamics(row["q"], row["dq"], ddq).copy() for row, ddq in zip(log, acceleration, strict=False)
    ]
    rotors = 1.06 * np.abs(acceleration[50:]).max()
    assert np.abs(log["torque"][50:-1] - needed[50:]).max() < 0.05 * rotors
    assert np.abs(asked[51:] - needed[50:]).max() > 0.5 * rotors


RDK_STIFFNESS = np.array([3000.0, 3000.0, 800.0, 800.0, 200.0, 200.0, 200.0])
RDK_DAMPING = np.array([80.0, 80.0, 40.0, 40.0, 8.0, 8.0, 8.0])


class Example:
    """The manufacturer's example of joint torque control: gravity, springs, and damping on the measured velocity."""

    def reset(self, task):
        self.robot, self.start = task.robot, task.initial_q.copy()

    def compute(self, observation, target):
        spring = RDK_STIFFNESS * (self.start - observation.q)
        return self.robot.gravity(observation.q) + spring - RDK_DAMPING * observation.dq


@pytest.mark.parametrize("tier", ["ideal", "actuated", "tight_rate", "elastic", "paper_bullet"])
@pytest.mark.parametrize("mass", [1.186, 3.5])
def test_the_manufacturers_example_gains_hold_wherever_there_are_rotors(world_of, play, rng, tier, mass):
    """A small push dies within 0.8 s; without rotors it does so only if a load steadies the wrist (F11)."""
    schedule = LoadSchedule.constant(Payload(mass=mass, material="sand") if mass > 1.5 else Payload(mass=mass))
    world = world_of(tier=tier, trajectory="T1", seconds=0.8, schedule=schedule, knowledge="oracle")
    world.plant.reset(world.plant.q.copy(), rng.uniform(-0.05, 0.05, 7))
    outcome = play(world, Example(), Oracle())
    held = outcome.failure is None and bool(np.abs(outcome.log["dq"][-100:]).max() < 0.02)
    assert held is not (tier == "paper_bullet" and mass < 1.5)
