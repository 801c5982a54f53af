"""The horizon's matrices: exact integration, and a cost that ends where the endless one would."""

import control
import numpy as np
import pytest
from torquebench.baselines.mpc_horizon import Horizon, terminal_cost, tracking_cost

INTERVAL, BLOCKS = 0.02, (1, 1, 1, 1, 2, 2, 4, 8)


@pytest.mark.parametrize("blocks", [BLOCKS, (1,) * 20, (3, 1)])
def test_the_matrices_integrate_piecewise_constant_accelerations(blocks):
    """Knot by knot, as a body with constant acceleration moves."""
    horizon = Horizon.of(blocks, INTERVAL)
    v = np.random.default_rng(0).standard_normal(len(blocks))
    position = velocity = 0.0
    for k, acceleration in enumerate(np.repeat(v, blocks)):
        assert horizon.position[k] @ v == pytest.approx(position, abs=1e-15)
        assert horizon.velocity[k] @ v == pytest.approx(velocity, abs=1e-14)
        position += INTERVAL * velocity + 0.5 * INTERVAL**2 * acceleration
        velocity += INTERVAL * acceleration
    assert horizon.position[-1] @ v == pytest.approx(position, abs=1e-14)
    assert horizon.knots == sum(blocks)


@pytest.mark.parametrize("bandwidth", [20.0, 40.0])
@pytest.mark.parametrize("knots", [1, 5, 20])
def test_without_limits_any_horizon_is_the_regulator(bandwidth, knots):
    """The terminal cost is all that comes after: how far one looks must not matter where nothing is limited."""
    horizon = Horizon.of((1,) * knots, INTERVAL)
    cost = tracking_cost(horizon, bandwidth)
    start = np.array([0.3, -2.0])
    drift = np.stack([start[0] + INTERVAL * np.arange(knots + 1) * start[1], np.full(knots + 1, start[1])], axis=1)
    states = np.stack([horizon.position, horizon.velocity], axis=1)
    slope = np.einsum("ksb,kst,kt->b", states[1:], cost.weights, drift[1:])
    plan = np.linalg.solve(cost.hessian(horizon), -slope)
    chain, drive = np.array([[1.0, INTERVAL], [0.0, 1.0]]), np.array([[0.5 * INTERVAL**2], [INTERVAL]])
    gain, _, _ = control.dlqr(chain, drive, np.diag([bandwidth**4, 2.0 * bandwidth**2]), np.eye(1))
    assert plan[0] == pytest.approx(-(gain @ start).item(), rel=1e-9)


def test_the_terminal_cost_solves_the_riccati_equation():
    """P = Q + A' P A - A' P B (1 + B' P B)^-1 B' P A."""
    w = 40.0
    a, b = np.array([[1.0, INTERVAL], [0.0, 1.0]]), np.array([[0.5 * INTERVAL**2], [INTERVAL]])
    p = terminal_cost(w, INTERVAL)
    gain = b.T @ p @ a / (1.0 + b.T @ p @ b)
    assert np.diag([w**4, 2 * w**2]) + a.T @ p @ a - a.T @ p @ b @ gain == pytest.approx(p, rel=1e-9)
