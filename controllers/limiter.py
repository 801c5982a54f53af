"""The shared torque limiter: effort and torque rate, the same for every controller."""

import numba
import numpy as np

EFFORT, RATE = 0, 1


@numba.njit(cache=True)
def limit_torque(
    command: np.ndarray,
    previous: np.ndarray,
    effort: np.ndarray,
    step: np.ndarray,
    limited: np.ndarray,
    clipped: np.ndarray,
) -> None:
    """Limit one command in place of the drive; counts what was clipped, by cause and joint.

    Args:
        command: What the controller asks for, shape (n,) [N m].
        previous: The last command after the limiter, shape (n,) [N m].
        effort: Torque limits, shape (n,) [N m].
        step: Largest change in one tick, infinite where there is no rate limit, shape (n,) [N m].
        limited: Receives the result, shape (n,) [N m]; may be ``previous`` itself.
        clipped: Tick counters, shape (2, n): row 0 effort, row 1 rate; grows by one where a limit was active.
    """
    for i in range(command.shape[0]):
        torque = command[i]
        if abs(torque) > effort[i]:
            torque = effort[i] if torque > 0.0 else -effort[i]
            clipped[EFFORT, i] += 1
        change = torque - previous[i]
        if abs(change) > step[i]:
            torque = previous[i] + (step[i] if change > 0.0 else -step[i])
            clipped[RATE, i] += 1
        limited[i] = torque
