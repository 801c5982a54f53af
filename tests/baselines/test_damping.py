"""Damping designs: symmetric, positive, and with the ratio that was asked for."""

import numpy as np
import pytest
from scipy.linalg import eigh, sqrtm
from torquebench.baselines.damping import (
    DAMPING_DESIGNS,
    FREQUENCY_FLOOR,
    double_diagonalised_damping,
    square_root_damping,
    tool_mobility,
)

STIFFNESS = np.repeat([10000.0, 1500.0], 3)


def designed(design, mobility, ratio=0.7, stiffness=STIFFNESS):
    damping, inertia = np.zeros((6, 6)), np.zeros((6, 6))
    design(mobility, stiffness, ratio, damping, inertia)
    return damping, inertia


@pytest.fixture
def mobility(bench):
    """The mobility of a seven-joint arm's tool."""
    state = (arm := bench("seven")).model.at(arm.plan.centre, np.zeros(7))
    found = np.zeros((6, 6))
    tool_mobility(state.mass_matrix, state.jacobian, found)
    return found


@pytest.mark.parametrize("arm", ["planar", "six", "seven"])
def test_mobility_is_j_times_inverse_mass_times_j_transposed(bench, arm):
    """By a factorisation, for any number of joints."""
    state = (arm := bench(arm)).model.at(arm.plan.centre, np.zeros(arm.model.n))
    found = np.full((6, 6), np.nan)
    tool_mobility(state.mass_matrix, state.jacobian, found)
    expected = state.jacobian @ np.linalg.solve(state.mass_matrix, state.jacobian.T)
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    assert np.array_equal(found, found.T)


@pytest.mark.parametrize("design", DAMPING_DESIGNS.values(), ids=DAMPING_DESIGNS)
def test_both_designs_are_symmetric_positive_and_invert_the_mobility(design, mobility):
    """A damper that feeds a mode would be a motor."""
    damping, inertia = designed(design, mobility)
    assert damping == pytest.approx(damping.T, rel=1e-12, abs=1e-12)
    assert np.linalg.eigvalsh(damping).min() > 0.0
    assert inertia @ mobility == pytest.approx(np.eye(6), abs=1e-9)


def test_every_mode_of_the_double_diagonalisation_has_the_ratio(mobility):
    """Modes s^2 + 2 zeta omega s + omega^2 of the pair (Lambda, K), all with one zeta."""
    ratio = 0.6
    damping, inertia = designed(double_diagonalised_damping, mobility, ratio)
    squares, modes = eigh(np.diag(STIFFNESS), inertia)
    assert np.sqrt(squares).min() > FREQUENCY_FLOOR
    expected = np.diag(2.0 * ratio * np.sqrt(squares))
    assert modes.T @ damping @ modes == pytest.approx(expected, abs=1e-8 * expected.max())


def test_the_square_root_design_is_its_formula(mobility):
    """D = zeta (L^1/2 K^1/2 + K^1/2 L^1/2) with L = A^-1."""
    damping, inertia = designed(square_root_damping, mobility)
    root, spring = sqrtm(np.linalg.inv(mobility)).real, np.diag(np.sqrt(STIFFNESS))
    expected = 0.7 * (root @ spring + spring @ root)
    assert damping == pytest.approx(expected, abs=1e-9 * expected.max())
    assert inertia == pytest.approx(np.linalg.inv(mobility), rel=1e-8, abs=1e-9)


def test_both_designs_agree_where_inertia_and_stiffness_share_their_axes():
    """A diagonal inertia: d_i = 2 zeta sqrt(k_i m_i), the textbook's damper."""
    masses = np.array([3.0, 5.0, 8.0, 0.1, 0.2, 0.3])
    for design in DAMPING_DESIGNS.values():
        damping, _ = designed(design, np.diag(1.0 / masses))
        assert damping == pytest.approx(np.diag(1.4 * np.sqrt(STIFFNESS * masses)), abs=1e-9)


def test_a_singular_direction_is_damped_as_if_at_the_floor():
    """Below 8 rad/s the double diagonalisation damps with k / 8 and no more: a lost direction has infinite inertia."""
    masses = np.array([1e6, 5.0, 5.0, 0.1, 0.1, 0.1])
    damping, inertia = designed(double_diagonalised_damping, np.diag(1.0 / masses))
    assert damping[0, 0] == pytest.approx(1.4 * 10000.0 / FREQUENCY_FLOOR)
    # The inertia that the projector needs is not floored with it.
    assert inertia[0, 0] == pytest.approx(1e6)


@pytest.mark.parametrize("design", DAMPING_DESIGNS.values(), ids=DAMPING_DESIGNS)
def test_an_immobile_direction_leaves_everything_finite(design):
    """Arms of fewer than six joints have such directions always."""
    damping, inertia = designed(design, np.diag([0.0, 0.2, 0.2, 10.0, 10.0, 10.0]))
    assert np.all(np.isfinite(damping))
    assert np.all(np.isfinite(inertia))
