"""Gains by rule: one bandwidth places all closed-loop poles of an integrator chain."""

from functools import cache

import numpy as np

from ..controllers import Reference, RobotModel


@cache
def double_integrator_gains(bandwidth: float, period: float) -> tuple[float, float]:
    r"""Return the discrete LQR gains of :math:`\ddot e = -u`.

    .. math:: x_{k+1} = \begin{bmatrix} 1 & h \\ 0 & 1 \end{bmatrix} x_k + \begin{bmatrix} h^2 \\ h \end{bmatrix} u_k,
        \quad Q = \mathrm{diag}(w^4, 2 w^2), \quad R = 1

    As h goes to 0 the double pole is at -w: k_p = w^2 and k_d = 2 w, critical damping.
    Source: Anderson, Moore, Optimal Control: Linear Quadratic Methods (1990).

    Args:
        bandwidth: Place w of the closed-loop poles [rad/s].
        period: Control period h [s].

    Returns:
        k_p [1/s^2] and k_d [1/s].
    """
    h, w = period, bandwidth
    stiffness, damping = _lqr([[1.0, h], [0.0, 1.0]], [[h * h], [h]], [w**4, 2.0 * w**2])
    return stiffness, damping


@cache
def triple_integrator_gains(bandwidth: float, period: float) -> tuple[float, float, float]:
    r"""Return the discrete LQR gains of the double integrator with the integral of the error as a third state.

    .. math:: x = (\textstyle\int e, e, \dot e), \quad Q = \mathrm{diag}(w^6, 3 w^4, 3 w^2), \quad R = 1

    As h goes to 0 the triple pole is at -w: k_i = w^3, k_p = 3 w^2, k_d = 3 w. The stiffness is three times that of
    :func:`double_integrator_gains` at the same bandwidth.

    Args:
        bandwidth: Place w of the closed-loop poles [rad/s].
        period: Control period h [s].

    Returns:
        k_i [1/s^3], k_p [1/s^2] and k_d [1/s].
    """
    h, w = period, bandwidth
    chain = [[1.0, h, 0.0], [0.0, 1.0, h], [0.0, 0.0, 1.0]]
    integral, stiffness, damping = _lqr(chain, [[0.0], [h * h], [h]], [w**6, 3.0 * w**4, 3.0 * w**2])
    return integral, stiffness, damping


def smallest_effective_inertia(robot: RobotModel, reference: Reference) -> np.ndarray:
    r"""Return the inertia that each joint shows when all others are free, at its smallest along the plan.

    .. math:: I_j = \min_t \frac{1}{(M(q_d(t))^{-1})_{jj}}

    Diagonal gains scaled with it cannot overdrive a coupled joint; the diagonal of M can be a hundred times too large.

    Args:
        robot: The model with rotor inertia, and payload if it is known.
        reference: The plan, of which one lap is read.

    Returns:
        Effective inertia, shape (n,) [kg m^2].
    """
    mobility = np.linalg.inv(np.stack([robot.mass_matrix(q) for q in reference.q]))
    return np.asarray(1.0 / mobility.diagonal(axis1=1, axis2=2).max(axis=0))


def _lqr(chain: list[list[float]], drive: list[list[float]], weights: list[float]) -> list[float]:
    """Return the gains of one input of weight 1."""
    import control  # takes a second or more, and only a reset needs it

    gains, _, _ = control.dlqr(np.array(chain), np.array(drive), np.diag(weights), np.eye(1))
    return [float(gain) for gain in np.ravel(gains)]
