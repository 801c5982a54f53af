"""The orientation error is a rotation vector with all its digits, near 0 and near pi."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from torquebench.baselines.rotation import rotation_error

RNG = np.random.default_rng(11)
AXES = [*np.eye(3), *(v / np.linalg.norm(v) for v in RNG.standard_normal((4, 3)))]


def error_between(rotation, desired):
    error = np.zeros(3)
    rotation_error(rotation, desired, error)
    return error


@pytest.mark.parametrize("angle", [0.0, 1e-14, 1e-9, 1e-4, 0.3, 1.7, 3.0])
@pytest.mark.parametrize("axis", AXES, ids=range(len(AXES)))
def test_it_returns_the_turn_that_was_made(axis, angle):
    """R_d = exp(v) R gives v, in base axes."""
    start = Rotation.from_rotvec([0.4, -1.1, 2.0])
    desired = Rotation.from_rotvec(angle * axis) * start
    error = error_between(start.as_matrix(), desired.as_matrix())
    assert error == pytest.approx(angle * axis, abs=3e-15 * (1.0 + 1.0 / (np.pi - angle)))


@pytest.mark.parametrize("short", [0.0, 1e-12, 1e-8, 1e-3])
@pytest.mark.parametrize("axis", AXES, ids=range(len(AXES)))
def test_near_pi_the_angle_is_right_and_the_axis_up_to_its_sign(axis, short):
    """The skew part vanishes there, and a formula by its norm divides zero by zero."""
    turn = Rotation.from_rotvec((np.pi - short) * axis).as_matrix()
    error = error_between(np.eye(3), turn)
    assert np.linalg.norm(error) == pytest.approx(np.pi - short, abs=1e-12)
    assert abs(error @ axis) == pytest.approx(np.pi - short, abs=1e-12)
    assert Rotation.from_rotvec(error).as_matrix() == pytest.approx(turn, abs=1e-12)


def test_the_shorter_way_round_is_taken():
    """A turn by 3/2 pi is a turn by -pi/2."""
    turn = Rotation.from_rotvec([0.0, 0.0, 1.5 * np.pi]).as_matrix()
    assert error_between(np.eye(3), turn) == pytest.approx([0.0, 0.0, -0.5 * np.pi], abs=1e-12)


def test_it_agrees_with_the_logarithm_in_tool_axes():
    """R log(R^T R_d) = log(R_d R^T): the base axes of a tool-frame logarithm."""
    for rotation, desired in zip(Rotation.random(50, rng=RNG), Rotation.random(50, rng=RNG), strict=True):
        expected = rotation.apply((rotation.inv() * desired).as_rotvec())
        assert error_between(rotation.as_matrix(), desired.as_matrix()) == pytest.approx(expected, abs=1e-11)
