"""Elastic joints: their constants, and the springs, rotors and torque loop of one locked or free joint."""

import numpy as np
import pytest
from torquebench.controllers import InvalidInput
from torquebench.scenarios.plants.motors import Motors
from torquebench.scenarios.robots import read_robot
from torquebench.scenarios.tiers import build_tier, default_tiers

BARE = {"joint_stiffness": (5000.0,), "motor_inertia": (0.4,)}
"""A spring and a rotor, without damping, friction or torque loop."""
LOOP = {"torque_feedback_gain": 2.0, "torque_feedback_damping_ratio": 1.0}


def tier_of(**constants):
    """Return a tier of one elastic joint, one step of 0.25 ms a period."""
    return build_tier("spring", {"spring": BARE | {"dt": 0.00025} | constants}, np.zeros(1))


class Locked:
    """A motor whose link is held in a vice at zero."""

    def __init__(self, tier, *, theta=0.0, dtheta=0.0):
        self.motors, self.asked = Motors(tier, tier.elasticity), np.zeros(1)
        self.spring, zero = np.zeros(1), np.zeros(1)
        self.turn = self.motors.bind(self.asked, zero, zero.copy(), self.spring, np.ones(1))
        self.motors.theta[:], self.motors.dtheta[:] = theta, dtheta

    def turned(self, steps):
        """Return the motor's position and velocity after each step."""
        rows = []
        for _ in range(steps):
            self.turn()
            rows.append((self.motors.theta[0], self.motors.dtheta[0]))
        return np.array(rows)


def frequency_of(samples, step):
    """Return the frequency of an oscillation about zero from its interpolated crossings [Hz]."""
    before = np.flatnonzero(np.signbit(samples[:-1]) != np.signbit(samples[1:]))
    crossings = before + samples[before] / (samples[before] - samples[before + 1])
    return (len(crossings) - 1) / (2.0 * step * (crossings[-1] - crossings[0]))


def test_the_rizons_constants_are_the_chosen_ones(rizon):
    """Half a harmonic drive's stiffness, the whole rotor, a torque loop of gain 2 and four substeps."""
    tier = build_tier("elastic", rizon.tiers, rizon.rotor_inertia)
    joints = tier.elasticity
    assert joints.stiffness.tolist() == [17000.0, 17000.0, 9000.0, 9000.0, 5500.0, 5500.0, 5500.0]
    assert joints.motor_inertia.tolist() == [3.17, 3.17, 1.38, 1.38, 0.13, 0.13, 0.13]
    assert np.allclose(joints.damping, 0.001 * joints.stiffness, rtol=1e-15, atol=0)
    assert (joints.torque_gain, joints.current_lag, joints.substeps) == (2.0, 0.0005, 4)
    assert (tier.step, tier.torque_lag) == (0.00025, 0.0)
    assert np.allclose(joints.rate_gain, 2.0 * np.sqrt(3.0 * joints.motor_inertia / joints.stiffness), rtol=1e-15)


def test_elastic_is_actuated_in_all_that_is_not_the_joint(rizon):
    """Sensors, friction, delay and limits are equal; so is the rotor inertia that a controller feels."""
    elastic, rigid = (build_tier(name, rizon.tiers, rizon.rotor_inertia) for name in ("elastic", "actuated"))
    for field in rigid.__dataclass_fields__:
        if field not in ("name", "torque_lag", "elasticity", "rotor_inertia", "substeps"):
            assert np.array_equal(getattr(elastic, field), getattr(rigid, field)), field
    assert np.allclose(elastic.rotor_inertia, rigid.rotor_inertia, rtol=1e-15, atol=0)


def test_controllers_are_told_of_springs_and_of_the_current_loop(rizon):
    """On copies; None is no spring. What a model is given is the apparent rotor, once."""
    tier = build_tier("elastic", rizon.tiers, rizon.rotor_inertia)
    facts = tier.actuation(rizon.effort)
    assert (facts.delay_ticks, facts.torque_lag, facts.velocity_filter_hz) == (1, 0.0005, 150.0)
    assert np.allclose(facts.rotor_inertia, rizon.rotor_inertia / 3.0, rtol=1e-15, atol=0)
    assert np.array_equal(facts.joint_stiffness, tier.elasticity.stiffness)
    facts.joint_stiffness[:] = 0.0
    assert tier.elasticity.stiffness.all()
    assert build_tier("actuated", rizon.tiers, rizon.rotor_inertia).actuation(rizon.effort).joint_stiffness is None


def test_a_foreign_arm_gets_springs_scaled_to_its_limits_and_rotors_where_it_has_none():
    """1/140 rad at the torque limit; 0.02 kg m^2 for each newton metre."""
    effort, rotors = np.array([200.0, 10.0]), np.array([1.5, 0.0])
    joints = build_tier("elastic", default_tiers(effort, rotors), rotors).elasticity
    assert np.allclose(joints.stiffness, [28000.0, 1400.0], rtol=1e-15, atol=0)
    assert joints.motor_inertia.tolist() == [1.5, 0.2]
    assert joints.substeps == 4


def test_a_file_may_give_springs_and_must_then_have_rotors(tmp_path, urdf_of):
    """Of the right number; what it lacks is named in one line."""
    (tmp_path / "arm.urdf").write_text(urdf_of("yy"))
    file = tmp_path / "arm.toml"

    def robot(constants):
        file.write_text(f'schema = 1\nname = "arm"\nurdf = "arm.urdf"\n[tiers.elastic]\n{constants}\n')
        return read_robot(file)

    found = robot("joint_stiffness = [900.0, 500.0]\nmotor_inertia = [0.3, 0.2]\nsubsteps = 2")
    tier = build_tier("elastic", found.tiers, found.rotor_inertia)
    assert tier.elasticity.stiffness.tolist() == [900.0, 500.0]
    assert tier.rotor_inertia.tolist() == [0.3, 0.2]
    with pytest.raises(InvalidInput, match=r"tiers\.elastic\.joint_stiffness has 1 numbers"):
        robot("joint_stiffness = [900.0]")
    bare = robot("joint_stiffness = [900.0, 500.0]")
    with pytest.raises(InvalidInput, match=r"joint 1 has no rotor inertia.*give rotor_inertia or motor_inertia"):
        build_tier("elastic", bare.tiers, bare.rotor_inertia)


@pytest.mark.parametrize("gain", [0.0, 2.0])
def test_a_rotor_swings_against_a_locked_link_at_its_closed_form(gain):
    """omega^2 = (1 + k_T) K / J: the torque loop stiffens the joint as it lightens the rotor."""
    tier = tier_of(torque_feedback_gain=gain)
    swing = Locked(tier, theta=0.001).turned(4000)[:, 0]
    omega = np.sqrt((1.0 + gain) * 5000.0 / 0.4)
    assert frequency_of(swing, tier.step) == pytest.approx(omega / (2.0 * np.pi), rel=2e-3)
    # Semi-implicit Euler swings exactly at cos(w h) = 1 - (omega h)^2 / 2.
    middle = (2.0 - (omega * tier.step) ** 2) * swing[1:-1]
    assert np.allclose(swing[2:], middle - swing[:-2], rtol=0, atol=1e-15)


def test_a_torque_that_is_asked_for_arrives_whole_and_without_overshoot():
    """The spring gives tau / K: no steady error for all the loop's finite gain, and critically damped."""
    tier = tier_of(dt=1e-5, **LOOP)
    joint = Locked(tier)
    joint.asked[:] = 8.0
    path = joint.turned(20000)[:, 0]
    assert path[-1] == pytest.approx(8.0 / 5000.0, rel=1e-9)
    assert np.all(np.diff(path) >= -1e-15)
    omega, time = np.sqrt(3.0 * 5000.0 / 0.4), tier.step * np.arange(1, 20001)
    expected = 8.0 / 5000.0 * (1.0 - (1.0 + omega * time) * np.exp(-omega * time))
    assert np.abs(path - expected).max() < 5e-3 * path[-1]


def test_friction_acts_on_the_motor_and_never_throws_it_back():
    """(J + h beta) a = -tau_C tanh(v / v_s) - b v, with the spring slack and its stiffness next to nothing."""
    dry = {"coulomb": (0.6,), "viscous": (0.4,), "coulomb_velocity_scale": 0.02}
    tier = tier_of(joint_stiffness=(1e-30,), **dry)
    for speed in (-2.0, 0.5, 0.001):
        (_, after), *_ = Locked(tier, dtheta=speed).turned(1)
        slope = 0.4 + 0.6 / max(abs(speed), 0.02)
        force = -0.6 * np.tanh(speed / 0.02) - 0.4 * speed
        assert after == pytest.approx(speed + tier.step * force / (0.4 + tier.step * slope), rel=1e-12)
        speeds = Locked(tier, dtheta=speed).turned(20000)[:, 1]
        assert np.all(np.sign(speed) * speeds >= -1e-20) and abs(speeds[-1]) < 1e-3 * abs(speed)


def test_the_current_loop_is_a_first_order_lag_in_whatever_steps():
    """Half a millisecond is half a millisecond with one substep or ten."""
    for step in (0.0001, 0.00025, 0.0005):
        tier = tier_of(dt=step, current_loop_time_constant=0.0005, joint_stiffness=(1e-30,))
        joint = Locked(tier)
        joint.asked[:] = 1.0
        speeds = joint.turned(round(0.001 / step))[:, 1]
        current = 1.0 - np.exp(-step * np.arange(1, len(speeds) + 1) / 0.0005)
        assert np.allclose(speeds, step * np.cumsum(current) / 0.4, rtol=1e-12, atol=0)
