"""An integral that knows when to stop."""

import numba
import numpy as np

AT_LIMIT = 1.0 - 1e-9
"""Share of a limit from which a command counts as limited: the limiter's own rounding stays below it."""


@numba.njit(cache=True)
def integrate_unless_limited(
    integral: np.ndarray,
    error: np.ndarray,
    period: float,
    clamp: float,
    command: np.ndarray,
    previous: np.ndarray,
    effort: np.ndarray,
    step: np.ndarray,
) -> None:
    r"""Advance the integral of every joint whose last command was not limited.

    .. math:: z \leftarrow \mathrm{clip}(z + h e, -z_{max}, z_{max})

    Saturation is read from the applied commands alone, so that a delay between law and limiter changes nothing.
    Source: Astrom, Hagglund, Advanced PID Control (2006), chapter 3 (conditional integration).

    Args:
        integral: z, changed in place, shape (n,) [rad s].
        error: e, shape (n,) [rad].
        period: h [s].
        clamp: Largest magnitude of z [rad s].
        command: The last command after the limiter, shape (n,) [N m].
        previous: The one before; receives ``command``, shape (n,) [N m].
        effort: Torque limits, shape (n,) [N m].
        step: Largest change of a command in one tick, infinite without a rate limit, shape (n,) [N m].
    """
    for i in range(integral.shape[0]):
        at_effort = abs(command[i]) >= AT_LIMIT * effort[i]
        at_rate = abs(command[i] - previous[i]) >= AT_LIMIT * step[i]
        previous[i] = command[i]
        if not (at_effort or at_rate):
            integral[i] = min(max(integral[i] + period * error[i], -clamp), clamp)
