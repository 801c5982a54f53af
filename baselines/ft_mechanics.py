"""The mechanics behind :mod:`.ft_filter`, compiled: the flange's motion, a load's regressor, a ball's inertia."""

import numba
import numpy as np

ELEMENTS = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Row and column of each inertia in its tensor, in the order of the ten parameters."""


@numba.njit(cache=True)
def flange_motion(motion, axes, twist):  # type: ignore[no-untyped-def]
    """Fill the flange's rotation and its base-aligned velocity, linear before angular."""
    rotation, linear, angular, placement, position = motion
    local = np.empty(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        local[i] = linear[i] + angular[j] * position[k] - angular[k] * position[j]
    for i in range(3):
        twist[i], twist[3 + i] = 0.0, 0.0
        for j in range(3):
            twist[i] += rotation[i, j] * local[j]
            twist[3 + i] += rotation[i, j] * angular[j]
            axes[i, j] = 0.0
            for k in range(3):
                axes[i, j] += rotation[i, k] * placement[k, j]


@numba.njit(cache=True)
def load_regressor(a, w, alpha, out):  # type: ignore[no-untyped-def]
    """Fill the columns of mass and first moments of the wrench that moves the load, shape (6, 4)."""
    square = w[0] ** 2 + w[1] ** 2 + w[2] ** 2
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i, 0] = a[i]
        out[i, 1 + i] = w[i] * w[i] - square
        out[i, 1 + j] = w[i] * w[j] - alpha[k]
        out[i, 1 + k] = w[i] * w[k] + alpha[j]
        out[3 + i, 1 + j] = a[k]
        out[3 + i, 1 + k] = -a[j]


@numba.njit(cache=True)
def add_tool(wrench, tool, w, acceleration):  # type: ignore[no-untyped-def]
    """Add P a + w x* P w of the known tool: what is left is the load's. The classical acceleration needs no v."""
    momentum = np.zeros(6)
    for i in range(6):
        for j in range(6):
            wrench[i] += tool[i, j] * acceleration[j]
        for j in range(3):
            momentum[i] += tool[i, 3 + j] * w[j]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        wrench[i] += w[j] * momentum[k] - w[k] * momentum[j]
        wrench[3 + i] += w[j] * momentum[3 + k] - w[k] * momentum[3 + j]


@numba.njit(cache=True)
def rotation_columns(w, alpha, out):  # type: ignore[no-untyped-def]
    """Fill the columns of the inertias about the flange: E alpha + w x E w with E the unit of each."""
    momentum = np.empty(3)
    for column in range(6):
        a, b = ELEMENTS[column]
        momentum[:] = 0.0
        momentum[a], momentum[b] = w[b], w[a]
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            out[3 + i, 4 + column] = w[j] * momentum[k] - w[k] * momentum[j]
        out[3 + a, 4 + column] += alpha[b]
        if a != b:
            out[3 + b, 4 + column] += alpha[a]


@numba.njit(cache=True)
def ball_slope(centre, radius, out):  # type: ignore[no-untyped-def]
    """Fill how a ball's inertia about the flange grows with mass and first moments near a centre, shape (6, 4)."""
    square = centre[0] ** 2 + centre[1] ** 2 + centre[2] ** 2
    for k in range(6):
        a, b = ELEMENTS[k]
        same = 1.0 if a == b else 0.0
        out[k, 0] = same * (0.4 * radius * radius - square) + centre[a] * centre[b]
        for i in range(3):
            out[k, 1 + i] = 2.0 * same * centre[i]
        out[k, 1 + a] -= centre[b]
        out[k, 1 + b] -= centre[a]


@numba.njit(cache=True)
def ball(mass, com, radius, out):  # type: ignore[no-untyped-def]
    """Fill the ten parameters of a ball: I = 2/5 m r^2 + m (c.c - c c^T) about the flange origin."""
    x, y, z = com[0], com[1], com[2]
    own = 0.4 * mass * radius * radius
    out[0], out[1], out[2], out[3] = mass, mass * x, mass * y, mass * z
    out[4], out[6], out[9] = own + mass * (y * y + z * z), own + mass * (x * x + z * z), own + mass * (x * x + y * y)
    out[5], out[7], out[8] = -mass * x * y, -mass * x * z, -mass * y * z
