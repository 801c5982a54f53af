"""Whether an arm can do what a motion asks: joint range, speed, torque with a load, distance from singularity."""

from dataclasses import dataclass

import numpy as np

from ...controllers import InvalidInput
from ..loads import Payload
from ..robots import Robot
from .kinematics import Lap

SPACING = 0.01
"""Time between the samples at which torque and singular values are computed [s]."""


@dataclass(frozen=True, kw_only=True)
class Allowance:
    """How much of an arm a motion may use; the default is all of it.

    Attributes:
        room: Least distance of every joint from its position limits [rad].
        share: Largest share of the velocity and of the torque limits.
        singular: Least singular value of the tool jacobian in metres and radians. At 0.01 the tool's worst direction
            asks for 10 rad/s at 0.1 m/s.
    """

    room: float = 0.0
    share: float = 1.0
    singular: float = 0.01


@dataclass(frozen=True, kw_only=True)
class Motion:
    """The joints of one lap on an arm that carries something.

    Attributes:
        name: Name of its trajectory, for messages.
        lap: Positions, velocities and accelerations.
        step: Time between the samples [s].
        robot: The arm.
        load: Everything beyond the flange.
        rotor_inertia: Apparent rotor inertia, shape (n,) [kg m^2].
    """

    name: str
    lap: Lap
    step: float
    robot: Robot
    load: Payload
    rotor_inertia: np.ndarray

    @property
    def rows(self) -> range:
        """Samples at which torque and singular values are computed."""
        return range(0, len(self.lap.q), max(1, round(SPACING / self.step)))

    def room(self) -> np.ndarray:
        """Return the distance from the nearer position limit, negative beyond it, shape (N, n) [rad]."""
        return np.asarray(np.minimum(self.lap.q - self.robot.lower, self.robot.upper - self.lap.q))

    def speed(self) -> np.ndarray:
        """Return the share of the velocity limits, shape (N, n)."""
        return np.asarray(np.abs(self.lap.dq) / self.robot.velocity)

    def torque(self) -> np.ndarray:
        """Return the share of the torque limits at :attr:`rows`, friction left out, shape (M, n)."""
        model = self.robot.model(rotor_inertia=self.rotor_inertia)
        model.set_payload(sum((body.parameters for body in self.load.bodies(self.robot)), np.zeros(10)))
        lap = self.lap
        torques = [model.inverse_dynamics(lap.q[k], lap.dq[k], lap.ddq[k]).copy() for k in self.rows]
        return np.asarray(np.abs(torques) / self.robot.effort)

    def singular_values(self) -> np.ndarray:
        """Return the smallest singular value of the tool jacobian at :attr:`rows`, shape (M,)."""
        model = self.robot.model()
        jacobians = np.array([model.jacobian(self.lap.q[k]) for k in self.rows])
        return np.asarray(np.linalg.svd(jacobians, compute_uv=False)[:, -1])


def check_motion(motion: Motion, allowance: Allowance | None = None) -> None:
    """Refuse a motion that asks for more than is allowed.

    Args:
        motion: The motion.
        allowance: How much of the arm it may use; None for all of it.

    Raises:
        InvalidInput: Says which joint, when in the lap, and by how much.
    """
    allowed = allowance or Allowance()
    _check_room(motion, allowed)
    _check_speed(motion, allowed)
    _check_torque(motion, allowed)
    _check_singular(motion, allowed)


def _check_room(motion: Motion, allowed: Allowance) -> None:
    room, robot = motion.room(), motion.robot
    k, joint = np.unravel_index(room.argmin(), room.shape)
    least, q = room[k, joint], motion.lap.q[k, joint]
    if least < allowed.room:
        limit = robot.upper[joint] if q > (robot.lower[joint] + robot.upper[joint]) / 2.0 else robot.lower[joint]
        side = "beyond" if least < 0.0 else "from"
        where = f"{abs(least):.3g} {_unit(robot, joint)} {side} its limit of {limit:.4g} {_unit(robot, joint)}"
        valid = f"leave {allowed.room:g}" if allowed.room else "move the path or make it smaller"
        raise _refusal(motion, f"joint {joint + 1} is {where} at {_time(motion, k)}", valid)


def _check_speed(motion: Motion, allowed: Allowance) -> None:
    share, robot = motion.speed(), motion.robot
    k, joint = np.unravel_index(share.argmax(), share.shape)
    if share[k, joint] > allowed.share:
        speed = f"{share[k, joint] * robot.velocity[joint]:.3g} {_unit(robot, joint)}/s"
        what = f"joint {joint + 1} moves at {speed} at {_time(motion, k)}, {share[k, joint]:.2f} times its limit"
        raise _refusal(motion, what, _at_most(allowed) or "give it a longer period")


def _check_torque(motion: Motion, allowed: Allowance) -> None:
    share, robot = motion.torque(), motion.robot
    row, joint = np.unravel_index(share.argmax(), share.shape)
    if share[row, joint] > allowed.share:
        unit = "N" if _unit(robot, joint) == "m" else "N m"
        needs = f"needs {share[row, joint] * robot.effort[joint]:.3g} {unit} with {motion.load.mass:g} kg"
        when = f"at {_time(motion, motion.rows[row])}, {share[row, joint]:.2f} times its limit"
        valid = _at_most(allowed) or "bring it nearer, slow it down or lighten the load"
        raise _refusal(motion, f"joint {joint + 1} {needs} {when}", valid)


def _check_singular(motion: Motion, allowed: Allowance) -> None:
    values = motion.singular_values()
    row = int(values.argmin())
    if values[row] < allowed.singular:
        what = f"the arm is nearly singular at {_time(motion, motion.rows[row])}: smallest singular value"
        raise _refusal(motion, f"{what} {values[row]:.3g}", f"at least {allowed.singular:g}; move the path")


def _refusal(motion: Motion, what: str, valid: str) -> InvalidInput:
    return InvalidInput(what, f"trajectory {motion.name!r}", valid)


def _time(motion: Motion, sample: int | np.intp) -> str:
    return f"{sample * motion.step:.3f} s of the lap"


def _at_most(allowed: Allowance) -> str:
    return f"at most {allowed.share:g} of it" if allowed.share < 1.0 else ""


def _unit(robot: Robot, joint: int | np.intp) -> str:
    return "m" if robot.description.moving[joint].kind == "prismatic" else "rad"
