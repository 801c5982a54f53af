"""What the harness does around a controller's call: sensors, target, limiter, drive and log, compiled.

All state of a tick stands in records (NumPy structured scalars), so that a kernel takes a handful of arguments and
the hot loop allocates nothing. A finished tick is one row of the log.
"""

import numba
import numpy as np

from ..controllers.limiter import limit_torque
from .latency import MEASURED, Latency
from .tiers import Tier

# What ended a run; the numbers are the kernel's return values.
RUNNING, NOT_FINITE, POSITION_LIMIT, OVERSPEED, DIVERGED = 0, 1, 2, 3, 4

SPEED_FAILURE = 20.0
"""Any joint speed above this ends a run [rad/s]."""

ERROR_FAILURE = 1.0
"""A joint error norm above this ends a run [rad]."""

SHORT_DELAY, LINE_ROWS = 4, 128
"""Delays from the first on share delay lines of a multiple of the second, in ticks."""


def frame_dtype(n: int) -> np.dtype:
    """Return the record of one tick of an n-joint arm; also a row of the log.

    ``q``, ``dq``, ``wrench`` are true, ``*_measured`` what the sensors gave; ``command`` is what the controller
    returned, ``limited`` what the limiter made of it, ``readback`` what the controller is told of that, ``torque`` what
    was left of it after delay and lag; in the log what acted on the links.
    """
    joints = ("q", "dq", "q_measured", "dq_measured", "command", "limited", "readback", "torque")
    fields: list[tuple[str, str, int]] = [(name, "f8", n) for name in joints]
    fields += [("wrench", "f8", 6), ("wrench_measured", "f8", 6)]
    return np.dtype([("time", "f8"), ("call_time", "i8"), *fields])


def target_dtype(n: int) -> np.dtype:
    """Return the record of the plan at one tick: joints, then the tool pose (row-major), twist, acceleration."""
    joints = [(name, "f8", n) for name in ("q", "dq", "ddq")]
    return np.dtype([*joints, ("pose", "f8", (4, 4)), ("twist", "f8", 6), ("acceleration", "f8", 6)])


def memory_dtype(n: int, *, delay: int) -> np.dtype:
    """Return the record of what sensors and drives remember between ticks."""
    # A kernel is compiled for each length of a line: all long delays share one.
    rows = delay + 1 if delay < SHORT_DELAY else -(-(delay + 1) // LINE_ROWS) * LINE_ROWS
    return np.dtype(
        [
            ("position", "f8", n),
            ("velocity", "f8", n),
            ("wrench", "f8", 6),
            ("previous", "f8", n),
            ("acting", "i8"),
            ("asked", "f8", n),
            ("injection", "f8", n),
            ("disturbed", "f8", n),
            ("delayed", "f8", (rows, n)),
            ("torque", "f8", n),
            ("clipped", "i8", (2, n)),
            ("overspeed", "i8", n),
        ]
    )


def constants_dtype(n: int) -> np.dtype:
    """Return the record of a run's constants."""
    names = (
        "period",
        "quantum",
        "velocity_gain",
        "wrench_gain",
        "torque_gain",
        "latency",
        "call_ticks",
        "gain",
        "readback_gain",
    )
    scalars = [(name, "f8") for name in names]
    joints = [(name, "f8", n) for name in ("effort", "rate_step", "velocity_limit", "lower", "upper")]
    return np.dtype([*scalars, ("delay", "i8"), *joints, ("wrench_bias", "f8", 6)])


def run_constants(
    tier: Tier,
    *,
    effort: np.ndarray,
    velocity: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    bias: np.ndarray,
    latency: Latency = 0,
    gain: float = 1.0,
) -> np.ndarray:
    """Return the filled record of constants, shape (1,).

    Args:
        tier: The tier.
        effort: Torque limits, shape (n,) [N m].
        velocity: Velocity limits, shape (n,) [rad/s].
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].
        bias: The run's force sensor bias, shape (6,) [N, N m].
        latency: Ticks by which every command is late, before the limiter, or ``"measured"``.
        gain: Factor on every command, before the limiter, of which nobody is told.
    """
    constants = np.zeros(1, constants_dtype(effort.shape[0]))
    constants["period"], constants["delay"] = tier.period, tier.delay_ticks
    constants["quantum"] = tier.encoder_quantum
    constants["velocity_gain"] = _filter_gain(tier.velocity_filter_hz, tier.period)
    constants["wrench_gain"] = _filter_gain(tier.wrench_filter_hz, tier.period)
    constants["torque_gain"] = 1.0 - np.exp(-tier.period / tier.torque_lag) if tier.torque_lag > 0.0 else 1.0
    constants["effort"], constants["velocity_limit"] = effort, velocity
    constants["rate_step"] = tier.torque_rate * tier.period
    constants["lower"], constants["upper"], constants["wrench_bias"] = lower, upper, bias
    constants["gain"], constants["readback_gain"] = gain, 1.0 / gain if gain else 0.0
    # One sum for every run: a number of ticks for all calls, and the ticks that a nanosecond of this call counts for.
    measured = latency == MEASURED
    constants["latency"], constants["call_ticks"] = (0, 1e-9 / tier.period) if measured else (latency, 0.0)
    return constants


def _filter_gain(corner_hz: float | None, period: float) -> float:
    """Return the gain of a first-order low-pass, 1 without a filter."""
    return 1.0 if corner_hz is None else 1.0 - float(np.exp(-2.0 * np.pi * corner_hz * period))


@numba.njit(cache=True)
def start_memory(memory, constants, theta, wrench, gravity):  # type: ignore[no-untyped-def]
    """Put sensors and drives at rest: the arm is held by its true gravity torque."""
    m, c = memory[0], constants[0]
    m.acting = -1
    for i in range(theta.shape[0]):
        m.position[i] = _quantised(theta[i], c.quantum)
        m.velocity[i] = 0.0
        m.previous[i] = gravity[i]
        m.torque[i] = gravity[i]
        m.asked[i] = gravity[i]
        for row in range(m.delayed.shape[0]):
            m.delayed[row, i] = gravity[i]
    for i in range(6):
        m.wrench[i] = wrench[i] + c.wrench_bias[i]


@numba.njit(cache=True)
def _quantised(value, quantum):  # type: ignore[no-untyped-def]
    return quantum * np.round(value / quantum) if quantum > 0.0 else value


@numba.njit(cache=True)
def begin_tick(frame, target, table, memory, constants, state, noise, k):  # type: ignore[no-untyped-def]
    """Read the sensors and take the plan of tick k.

    Args:
        frame: Record of the tick, shape (1,).
        target: Record of the plan, shape (1,).
        table: Plan of every tick of the run.
        memory: What sensors remember, shape (1,).
        constants: The run's constants, shape (1,).
        state: True positions, velocities, motor positions, motor velocities and wrench: encoders for the position
            sit at the links, those that velocity comes from at the motors.
        noise: Force sensor noise, shape (ticks, 6) or (1, 6) where there is none.
        k: Number of the tick.
    """
    f, m, c = frame[0], memory[0], constants[0]
    q, dq, theta, dtheta, wrench = state
    target[0] = table[k]
    for i in range(q.shape[0]):
        f.q[i], f.dq[i] = q[i], dq[i]
        if c.quantum > 0.0 or c.velocity_gain < 1.0:
            position = _quantised(theta[i], c.quantum)
            m.velocity[i] += c.velocity_gain * ((position - m.position[i]) / c.period - m.velocity[i])
            m.position[i] = position
            f.q_measured[i], f.dq_measured[i] = _quantised(q[i], c.quantum), m.velocity[i]
        else:
            f.q_measured[i], f.dq_measured[i] = q[i], dtheta[i]
    row = k if noise.shape[0] > 1 else 0
    for i in range(6):
        f.wrench[i] = wrench[i]
        reading = wrench[i] + c.wrench_bias[i] + noise[row, i]
        m.wrench[i] += c.wrench_gain * (reading - m.wrench[i])
        f.wrench_measured[i] = m.wrench[i]


@numba.njit(cache=True)
def end_tick(frame, target, log, memory, constants, k):  # type: ignore[no-untyped-def]
    """Limit the command, pass it through delay and lag, write the log's row, and judge the tick.

    Args:
        frame: Record of the tick with the controller's command, shape (1,).
        target: Record of the plan, shape (1,).
        log: The run's log; row k is written.
        memory: What drives remember, shape (1,).
        constants: The run's constants, shape (1,).
        k: Number of the tick.

    Returns:
        RUNNING, or what ended the run.
    """
    f, m, c = frame[0], memory[0], constants[0]
    n = f.q.shape[0]
    for i in range(n):
        if not np.isfinite(f.command[i]):
            log[k] = frame[0]
            return NOT_FINITE
    _take_newest(f, log, m, c, k)
    for i in range(n):
        m.disturbed[i] = c.gain * m.asked[i] + m.injection[i]
    limit_torque(m.disturbed, m.previous, c.effort, c.rate_step, f.limited, m.clipped)
    rows = m.delayed.shape[0]
    row, due = k % rows, (k + rows - c.delay) % rows
    for i in range(n):
        m.previous[i] = f.limited[i]
        # In the units of the command: a drive with a wrong gain does not know of it.
        f.readback[i] = c.readback_gain * (f.limited[i] - m.injection[i])
        m.delayed[row, i] = f.limited[i]
        m.torque[i] += c.torque_gain * (m.delayed[due, i] - m.torque[i])
        f.torque[i] = m.torque[i]
    log[k] = frame[0]
    return _judge(f, target[0], m, c)


@numba.njit(cache=True)
def _take_newest(f, log, m, c, k):  # type: ignore[no-untyped-def]
    """Let the newest command that has finished at tick k act; it is never replaced by an older one."""
    if int(c.latency + c.call_ticks * f.call_time) == 0:
        m.acting = k
        m.asked[:] = f.command
        return
    for j in range(k - 1, m.acting, -1):
        if j + int(c.latency + c.call_ticks * log[j].call_time) <= k:
            m.acting = j
            m.asked[:] = log[j].command
            return


@numba.njit(cache=True)
def _judge(f, t, m, c):  # type: ignore[no-untyped-def]
    """Return what ends the run at this state; velocity limits are counted, never fatal."""
    squared_error = 0.0
    verdict = RUNNING
    for i in range(f.q.shape[0]):
        squared_error += (t.q[i] - f.q[i]) ** 2
        if f.q[i] < c.lower[i] or f.q[i] > c.upper[i]:
            verdict = POSITION_LIMIT
        if abs(f.dq[i]) > c.velocity_limit[i]:
            m.overspeed[i] += 1
        if not abs(f.dq[i]) <= SPEED_FAILURE:
            verdict = OVERSPEED
    if verdict == RUNNING and not squared_error <= ERROR_FAILURE**2:
        verdict = DIVERGED
    return verdict
