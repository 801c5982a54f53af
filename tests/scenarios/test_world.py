"""The world of a run at its first tick, and what is shared between worlds."""

import numpy as np
import pytest
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.log import quaternions

HEAVY = Payload(mass=3.5, material="sand")


def test_a_run_lasts_its_lead_in_and_whole_laps(run_of, world_of):
    """0.2 s and a lap of 2 s: 2200 ticks, the last at 1.999 s."""
    world = world_of(seconds=9.0)
    assert len(world.times) == len(world.table) == 2200
    assert (world.times[0], world.times[200], world.times[-1]) == (-0.2, 0.0, 1.999)
    assert world.task().duration == 2.0


def test_the_arm_starts_at_rest_on_the_plan_with_its_load(world_of):
    """Position of the first tick, no velocity, the first load from the start."""
    world = world_of(schedule=LoadSchedule(entries=((5.0, HEAVY), (9.0, Payload(mass=1.5)))))
    assert np.array_equal(world.plant.q, world.table["q"][0])
    assert not world.plant.dq.any()
    assert world.truth.parameters[0] == pytest.approx(2.314, abs=1e-12)


def test_a_cold_start_is_an_arm_at_rest_under_a_moving_reference(world_of):
    """Without a lead-in the first tick is t = 0, the arm is where the plan is and stands still, the plan moves."""
    world = world_of(lead_in=0.0, seconds=9.0)
    assert (world.times[0], world.times[-1], len(world.times)) == (0.0, 1.999, 2000)
    assert np.array_equal(world.plant.q, world.table["q"][0])
    assert np.array_equal(world.plant.q, world.plan.q[0])
    assert not world.plant.dq.any()
    assert np.array_equal(world.table["dq"][0], world.plan.dq[0])
    assert np.linalg.norm(world.plan.dq[0]) > 0.1


def test_events_fall_on_the_tick_of_their_time(world_of):
    """The lead-in comes before zero."""
    world = world_of(schedule=LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.5, HEAVY), (1.2, Payload(mass=1.5)))))
    assert sorted(world.loads) == [700, 1400]


def test_an_event_before_the_first_tick_is_refused(world_of):
    """It would never happen, and the run would be called a load step."""
    early = LoadSchedule(entries=((-5.0, Payload(mass=1.5)), (-1.0, HEAVY)))
    with pytest.raises(InvalidInput, match=r"a load change at -1 s, the run starts at -0.2 s; make it the first entry"):
        world_of(schedule=early)


def test_each_task_has_a_model_of_its_own_without_the_load(world_of):
    """Knowledge is granted later, and to one controller."""
    world = world_of(schedule=LoadSchedule.constant(HEAVY))
    one, two = world.task(), world.task()
    assert one.robot is not two.robot
    assert not one.robot.payload.any()
    one.robot.set_payload(world.truth.parameters)
    assert not two.robot.payload.any()
    assert np.array_equal(one.robot.rotor_inertia, world.tier.rotor_inertia)


def test_a_task_tells_what_everyone_may_know(world_of):
    """Period, start, drives, level."""
    task = world_of(tier="actuated", knowledge="oracle", repetition=4).task()
    assert (task.period, task.knowledge, task.repetition, task.actuation.tier) == (0.001, "oracle", 4, "actuated")
    assert task.reference.lead_in == 0.2
    assert np.array_equal(task.initial_q, task.reference.preview(np.array([-0.2])).q[0])


def test_all_controllers_and_loads_meet_the_same_noise(world_of, play, holds, follows):
    """Bias and noise of the force sensor are the scenario's."""
    first = play(world_of(tier="actuated"), holds).log
    second = play(world_of(tier="actuated", controller="other", schedule=LoadSchedule.constant(HEAVY)), follows).log
    noise = [log["wrench_measured"][0] - log["wrench"][0] for log in (first, second)]
    assert np.allclose(noise[0], noise[1], rtol=0, atol=1e-12)
    assert np.abs(noise[0]).max() > 0.01


def test_another_repetition_meets_other_noise(world_of, play, holds):
    """Ten repetitions are ten samples."""
    logs = [play(world_of(tier="actuated", repetition=i), holds).log for i in range(2)]
    assert not np.allclose(*(log["wrench_measured"][0] - log["wrench"][0] for log in logs), rtol=0, atol=1e-6)


def test_the_ideal_tiers_sensors_have_no_noise(world_of, play, holds):
    """To the bit."""
    log = play(world_of(), holds).log
    assert np.array_equal(log["wrench_measured"], log["wrench"])
    assert np.array_equal(log["q_measured"], log["q"])


def test_the_bias_is_drawn_once_a_run_with_its_spread(world_of):
    """0.5 N and 0.02 N m over two hundred repetitions, within four standard errors."""
    from torquebench.controllers import NoKnowledge

    world = world_of(tier="actuated", seconds=0.001)
    biases = []
    for repetition in range(200):
        object.__setattr__(world.specification, "repetition", repetition)
        biases.append(world.episode(None, NoKnowledge()).constants["wrench_bias"][0].copy())
    spread = np.std(biases, axis=0) / [0.5, 0.5, 0.5, 0.02, 0.02, 0.02]
    assert np.all(np.abs(spread - 1.0) < 4 / np.sqrt(400))
    assert np.all(np.abs(np.mean(biases, axis=0)) < 4 * np.array([0.5, 0.5, 0.5, 0.02, 0.02, 0.02]) / np.sqrt(200))


def test_the_run_log_holds_the_tools_true_pose_beside_the_plan(world_of, play, follows, rizon):
    """What metrics read: rows of equal length, poses by forward kinematics of the true joints."""
    world = world_of(tier="actuated")
    outcome = play(world, follows)
    log = world.run_log(outcome)
    model = rizon.model()
    for k in (0, 60, 99):
        pose = model.forward_kinematics(log.q[k].copy())
        assert np.allclose(log.p[k], pose[:3, 3], rtol=0, atol=1e-15)
        assert np.allclose(rotation_of(log.quat[k]), pose[:3, :3], rtol=0, atol=1e-14)
    assert np.array_equal(log.p_ref, world.table["pose"][:, :3, 3])
    assert np.array_equal(log.q_ref, world.table["q"])
    assert (log.dt, log.lap) == (0.001, 2.0)
    assert np.array_equal(log.torque_rate, world.tier.torque_rate)
    assert np.array_equal(log.tau_lim, outcome.log["limited"])
    assert np.array_equal(log.call_time, outcome.log["call_time"] * 1e-9)
    for k in (0, 60, 99):
        assert np.allclose(log.twist[k], model.at(log.q[k], log.dq[k]).jacobian @ log.dq[k], rtol=0, atol=1e-12)


def rotation_of(xyzw):
    """Return the rotation of a quaternion, scalar last."""
    from torquebench.scenarios.axes import rotation_from_quaternion

    return rotation_from_quaternion(np.roll(xyzw, 1))


def test_the_log_holds_the_load_only_where_it_is_one(world_of, play, holds):
    """Work by mass has no meaning over a change of mass."""
    one = LoadSchedule.constant(HEAVY)
    two = LoadSchedule(entries=((0.0, HEAVY), (0.5, Payload(mass=1.5))))
    masses = []
    for schedule in (one, two):
        world = world_of(seconds=0.002, schedule=schedule)
        masses.append(world.run_log(play(world, holds)).mass)
    assert masses == [HEAVY.mass, None]


def test_without_a_rate_limit_the_log_says_none(world_of, play, holds):
    """Metrics of saturation leave it out then."""
    world = world_of(seconds=0.002)
    assert world.run_log(play(world, holds)).torque_rate is None


def test_quaternions_are_scalar_last():
    """A quarter turn about z: (0, 0, s, s)."""
    quarter = np.array([[[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    assert np.allclose(quaternions(quarter), [[0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)]], rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robot": "rizon4"}, "unknown robot 'rizon4'; did you mean 'rizon4s'"),
        ({"trajectory": "T66"}, "unknown trajectory 'T66'; did you mean"),
        ({"plant": "pinochio"}, "unknown plant 'pinochio'; did you mean 'pinocchio'"),
        ({"tier": "actuate"}, "unknown tier 'actuate'; did you mean 'actuated'"),
        ({"tool": "grip"}, "unknown tool of robot rizon4s 'grip'"),
    ],
)
def test_a_world_that_cannot_be_built_says_what_is_missing(world_of, change, message):
    """In one line, with the nearest."""
    with pytest.raises(UnknownName, match=message):
        world_of(**change)
