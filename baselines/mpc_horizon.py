"""What a horizon of piecewise constant accelerations does to a double integrator, and what it should cost."""

from dataclasses import dataclass
from functools import cache

import numpy as np


@dataclass(frozen=True, eq=False)
class Horizon:
    r"""Condensed matrices of one joint: states at the knots as a function of start and accelerations.

    .. math:: q_k = q_0 + k h \dot q_0 + \Gamma^q_k v, \quad \dot q_k = \dot q_0 + \Gamma^v_k v, \quad u_k = S_k v

    with v the accelerations of the blocks: neighbouring knots may share one. The double integrator is exact between
    knots, so no integration enters. All joints have the same matrices.
    Source: Maciejowski, Predictive Control with Constraints (2002), chapter 3.

    Attributes:
        interval: h, time between two knots [s].
        knots: N.
        selection: S, shape (N, b).
        velocity: Gamma^v at the knots 0 to N, shape (N + 1, b) [s].
        position: Gamma^q, shape (N + 1, b) [s^2].
    """

    interval: float
    knots: int
    selection: np.ndarray
    velocity: np.ndarray
    position: np.ndarray

    @classmethod
    def of(cls, blocks: tuple[int, ...], interval: float) -> "Horizon":
        """Return the horizon of blocks.

        Args:
            blocks: Number of knots that share an acceleration, block after block.
            interval: Time between two knots [s].
        """
        knots = sum(blocks)
        selection = np.repeat(np.eye(len(blocks)), blocks, axis=0)
        earlier = np.tril(np.ones((knots + 1, knots)), -1)
        # The state at knot k has felt acceleration j for one interval, and moved on since.
        since = np.arange(knots + 1)[:, None] - np.arange(knots)[None, :] - 0.5
        velocity = interval * earlier @ selection
        position = interval**2 * (earlier * since) @ selection
        return cls(interval, knots, selection, velocity, position)


@dataclass(frozen=True, eq=False)
class JointCost:
    r"""A quadratic cost of one joint's states and accelerations, the same for all.

    .. math:: \tfrac12 \sum_{k=1}^{N} (x_k - r_k)^T Q_k (x_k - r_k) + \tfrac12 \sum_{k=0}^{N-1} (u_k - u^r_k)^2

    Attributes:
        weights: Q at the knots 1 to N, shape (N, 2, 2) [1/s^4, 1/s^3, 1/s^2].
    """

    weights: np.ndarray

    def hessian(self, horizon: Horizon) -> np.ndarray:
        """Return the Hessian in the accelerations of the blocks, shape (b, b)."""
        states = np.stack([horizon.position[1:], horizon.velocity[1:]], axis=1)
        effort = horizon.selection.T @ horizon.selection
        return np.asarray(np.einsum("ksb,kst,ktc->bc", states, self.weights, states) + effort)


def tracking_cost(horizon: Horizon, bandwidth: float) -> JointCost:
    r"""Return the cost whose endless horizon is the linear quadratic regulator of a bandwidth.

    .. math:: Q = \mathrm{diag}(w^4, 2 w^2), \quad Q_N = P

    Args:
        horizon: The horizon.
        bandwidth: w [rad/s].
    """
    weights = np.repeat(np.diag([bandwidth**4, 2.0 * bandwidth**2])[None], horizon.knots, axis=0)
    weights[-1] = terminal_cost(bandwidth, horizon.interval)
    return JointCost(weights)


@cache
def terminal_cost(bandwidth: float, interval: float) -> np.ndarray:
    r"""Return P, the cost of all that comes after the horizon under the regulator, shape (2, 2).

    Solves the discrete algebraic Riccati equation of a double integrator with constant acceleration between knots.

    Args:
        bandwidth: w in Q = diag(w^4, 2 w^2), R = 1 [rad/s].
        interval: Time between two knots [s].
    """
    import control  # takes a second or more, and only a reset needs it

    chain, drive = np.array([[1.0, interval], [0.0, 1.0]]), np.array([[0.5 * interval**2], [interval]])
    cost, _, _ = control.dare(chain, drive, np.diag([bandwidth**4, 2.0 * bandwidth**2]), np.eye(1))
    return np.asarray(cost)
