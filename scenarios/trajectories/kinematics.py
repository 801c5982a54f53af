r"""Joint motion of a closed path: the branch closest to a posture, a function of the pose alone and so cyclic.

.. math:: q(t) = \arg\min_q |q - q_r|^2 \quad \text{subject to} \quad FK(q) = X(t)

Solved by Newton steps :math:`\Delta q = J^+ e + (I - J^+ J)(q_r - q)`: one after the other on a coarse grid, then on
all samples of the lap at once, from the coarse solution's trigonometric interpolant. Velocity and acceleration are
spectral derivatives over the lap.
Source: Siciliano et al., Robotics (2009), section 3.5.1, for the step; Trefethen, Spectral Methods in MATLAB,
chapter 3, for the derivatives.
"""

from dataclasses import dataclass

import numpy as np

from ...controllers.errors import InvalidInput
from ...controllers.pose_errors import pose_errors
from ...controllers.robot_model import RobotModel
from .paths import Path, Point

COARSE_SPACING = 0.016
"""Largest spacing of the coarse grid [s]; a period that no such spacing divides gets a finer one."""
STEP_LIMIT = 0.3
"""Largest norm of one Newton step on the coarse grid [rad]."""
TASK_TOLERANCE = 1e-12
"""Pose error at which a sample counts as reached [m, rad]."""
NULL_TOLERANCE = 1e-9
"""Step within the redundancy at which a coarse sample counts as closest [rad]; the whole lap goes to 1e-12."""


@dataclass(frozen=True, kw_only=True)
class Lap:
    """One lap of the joints, sample k at time k * step.

    Attributes:
        q: Positions, shape (N, n) [rad].
        dq: Velocities, shape (N, n) [rad/s].
        ddq: Accelerations, shape (N, n) [rad/s^2].
    """

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray


def lap_samples(path: Path, step: float) -> int:
    """Return the number of samples of a lap.

    Raises:
        InvalidInput: If the period is no whole number of samples, or fewer than eight.
    """
    count = round(path.period / step)
    if count < 8 or abs(count * step - path.period) > 1e-9 * path.period:
        raise InvalidInput(
            f"period {path.period:g} s is no whole number of {step * 1e3:g} ms samples",
            f"trajectory {path.name!r}",
            "at least eight are needed",
        )
    return count


def solve_lap(model: RobotModel, path: Path, *, home: np.ndarray, step: float = 0.001) -> Lap:
    """Return the joint motion that follows a path and stays closest to the posture that faces it.

    Args:
        model: The arm; the pose is that of its tool frame.
        path: The closed path.
        home: The arm's home position, shape (n,) [rad].
        step: Time between samples [s].

    Raises:
        InvalidInput: If a pose cannot be reached, the joints do not return to where they started, or the period is
            no whole number of samples.
    """
    count = lap_samples(path, step)
    posture = facing_posture(model, home, path.centre)
    stride = _coarse_stride(count, step)
    coarse = _walk(model, path, posture, np.arange(0, count + 1, stride) * step)
    q = _polish(model, path, posture, _refine(coarse, count), np.arange(count) * step)
    return Lap(q=q, dq=spectral_derivative(q, path.period, order=1), ddq=spectral_derivative(q, path.period, order=2))


def facing_posture(model: RobotModel, home: np.ndarray, centre: Point) -> np.ndarray:
    """Return home with the first joint turned towards a point, shape (n,) [rad].

    Only a first joint with a vertical axis is turned. An arm faces the quarter turn nearest to its tool's azimuth at
    home: the tool of many arms is offset to the side, and that offset does not count.

    Args:
        model: The arm.
        home: Its home position, shape (n,) [rad].
        centre: The point, base frame [m].
    """
    posture = np.array(home, dtype=float)
    pose = model.forward_kinematics(posture)
    # The angular part of a joint's own column is its axis, zero for a sliding joint.
    axis = model.jacobian(posture)[3:, 0]
    if abs(axis[2]) < 1.0 - 1e-9 or np.hypot(centre[0], centre[1]) < 1e-9:
        return posture
    quarter = np.pi / 2.0
    faces = quarter * round(np.arctan2(pose[1, 3], pose[0, 3]) / quarter)
    turn = np.remainder(np.arctan2(centre[1], centre[0]) - faces + np.pi, 2.0 * np.pi) - np.pi
    posture[0] = np.clip(home[0] + np.sign(axis[2]) * turn, model.lower[0], model.upper[0])
    return posture


def spectral_derivative(samples: np.ndarray, period: float, *, order: int) -> np.ndarray:
    """Return the derivative of a periodic, evenly sampled function; exact for what the samples resolve.

    Args:
        samples: One period, shape (N, n).
        period: Its duration [s].
        order: 1 or 2.

    Returns:
        The derivative at the samples, shape (N, n).
    """
    count = len(samples)
    factor = (2j * np.pi / period * np.arange(count // 2 + 1)) ** order
    if order == 1 and count % 2 == 0:
        # The highest harmonic of an even number of samples is a cosine whose derivative vanishes at all of them.
        factor[-1] = 0.0
    return np.asarray(np.fft.irfft(factor[:, None] * np.fft.rfft(samples, axis=0), n=count, axis=0))


def _coarse_stride(count: int, step: float) -> int:
    """Return the largest divisor of the number of samples within the coarse spacing that leaves 16 samples."""
    largest = max(1, min(int(COARSE_SPACING / step + 1e-9), count // 16))
    return next(stride for stride in range(largest, 0, -1) if count % stride == 0)


def _refine(coarse: np.ndarray, count: int) -> np.ndarray:
    """Return the trigonometric interpolant of one period at more samples, shape (count, n)."""
    if len(coarse) == count:
        return coarse
    spectrum = np.fft.rfft(coarse, axis=0)
    if len(coarse) % 2 == 0:
        spectrum[-1] *= 0.5
    return np.asarray(np.fft.irfft(spectrum, n=count, axis=0) * (count / len(coarse)))


def _walk(model: RobotModel, path: Path, posture: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Solve sample after sample from the posture, and check that the last returns to the first.

    Returns:
        Joint positions without the repeated last sample, shape (M, n) [rad].
    """
    poses = path.pose(times)
    q = np.empty((len(times), model.n))
    guess, previous = posture.copy(), posture
    for k, pose in enumerate(poses):
        q[k] = _settle(model, path, posture, guess, pose, float(times[k]))
        guess, previous = (2.0 * q[k] - previous if k else q[k].copy()), q[k]
    gap = np.abs(q[-1] - q[0])
    if gap.max() > 1e-6:
        joint = int(gap.argmax())
        raise InvalidInput(
            f"joint {joint + 1} is {gap[joint]:.3g} rad from its start after one lap",
            f"trajectory {path.name!r}",
            "choose a path or a home position away from a change of branch",
        )
    return q[:-1]


def _settle(
    model: RobotModel, path: Path, posture: np.ndarray, guess: np.ndarray, pose: np.ndarray, time: float
) -> np.ndarray:
    """Return the joint positions of one pose that are closest to the posture, from a guess, shape (n,) [rad]."""
    q, nearest = guess, np.full(6, np.inf)
    for _ in range(200):
        error, jacobian = pose_errors(model, q[None], pose[None], model.tool_id)
        # Directions that the arm can hardly move in are left out here, so that a singular home can be left.
        inverse = np.linalg.pinv(jacobian[0], rcond=1e-3)
        wish = posture - q
        null = wish - inverse @ (jacobian[0] @ wish)
        if np.abs(error).max() < TASK_TOLERANCE and np.abs(null).max() < NULL_TOLERANCE:
            return q
        nearest = min(nearest, error[0], key=np.linalg.norm)
        move = inverse @ error[0] + null
        length = float(np.linalg.norm(move))
        q = q + move * (STEP_LIMIT / length if length > STEP_LIMIT else 1.0)
    raise _unsettled(path, pose, nearest, time)


def _unsettled(path: Path, pose: np.ndarray, nearest: np.ndarray, time: float) -> InvalidInput:
    """Say whether a pose is out of reach, or reached without a posture that is closest to home."""
    x, y, z = pose[:3, 3]
    where = f"({x:.3f}, {y:.3f}, {z:.3f}) m at {time:.3f} s of the lap"
    if np.linalg.norm(nearest) < 1e-6:
        what, valid = f"no posture closest to home settles at {where}", "choose another home position of the robot"
    else:
        away = f"{np.linalg.norm(nearest[:3]) * 1e3:.3g} mm and {np.linalg.norm(nearest[3:]):.3g} rad away"
        what, valid = f"the tool cannot reach {where}: it stays {away}", "move the path into the arm's reach"
    return InvalidInput(what, f"trajectory {path.name!r}", valid)


def _polish(model: RobotModel, path: Path, posture: np.ndarray, q: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return all samples of a lap with Newton run to rounding, shape (N, n) [rad]."""
    poses = path.pose(times)
    active = np.arange(len(q))
    for _ in range(50):
        error, jacobian = pose_errors(model, q[active], poses[active], model.tool_id)
        wish = posture - q[active]
        null = wish - _least_norm(jacobian, np.einsum("kij,kj->ki", jacobian, wish))
        q[active] += _least_norm(jacobian, error) + null
        active = active[(np.abs(error).max(axis=1) > TASK_TOLERANCE) | (np.abs(null).max(axis=1) > 1e-12)]
        if not len(active):
            return q
    time = float(times[active[0]])
    raise InvalidInput(
        f"inverse kinematics does not settle at {time:.3f} s of the lap",
        f"trajectory {path.name!r}",
        "the path passes a singular position of the arm",
    )


def _least_norm(jacobian: np.ndarray, task: np.ndarray) -> np.ndarray:
    """Return the shortest joint steps of least task error, for task steps of shape (k, 6), shape (k, n)."""
    transpose = jacobian.transpose(0, 2, 1)
    if jacobian.shape[2] >= 6:
        try:
            return np.asarray((transpose @ np.linalg.solve(jacobian @ transpose, task[..., None]))[..., 0])
        except np.linalg.LinAlgError:
            pass
    return np.asarray((np.linalg.pinv(jacobian, rcond=1e-6) @ task[..., None])[..., 0])
