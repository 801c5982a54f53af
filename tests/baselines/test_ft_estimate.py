"""Payload from the flange's sensor: it weighs, it parts mass from bias in motion, and it tells only real bodies."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.baselines.ft_estimate import FtEstimate
from torquebench.controllers import InvalidInput, Observation, discovery
from torquebench.scenarios.episode import run_episode
from torquebench.scenarios.loads import Body, LoadSchedule, Payload, combine
from torquebench.scenarios.robots import load_robot
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World

TURNED = np.array([0.3, -0.7, -0.4, 1.1, 0.5, 0.8, -0.2])
BALL = Body(mass=1.3, com=np.array([0.02, -0.05, 0.2]), inertia=np.eye(3) * 0.4 * 1.3 * 0.08**2)
UNBIASED = {"force_bias": 0.0, "torque_bias": 0.0}


class Poison:
    """The truth, which no estimator may look at."""

    def __getattribute__(self, name):
        raise AssertionError(f"an estimator read {name!r} of the truth")


class Scale:
    """An ideal sensor between an arm and its gripper with a load."""

    def __init__(self, robot, load=None):
        self.model = pin.buildModelFromXML(robot.urdf)
        self.data = self.model.createData()
        self.flange = self.model.getFrameId(robot.flange_frame)
        bodies = [*robot.gripper_bodies, *([load] if load else [])]
        self.inertia = pin.Inertia.FromDynamicParameters(combine(bodies).parameters)

    def observe(self, q, dq=None, ddq=None, bias=0.0):
        """Return a reading: minus the wrench that moves gripper and load."""
        n = self.model.nv
        dq, ddq = (np.zeros(n) if x is None else x for x in (dq, ddq))
        pin.forwardKinematics(self.model, self.data, q, dq, ddq)
        pin.updateFramePlacements(self.model, self.data)
        velocity = pin.getFrameVelocity(self.model, self.data, self.flange, pin.LOCAL)
        acceleration = pin.getFrameAcceleration(self.model, self.data, self.flange, pin.LOCAL)
        rotation = self.data.oMf[self.flange].rotation
        acceleration -= pin.Motion(rotation.T @ self.model.gravity.linear, np.zeros(3))
        wrench = -(self.inertia * acceleration + velocity.cross(self.inertia * velocity)).vector + bias
        return Observation(time=0.0, q=q, dq=dq, wrench=wrench, command=np.zeros(n), torque=np.zeros(n))


def estimator(robot, **settings):
    """Return an estimator after its reset and the model that it tells."""
    provider, model = FtEstimate(**settings), robot.model()
    provider.reset(model, None, Poison())
    return provider, model


def sway(time):
    """Return joints that start at rest and turn the flange in every direction: cubes of sines."""
    rate = 2.0 + 0.2 * np.arange(7)
    s, c = np.sin(rate * time), np.cos(rate * time)
    a = 0.4
    return TURNED + a * s**3, 3 * a * rate * s**2 * c, 3 * a * rate**2 * (2 * s * c**2 - s**3)


def weighed(provider, load, *, seconds=3.0, bias=0.0):
    """Let an estimator see a load in motion."""
    scale = Scale(load_robot("rizon4s"), load)
    for k in range(round(seconds * 1000)):
        # The harness's sensor reads the last step's wrench: its motion is between two readings of the joints.
        observation = scale.observe(*sway(max(k - 0.5, 0.0) * 1e-3), bias=bias)
        observation.q, observation.dq, _ = sway(k * 1e-3)
        provider.refresh(observation)


def run(specification, provider, *, until=np.inf):
    """Run an episode with a provider that may not see the truth; returns its log and the masses told."""
    world = World(specification, specification.schedule)
    world.times = world.times[world.times < until]
    world.table = world.table[: len(world.times)]
    task = world.task()
    provider.reset(task.robot, task.actuation, Poison())
    controller = discovery.load("controllers", specification.controller)()
    controller.reset(task)
    masses = []
    refresh = provider.refresh

    def recorded(observation):
        refresh(observation)
        masses.append(task.robot.payload[0])

    provider.refresh = recorded
    outcome = run_episode(world.episode(controller, provider))
    assert outcome.failure is None
    return outcome.log["time"], np.array(masses)


def actuated(schedule, **changes):
    """Return a run on the usual tier."""
    settings = {"trajectory": "T1", "laps": 1, "tier": "actuated", "plant": "pinocchio", "robot": "rizon4s", **changes}
    return RunSpecification(controller="computed_torque", schedule=schedule, **settings)


@pytest.mark.parametrize("turn", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("mass", [0.2, 2.0])
def test_at_rest_it_weighs_exactly_whatever_the_orientation(rizon, turn, mass):
    """|f| = m g; without bias nothing else is in the reading."""
    provider, model = estimator(rizon, **UNBIASED)
    scale = Scale(rizon, BALL.scaled(mass / BALL.mass))
    for _ in range(500):
        provider.refresh(scale.observe(rizon.home + turn * TURNED))
    assert provider.estimate[0] == pytest.approx(mass, abs=1e-5)
    assert model.payload[0] == pytest.approx(mass, abs=0.003)


def test_the_gripper_alone_is_no_load(rizon):
    """It is in the reading and in the model already."""
    provider, model = estimator(rizon)
    weighed(provider, None, seconds=0.5)
    assert np.abs(provider.estimate[:4]).max() < 3e-3
    assert model.payload[0] < 0.003


def test_the_model_knows_the_gripper_that_the_plant_carries(rizon):
    """Ten parameters about the flange, from the frames beyond it."""
    assert rizon.model().tool_parameters == pytest.approx(combine(rizon.gripper_bodies).parameters, abs=1e-12)
    assert rizon.model().tool_mass == pytest.approx(rizon.gripper_mass)


def test_in_motion_it_finds_mass_and_centre(rizon):
    """A turning flange shows all of the first moments."""
    provider, model = estimator(rizon)
    weighed(provider, BALL)
    assert provider.estimate[0] == pytest.approx(BALL.mass, rel=0.01)
    assert provider.estimate[1:4] / provider.estimate[0] == pytest.approx(BALL.com, abs=0.005)
    assert model.payload[1:4] / model.payload[0] == pytest.approx(BALL.com, abs=0.008)


def test_at_rest_a_bias_counts_as_mass(rizon):
    """b / g: nothing in a constant reading tells them apart, and the prior on the mass is wide."""
    provider, _ = estimator(rizon)
    scale = Scale(rizon, BALL)
    for _ in range(500):
        provider.refresh(scale.observe(rizon.home, bias=np.array([0.0, 0.0, 0.5, 0.0, 0.0, 0.0])))
    assert provider.estimate[0] == pytest.approx(BALL.mass + 0.5 / 9.81, abs=2e-3)


def test_in_motion_a_bias_is_found(rizon):
    """The load turns with gravity, the bias does not."""
    bias = np.array([0.5, -0.4, 0.6, 0.02, -0.01, 0.02])
    provider, _ = estimator(rizon)
    weighed(provider, BALL, bias=bias)
    assert provider.estimate[4:7] == pytest.approx(bias[:3], abs=0.1)
    assert provider.estimate[0] == pytest.approx(BALL.mass, abs=0.02)


@pytest.mark.parametrize("repetition", range(3))
def test_a_constant_load_is_known_to_80_g_after_half_a_second(repetition):
    """With the usual sensor: bias of 0.5 N, noise of 0.1 N."""
    load = LoadSchedule.constant(Payload(mass=3.5, material="sand"))
    provider = FtEstimate()
    time, masses = run(actuated(load, repetition=repetition), provider)
    assert np.abs(masses[time >= time[0] + 0.5] - 2.314).max() < 0.08
    assert provider.steps == 0


@pytest.mark.parametrize(("before", "after"), [(1.5, 3.5), (3.5, 1.5)])
def test_a_step_of_2_kg_is_known_within_a_quarter_second(before, after):
    """Found in 10 ms, once; what was learnt of the bias stays."""
    loads = [Payload(mass=mass, material="sand" if mass > 1.5 else "none") for mass in (before, after)]
    provider = FtEstimate()
    time, masses = run(actuated(LoadSchedule(entries=((0.0, loads[0]), (1.0, loads[1])))), provider)
    assert np.abs(masses[time >= 1.25] - (after - 1.186)).max() < 0.1
    moved = (np.abs(masses - masses[time < 1.0][-1]) > 0.1) & (time >= 1.0)
    assert time[np.argmax(moved)] == pytest.approx(1.0, abs=0.015)
    assert provider.steps == 1


@pytest.mark.parametrize("trajectory", ["T1", "T6"])
@pytest.mark.parametrize(("before", "after"), [(1.5, 3.5), (3.5, 1.5)])
def test_a_change_of_2_kg_in_motion_is_known_to_3_percent_in_a_tenth_of_a_second(trajectory, before, after):
    """The change, over ten draws of bias and noise: the bias is in both masses and cancels."""
    loads = [Payload(mass=mass, material="sand" if mass > 1.5 else "none") for mass in (before, after)]
    schedule, errors = LoadSchedule(entries=((0.0, loads[0]), (0.5, loads[1]))), []
    for repetition in range(10):
        specification = actuated(schedule, trajectory=trajectory, repetition=repetition)
        time, masses = run(specification, FtEstimate(), until=0.8)
        change = masses[time >= 0.6] - masses[time < 0.5][-1]
        errors.append(np.abs(change - (after - before)).max() / 2.0)
    assert max(errors) < 0.03 and np.median(errors) < 0.02


def test_a_step_too_small_to_be_found_is_followed():
    """Two newtons could be an acceleration; the filter comes after them in its own time."""
    loads = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (1.0, Payload(mass=1.7, material="sand"))))
    provider = FtEstimate()
    time, masses = run(actuated(loads), provider)
    assert provider.steps == 0
    assert np.abs(masses[time > 2.0] - 0.514).max() < 0.05


def test_without_the_step_test_the_filter_would_sleep_through_it():
    """Why there is one: a converged filter takes seconds."""
    loads = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (1.0, Payload(mass=3.5, material="sand"))))
    time, masses = run(actuated(loads), FtEstimate(jump=1e9))
    assert abs(masses[np.searchsorted(time, 1.25)] - 2.314) > 0.5


wrenches = st.lists(st.lists(st.floats(-300.0, 300.0), min_size=6, max_size=6), min_size=1, max_size=8)


@given(wrenches=wrenches)
def test_whatever_the_sensor_says_a_real_body_is_told(wrenches):
    """The pseudo-inertia is positive semi-definite: some distribution of mass has these ten parameters."""
    rizon = load_robot("rizon4s")
    provider, model = estimator(rizon)
    scale = Scale(rizon)
    for wrench in wrenches:
        observation = scale.observe(TURNED)
        observation.wrench = np.array(wrench)
        for _ in range(15):
            provider.refresh(observation)
        m, *first, xx, xy, yy, xz, yz, zz = model.payload
        about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        first = np.array(first)
        pseudo = np.block([[0.5 * np.trace(about) * np.eye(3) - about, first[:, None]], [first[None], np.array([[m]])]])
        assert np.linalg.eigvalsh(pseudo).min() > -1e-9
        assert 0.0 <= m <= provider.mass_limit
        assert np.abs(first).max() <= provider.reach * m + 1e-12


def test_the_model_is_told_rarely(rizon):
    """Every telling makes planners start anew."""
    provider, model = estimator(rizon)
    weighed(provider, BALL, seconds=3.0)
    assert model.revision < 150
    provider.reset(model, None, Poison())
    before, scale = model.revision, Scale(rizon, BALL)
    for _ in range(1000):
        provider.refresh(scale.observe(rizon.home))
    assert model.revision - before < 15


def test_a_reset_forgets_everything(rizon):
    """The same readings give the same bits, whatever came before."""
    provider, _ = estimator(rizon)
    weighed(provider, BALL, seconds=0.2)
    first = provider.estimate
    again = rizon.model()
    again.set_payload(BALL.parameters)
    provider.reset(again, None, Poison())
    assert not again.payload.any() and not provider.estimate.any()
    weighed(provider, BALL, seconds=0.2)
    assert np.array_equal(provider.estimate, first)


def test_the_covariance_stays_symmetric_and_positive(rizon):
    """Component-wise updates lose nothing that a run could feel."""
    provider, _ = estimator(rizon)
    weighed(provider, BALL, seconds=2.0)
    covariance = provider.covariance
    assert covariance == pytest.approx(covariance.T, abs=1e-12)
    assert np.linalg.eigvalsh(covariance).min() > -1e-12


def test_it_works_on_any_arm(arm_of, brick):
    """Nothing is the Rizon's: other axes, a turned flange, no gripper."""
    for n in (1, 2, 6):
        arm, loaded = arm_of(n), arm_of(n)
        provider = FtEstimate(**UNBIASED)
        provider.reset(arm, None, Poison())
        pose = loaded.flange_pose(np.full(n, 0.4))
        force = pose[:3, :3].T @ np.array([0.0, 0.0, -9.81 * brick.mass])
        wrench = np.concatenate([force, np.cross(brick.com, force)])
        still = np.zeros(n)
        for _ in range(300):
            provider.refresh(Observation(time=0.0, q=still + 0.4, dq=still, wrench=wrench, command=still, torque=still))
        assert provider.estimate[0] == pytest.approx(brick.mass, abs=1e-4)


@pytest.mark.parametrize("wrong", [{"corner": 0.0}, {"force_noise": -1.0}, {"jump": "high"}, {"force_bias": -0.1}])
def test_settings_that_mean_nothing_are_refused(wrong):
    """With the setting's name."""
    with pytest.raises(InvalidInput, match=next(iter(wrong))):
        FtEstimate(**wrong)


def test_every_setting_is_in_the_ledger_with_its_value_and_a_word_on_it():
    """A setting without a word is one that nobody can defend."""
    entries = {entry.setting: entry for entry in FtEstimate(corner=20.0).ledger()}
    assert set(entries) == set(vars(FtEstimate()))
    assert entries["corner"].value == 20.0
    assert all(entry.note for entry in entries.values())
