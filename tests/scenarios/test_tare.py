"""A tare before the run: the sensor's bias weighed off with the gripper alone, and nothing else changed."""

import numpy as np
import pytest
from scipy.signal import lfilter
from torquebench.controllers import NoKnowledge
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.streams import scenario_stream
from torquebench.scenarios.tare import TARE_TICKS, gripper_wrench

HEAVY = LoadSchedule.constant(Payload(mass=3.5, material="sand"))


@pytest.fixture
def episode_of(world_of):
    """Builds an episode on the usual tier, tared unless told otherwise."""

    def build(**changes):
        world = world_of(**{"tier": "actuated", "tare": True} | changes)
        return world.episode(None, NoKnowledge())

    return build


def bias(episode):
    """Return what is added to every reading."""
    return episode.constants["wrench_bias"][0].copy()


def test_what_remains_of_the_bias_is_the_mean_of_the_noise(episode_of, world_of):
    """The gripper cancels, the bias cancels; the noise has passed the sensor's own filter."""
    tared, world = episode_of(), world_of(tier="actuated")
    noise = world.tier.wrench_noise * scenario_stream("tare", world.specification).standard_normal((TARE_TICKS, 6))
    gain = tared.constants["wrench_gain"][0]
    mean = lfilter([gain], [1.0, gain - 1.0], noise, axis=0).mean(axis=0)
    assert bias(tared) == pytest.approx(-mean, abs=1e-9)
    assert np.abs(bias(episode_of(tare=False))[:3]).max() > 0.1 > 5 * np.abs(bias(tared)[:3]).max()


def test_a_tare_moves_no_other_draw(episode_of):
    """Tared and untared runs are a pair."""
    assert np.array_equal(episode_of().noise, episode_of(tare=False).noise)


def test_every_load_and_length_of_a_motion_has_the_same_tare(episode_of):
    """Twins and variants share every draw; what hangs there later is not on the scale."""
    first = bias(episode_of())
    for change in ({"schedule": HEAVY}, {"laps": 3}, {"latency": 2}, {"controller": "other"}):
        assert np.array_equal(bias(episode_of(**change)), first), change
    assert not np.array_equal(bias(episode_of(repetition=1)), first)


def test_an_exact_sensor_has_nothing_to_tare(episode_of, plant_name):
    """To the rounding of the gripper's weight, in either plant."""
    assert np.abs(bias(episode_of(tier="ideal", plant=plant_name))).max() < 1e-9


def test_the_first_load_hangs_there_when_the_run_begins(world_of):
    """The scale was read without it."""
    tared, plain = (world_of(tare=tare, schedule=HEAVY).plant for tare in (True, False))
    assert np.array_equal(tared.wrench, plain.wrench)
    assert np.linalg.norm(tared.wrench[:3]) == pytest.approx(3.5 * 9.81, abs=1e-9)


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_the_known_gripper_weighs_what_its_parts_weigh(rizon, turn):
    """About the flange, in its axes: the sum over its bodies."""
    q = rizon.home + turn
    model = rizon.model()
    down = model.flange_pose(q)[:3, :3].T @ [0.0, 0.0, -9.81]
    forces = [body.mass * down for body in rizon.gripper_bodies]
    moments = [np.cross(body.com, force) for body, force in zip(rizon.gripper_bodies, forces, strict=True)]
    assert gripper_wrench(model, q) == pytest.approx(np.concatenate([sum(forces), sum(moments)]), abs=1e-9)


def test_without_a_gripper_the_bare_flange_is_tared(planar_robot):
    """Nothing is known to hang there, nothing is subtracted."""
    assert not gripper_wrench(planar_robot.model(), np.array([0.3, 0.4])).any()
