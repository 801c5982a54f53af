"""Rotations and principal axes: an inertia must read back the same in every engine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation
from torquebench.scenarios.axes import (
    parallel_axis,
    principal_axes,
    rotation_from_quaternion,
    rotation_from_rpy,
    rpy_from_rotation,
)

angles = arrays(float, 3, elements=st.floats(-np.pi, np.pi))


@given(angles)
def test_roll_pitch_yaw_turn_about_fixed_axes_in_this_order(rpy):
    """URDF's convention, by an independent library."""
    assert np.allclose(rotation_from_rpy(rpy), Rotation.from_euler("xyz", rpy).as_matrix(), rtol=0, atol=1e-14)


@given(angles)
def test_roll_pitch_yaw_read_back_to_the_same_rotation(rpy):
    """The angles need not come back, the rotation must."""
    rotation = rotation_from_rpy(rpy)
    assert np.allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation, rtol=0, atol=1e-14)


@given(st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi), st.sampled_from([-0.5, 0.5]))
def test_a_pitch_of_ninety_degrees_reads_back_exactly(roll, yaw, quarter):
    """Where yaw and roll turn about one axis, textbook formulas lose half the digits."""
    rotation = rotation_from_rpy(np.array([roll, quarter * np.pi, yaw]))
    assert np.allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation, rtol=0, atol=1e-14)


@given(arrays(float, 4, elements=st.floats(-1, 1)).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_a_quaternion_of_any_length_is_its_rotation(quaternion):
    """Order w, x, y, z, as MuJoCo writes it."""
    w, x, y, z = quaternion
    expected = Rotation.from_quat([x, y, z, w]).as_matrix()
    assert np.allclose(rotation_from_quaternion(quaternion), expected, rtol=0, atol=1e-14)


@given(angles, arrays(float, 3, elements=st.floats(0.001, 0.1)))
def test_principal_axes_give_the_tensor_back(rpy, moments):
    """Right-handed, so that they can be written as a rotation."""
    axes = rotation_from_rpy(rpy)
    tensor = axes @ np.diag(moments) @ axes.T
    tensor = 0.5 * (tensor + tensor.T)
    found, turned = principal_axes(tensor)
    # Orthonormal to a few units in the last place is what an eigensolver promises; the tensor inherits it.
    rounding = 16.0 * np.finfo(float).eps * moments.max()
    assert np.allclose(turned @ np.diag(found) @ turned.T, tensor, rtol=0, atol=rounding)
    assert np.linalg.det(turned) == pytest.approx(1.0, abs=1e-12)


def test_a_diagonal_tensor_keeps_its_order():
    """Sorting the moments would turn a link that needs no turning."""
    moments, axes = principal_axes(np.diag([0.3, 0.1, 0.2]))
    assert moments.tolist() == [0.3, 0.1, 0.2]
    assert np.array_equal(axes, np.eye(3))


def test_steiner_adds_nothing_along_the_offset():
    """2 kg at 0.5 m on z: 0.5 kg m^2 across, none about z."""
    assert np.allclose(parallel_axis(2.0, np.array([0.0, 0.0, 0.5])), np.diag([0.5, 0.5, 0.0]), rtol=0, atol=1e-16)
