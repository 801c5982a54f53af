"""The filter behind :class:`.ft_estimate.FtEstimate`, compiled: one reading at a time, no allocation in Python.

The state is the load and the sensor's bias. Of the load it holds mass and first moments, or these and the six inertias
about the flange (xx, xy, yy, xz, yz, zz): the width of the regressor says which.
"""

import numba
import numpy as np

from .ft_mechanics import add_tool, ball, ball_slope, flange_motion, load_regressor, rotation_columns

LEAST = 0.05
"""Below this mass the centre is not computed: it would be a quotient of two noises [kg]."""

ARM = 0.2
"""First moments count as the mass that has them at this distance [m]."""

CENTRED, FULL = 4, 10
"""Parameters of a load that are estimated: without its inertia, and with it."""


def memory_dtype(load: int) -> np.dtype:
    """Return the record of the filter for a number of parameters of the load."""
    return np.dtype(
        [
            ("estimate", "f8", load + 6),
            ("covariance", "f8", (load + 6, load + 6)),
            ("centre", "f8", 3),
            ("wrench", "f8", (3, 6)),
            ("regressor", "f8", (3, 6, load)),
            ("twist", "f8", 6),
            ("told", "f8", load),
            ("follows", "f8", (6, 4)),
            ("begun", "i8"),
            ("surprises", "i8"),
            ("open", "i8"),
            ("steps", "i8"),
            ("waited", "i8"),
        ]
    )


_SCALARS = ("gain", "jump", "mass_spread", "moment_spread", "mass_limit", "reach", "radius", "resolution", "period")
CONSTANTS = np.dtype(
    [(name, "f8") for name in (*_SCALARS, "inertia_spread")]
    + [(name, "i8") for name in ("jump_ticks", "reopen", "interval")]
    + [("noise", "f8", 6), ("drift", "f8", 10), ("gravity", "f8", 6), ("tool", "f8", (6, 6))]
)


@numba.njit(cache=True)
def weigh(memory, constants, motion, reading, payload):  # type: ignore[no-untyped-def]
    """Take one reading.

    Args:
        memory: Record of the filter, shape (1,).
        constants: Record of its settings, shape (1,).
        motion: Rotation, linear and angular velocity of the carrying joint, then the flange's rotation and place in it.
        reading: The sensor's wrench, shape (6,) [N, N m].
        payload: Receives the ten parameters to tell.

    Returns:
        Whether the model is to be told.
    """
    m, c = memory[0], constants[0]
    axes, twist = np.empty((3, 3)), np.empty(6)
    flange_motion(motion, axes, twist)
    _balance(m, c, axes, twist, reading)
    _filter(m, c.gain)
    _watch(m, c, _surprise(m, c))
    _correct(m, c, 1 if m.open > 0 else 2)
    return _tell(m, c, payload)


@numba.njit(cache=True)
def _balance(m, c, axes, twist, reading):  # type: ignore[no-untyped-def]
    """Fill stage 0 with the load's regressor and the wrench without the tool's share, in flange axes."""
    angular, acceleration = np.zeros(3), np.zeros(6)
    for j in range(6):
        rate = (twist[j] - m.twist[j]) / c.period if m.begun else 0.0
        m.twist[j] = twist[j]
        block = j - j % 3
        for i in range(3):
            acceleration[block + i] += axes[j - block, i] * (rate - c.gravity[j])
            if block:
                angular[i] += axes[j - block, i] * twist[j]
    for i in range(6):
        m.wrench[0, i] = reading[i]
    load_regressor(acceleration[:3], angular, acceleration[3:], m.regressor[0])
    add_tool(m.wrench[0], c.tool, angular, acceleration)
    if m.regressor.shape[2] == CENTRED:
        _add_rotation(m, c, angular, acceleration[3:])
    else:
        rotation_columns(angular, acceleration[3:], m.regressor[0])


@numba.njit(cache=True)
def _filter(m, gain):  # type: ignore[no-untyped-def]
    """Pass regressor and wrench through two equal stages; the first reading finds them settled."""
    weight = gain if m.begun else 1.0
    for stage in range(2):
        for i in range(6):
            m.wrench[stage + 1, i] += weight * (m.wrench[stage, i] - m.wrench[stage + 1, i])
            for j in range(m.regressor.shape[2]):
                m.regressor[stage + 1, i, j] += weight * (m.regressor[stage, i, j] - m.regressor[stage + 1, i, j])
    m.begun = 1


@numba.njit(cache=True)
def _add_rotation(m, c, w, alpha):  # type: ignore[no-untyped-def]
    """Add I alpha + w x I w of the load as it is thought to be: quadratic in the centre, so taken as known."""
    com, body = np.empty(3), np.empty(10)
    ball(_real(m, c, com), com, c.radius, body)
    inertia, momentum = body[np.array((4, 5, 7, 5, 6, 8, 7, 8, 9))].reshape(3, 3), np.zeros(3)
    for i in range(3):
        for j in range(3):
            m.wrench[0, 3 + i] += inertia[i, j] * alpha[j]
            momentum[i] += inertia[i, j] * w[j]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        m.wrench[0, 3 + i] += w[j] * momentum[k] - w[k] * momentum[j]


@numba.njit(cache=True)
def _columns(m, stage, out):  # type: ignore[no-untyped-def]
    """Fill what a reading says of the load; return the largest of what it says of the inertia.

    The inertia is that of a ball, which follows mass and moments, and a difference: the ball's part goes to their
    columns.
    """
    load, largest = m.regressor.shape[2], 0.0
    for i in range(6):
        for j in range(load):
            out[i, j] = m.regressor[stage, i, j]
        for k in range(CENTRED, load):
            largest = max(largest, abs(m.regressor[stage, i, k]))
            for j in range(CENTRED):
                out[i, j] += m.regressor[stage, i, k] * m.follows[k - CENTRED, j]
    return largest


@numba.njit(cache=True)
def _predict(m, stage, row, columns, column):  # type: ignore[no-untyped-def]
    """Fill the covariance with one reading; return its innovation and the estimate's share of its variance."""
    x, p, regressor = m.estimate, m.covariance, columns[row]
    load = regressor.shape[0]
    innovation = m.wrench[stage, row] - x[load + row]
    for i in range(load + 6):
        column[i] = p[i, load + row]
        for j in range(load):
            column[i] -= p[i, j] * regressor[j]
    variance = column[load + row]
    for j in range(load):
        innovation += regressor[j] * x[j]
        variance -= regressor[j] * column[j]
    return innovation, variance


@numba.njit(cache=True)
def _surprise(m, c):  # type: ignore[no-untyped-def]
    """Return the first stage's squared innovations over their variances, its noise taken as twice the second's."""
    total, column, columns = 0.0, np.empty(m.estimate.shape[0]), np.empty((6, m.regressor.shape[2]))
    _columns(m, 1, columns)
    for row in range(6):
        innovation, variance = _predict(m, 1, row, columns, column)
        total += innovation * innovation / (variance + 4.0 * c.noise[row])
    return total


@numba.njit(cache=True)
def _correct(m, c, stage):  # type: ignore[no-untyped-def]
    """Update estimate and covariance, one component of the wrench after the other.

    An inertia within its spread whose torque drowns in the noise counts as an uncertainty of the reading and is not
    learnt from it (Schmidt's consider filter): the smallest systematic error would pass for an inertia.
    """
    x, p, load = m.estimate, m.covariance, m.regressor.shape[2]
    column, columns = np.empty(load + 6), np.empty((6, load))
    is_faint = _columns(m, stage, columns) * c.inertia_spread < np.sqrt(c.noise[5])
    for i in range(load):
        p[i, i] += c.drift[i]
    for row in range(6):
        innovation, variance = _predict(m, stage, row, columns, column)
        variance += c.noise[row]
        for i in range(load + 6):
            is_considered = is_faint and CENTRED <= i < load
            if not is_considered:
                x[i] += column[i] * innovation / variance
            for j in range(load + 6):
                if not (is_considered and CENTRED <= j < load):
                    p[i, j] -= column[i] * column[j] / variance


@numba.njit(cache=True)
def _watch(m, c, surprise):  # type: ignore[no-untyped-def]
    """Count surprises; after enough of them hold the load's covariance open."""
    m.surprises = m.surprises + 1 if surprise > c.jump else 0
    if m.surprises >= c.jump_ticks and m.open == 0:
        m.open = c.reopen + 1
        m.steps += 1
    if m.open > 0:
        m.open -= 1
        m.surprises = 0
        _real(m, c, m.centre)
        _open(m.covariance, m.centre, c.mass_spread, c.moment_spread)
        _open_inertia(m, c)


@numba.njit(cache=True)
def _open(covariance, centre, mass_spread, moment_spread):  # type: ignore[no-untyped-def]
    """Return the load's covariance to its prior, apart from the bias; moments follow mass through the centre."""
    square = mass_spread * mass_spread
    for i in range(4):
        left = 1.0 if i == 0 else centre[i - 1]
        for j in range(covariance.shape[0]):
            right = 1.0 if j == 0 else centre[j - 1] if j < 4 else 0.0
            covariance[i, j] = square * left * right
            covariance[j, i] = square * left * right
        if i > 0:
            covariance[i, i] += moment_spread * moment_spread


@numba.njit(cache=True)
def _open_inertia(m, c):  # type: ignore[no-untyped-def]
    """Take the ball about the present centre for the inertia again, and return the difference to its prior."""
    ball_slope(m.centre, c.radius, m.follows)
    for k in range(CENTRED, m.regressor.shape[2]):
        m.estimate[k] = 0.0
        m.covariance[k, :] = 0.0
        m.covariance[:, k] = 0.0
        m.covariance[k, k] = c.inertia_spread * c.inertia_spread


@numba.njit(cache=True)
def _real(m, c, com):  # type: ignore[no-untyped-def]
    """Return a mass that a load can have, and fill its centre: near none, where it was or is expected."""
    mass = min(max(m.estimate[0], 0.0), c.mass_limit)
    for i in range(3):
        centre = m.estimate[1 + i] / mass if mass > LEAST else m.centre[i]
        com[i] = min(max(centre, -c.reach), c.reach)
    return mass


@numba.njit(cache=True)
def _tell(m, c, payload):  # type: ignore[no-untyped-def]
    """Fill the parameters of a real body near the estimate; return whether they are news."""
    com = np.empty(3)
    mass = _real(m, c, com)
    change = abs(mass - m.told[0])
    for i in range(3):
        change = max(change, abs(mass * com[i] - m.told[1 + i]) / ARM)
    for i in range(4, m.told.shape[0]):
        change = max(change, abs(m.estimate[i] - m.told[i]) / (ARM * ARM))
    m.waited += 1
    if change <= (0.1 if m.waited >= c.interval else 1.0) * c.resolution:
        return False
    m.waited = 0
    ball(mass, com, c.radius, payload)
    for i in range(4):
        m.told[i] = payload[i]
    for i in range(4, m.told.shape[0]):
        m.told[i] = m.estimate[i]
    return True
