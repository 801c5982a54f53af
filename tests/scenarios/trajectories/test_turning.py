"""Paths on which the tool turns, and the one that makes a load's ten parameters visible."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from torquebench.scenarios.loads import Payload
from torquebench.scenarios.trajectories import HarmonicPath, Plan, load_path, suite
from torquebench.scenarios.trajectories.turning import TurningPath

NOTHING = ((0.0, 0.0, 0.0),)


def turning(**changes):
    """Return a path that neither moves nor turns, apart from the changes."""
    still = {"cosine": NOTHING, "sine": NOTHING, "turn_cosine": NOTHING, "turn_sine": NOTHING}
    return TurningPath(name="mine", period=2.0, centre=(0.5, 0.1, 0.4), **still | changes)


def test_without_a_turn_it_is_the_harmonic_path():
    """Poses, twists and accelerations, to the bit."""
    shape = {"cosine": ((0.1, 0.0, 0.05),), "sine": ((0.0, 0.2, 0.0),)}
    plain, t = HarmonicPath(name="mine", period=2.0, centre=(0.5, 0.1, 0.4), **shape), np.linspace(0.0, 2.0, 9)
    for name in ("pose", "twist", "acceleration"):
        assert np.array_equal(getattr(turning(**shape), name)(t), getattr(plain, name)(t)), name


def test_roll_pitch_and_yaw_turn_about_the_bases_axes():
    """SciPy's extrinsic xyz, before the tool's own rotation."""
    path, t = turning(turn_cosine=((0.3, -0.4, 1.1),)), np.array([0.0, 0.3, 0.9])
    angles = np.cos(np.pi * t)[:, None] * [0.3, -0.4, 1.1]
    expected = Rotation.from_euler("xyz", angles).as_matrix() @ np.array(path.rotation)
    assert path.pose(t)[:, :3, :3] == pytest.approx(expected, abs=1e-14)


def test_a_pure_yaw_spins_about_the_vertical():
    """Angular velocity and acceleration are those of the one angle."""
    path, t = turning(turn_sine=((0.0, 0.0, 0.7),)), np.array([0.1, 0.4])
    assert path.twist(t)[:, 3:] == pytest.approx(np.outer(0.7 * np.pi * np.cos(np.pi * t), [0, 0, 1]), abs=1e-12)
    turn = np.outer(-0.7 * np.pi**2 * np.sin(np.pi * t), [0, 0, 1])
    assert path.acceleration(t)[:, 3:] == pytest.approx(turn, abs=1e-12)


def test_twist_and_acceleration_are_the_derivatives():
    """By central differences, all angles at once."""
    path = load_path("excitation")
    t, h = np.linspace(0.0, path.period, 50), 1e-5
    before, now, after = (path.pose(t + shift)[:, :3, :3] for shift in (-h, 0.0, h))
    spin = (after - before) @ now.transpose(0, 2, 1) / (2 * h)
    assert path.twist(t)[:, 3:] == pytest.approx(np.stack((spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]), 1), abs=1e-7)
    slope = (path.twist(t + h) - path.twist(t - h)) / (2 * h)
    assert path.acceleration(t) == pytest.approx(slope, abs=1e-6)


def test_the_excitation_motion_is_inside_every_limit(rizon):
    """With 3.5 kg and the published rotor inertia: 0.2 rad, 0.6 of the speed, 0.8 of the torque."""
    plan = Plan.build(rizon, load_path("excitation"), lead_in=1.0)
    model = rizon.model(rotor_inertia=rizon.rotor_inertia)
    model.set_payload(sum(body.parameters for body in Payload(mass=3.5, material="sand").bodies(rizon)))
    rows = range(0, len(plan.q), 10)
    torque = [np.abs(model.inverse_dynamics(plan.q[k], plan.dq[k], plan.ddq[k]) / rizon.effort).max() for k in rows]
    assert np.minimum(plan.q - rizon.lower, rizon.upper - plan.q).min() > 0.2
    assert np.abs(plan.dq / rizon.velocity).max() < 0.6
    assert max(torque) < 0.8


def test_it_is_no_motion_of_the_suite():
    """No mean over slow, fast or simulated motions holds it."""
    path = load_path("excitation")
    assert path.group == "excitation"
    assert path.group not in {other.group for other in suite().values()}
