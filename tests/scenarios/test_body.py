"""Rigid bodies on the flange and their union."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from torquebench.controllers import InvalidInput
from torquebench.scenarios.body import Body, combine

places = arrays(float, 3, elements=st.floats(-0.5, 0.5))
masses = st.floats(0.01, 5.0)


def ball(mass, com):
    """Return a small ball."""
    return Body(mass=mass, com=com, inertia=np.diag([0.001, 0.002, 0.0025]) * mass)


def test_the_ten_parameters_are_those_of_pinocchio(brick):
    """m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the flange: the order the model takes them in."""
    spatial = pin.Inertia(brick.mass, np.array(brick.com), np.array(brick.inertia))
    assert np.allclose(brick.parameters, spatial.toDynamicParameters(), rtol=0, atol=1e-15)


@given(masses, places, masses, places)
def test_a_union_has_the_sum_of_the_parameters(mass, com, other_mass, other_com):
    """About one point, mass, first moments and tensors add up: Steiner in both directions."""
    one, two = ball(mass, com), ball(other_mass, other_com)
    union = combine([one, two])
    assert np.allclose(union.parameters, one.parameters + two.parameters, rtol=1e-12, atol=1e-14)


def test_two_equal_balls_have_their_centre_between_them():
    """A dumb-bell of 2 x 1 kg, 1 m long: 2 m r^2 = 0.5 kg m^2 across, nothing more along."""
    ends = [Body(mass=1.0, com=np.array([x, 0.0, 0.0]), inertia=np.zeros((3, 3))) for x in (0.0, 1.0)]
    union = combine(ends)
    assert union.mass == 2.0
    assert union.com.tolist() == [0.5, 0.0, 0.0]
    assert np.allclose(union.inertia, np.diag([0.0, 0.5, 0.5]), rtol=0, atol=1e-16)


def test_nothing_weighs_nothing():
    """No division by the mass."""
    union = combine([])
    assert union.mass == 0.0
    assert not union.parameters.any()


def test_a_scaled_body_keeps_its_centre(brick):
    """Half the density: half of everything else."""
    half = brick.scaled(0.5)
    assert np.array_equal(half.com, brick.com)
    assert np.allclose(half.parameters, 0.5 * brick.parameters, rtol=1e-15, atol=0)


def test_equal_bodies_are_one_slot(brick):
    """A simulator gets one link for each distinct body: equality is to the bit, and zero has no sign."""
    twin = Body(mass=brick.mass, com=brick.com.copy(), inertia=brick.inertia.copy())
    assert twin == brick
    assert len({twin, brick}) == 1
    plus, minus = (Body(mass=1.0, com=np.array([zero, 0.0, 0.1]), inertia=np.eye(3)) for zero in (0.0, -0.0))
    assert plus == minus
    assert hash(plus) == hash(minus)
    assert plus != plus.scaled(1.0 + 1e-15)
    assert plus != "a body"


def test_no_later_change_reaches_a_body():
    """Its arrays are copies and read-only."""
    com = np.array([0.0, 0.0, 0.1])
    body = Body(mass=1.0, com=com, inertia=np.eye(3))
    com[2] = 5.0
    assert body.com[2] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        body.inertia[0, 0] = 2.0


@pytest.mark.parametrize("mass", [-1.0, float("nan"), float("inf")])
def test_a_mass_must_be_a_mass(mass):
    """Pinocchio would compute with a negative one."""
    with pytest.raises(InvalidInput, match=r"body: mass .* kg; masses are finite and not negative"):
        Body(mass=mass, com=np.zeros(3), inertia=np.eye(3))


@pytest.mark.parametrize(
    ("com", "inertia", "what"),
    [
        (np.zeros(2), np.eye(3), "centre of mass of shape"),
        (np.zeros(3), np.ones(3), "inertia of shape"),
        (np.array([0.0, np.nan, 0.0]), np.eye(3), "centre of mass of shape"),
    ],
)
def test_shapes_and_numbers_are_checked(com, inertia, what):
    """The message names the part."""
    with pytest.raises(InvalidInput, match=what):
        Body(mass=1.0, com=com, inertia=inertia)
