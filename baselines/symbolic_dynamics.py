"""The arm's rigid-body equations as CasADi expressions, written from the Pinocchio model of any arm.

The wheels of Pinocchio carry no CasADi interface, so the recursive Newton-Euler algorithm stands here, in the link
axes of Featherstone, Rigid Body Dynamics Algorithms (2008), section 5.3. Tests hold it against Pinocchio to 1e-10.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import pinocchio as pin

from ..controllers import RobotModel

Expression = Any
"""A symbolic vector or matrix of CasADi."""


def torque_function(robot: RobotModel) -> ca.Function:
    r"""Return torque and its derivatives as a function of a state, an acceleration and what the arm carries.

    .. math:: \tau = M(q) \ddot q + h(q, \dot q), \quad
        [\partial \tau / \partial q, \; \partial \tau / \partial \dot q, \; M]

    Inputs ``q``, ``dq``, ``ddq``, shape (n,); ``payload``, the ten parameters of :attr:`RobotModel.payload`; ``rotor``,
    the apparent rotor inertias, shape (n,). Outputs ``torque``, shape (n,), and ``derivatives``, shape (n, 3 n).

    Args:
        robot: The arm; its payload and its disturbance do not enter.
    """
    q, dq, ddq = (ca.SX.sym(name, robot.n) for name in ("q", "dq", "ddq"))
    payload, rotor = ca.SX.sym("payload", 10), ca.SX.sym("rotor", robot.n)
    torque = torque_expression(robot, q, dq, ddq, payload) + rotor * ddq
    derivatives = ca.jacobian(torque, ca.vertcat(q, dq, ddq))
    outputs = ca.cse([torque, ca.densify(derivatives)])
    names = ["q", "dq", "ddq", "payload", "rotor"], ["torque", "derivatives"]
    return ca.Function("torque", [q, dq, ddq, payload, rotor], outputs, *names)


def tool_function(robot: RobotModel) -> ca.Function:
    """Return the tool's pose and jacobian as a function of the joint positions.

    Input ``q``, shape (n,). Outputs ``position``, shape (3,) [m], ``rotation``, shape (3, 3), and ``jacobian``, shape
    (6, n), base-aligned axes at the tool point, linear before angular.

    Args:
        robot: The arm.
    """
    q = ca.SX.sym("q", robot.n)
    return ca.Function(
        "tool", [q], ca.cse(list(tool_expressions(robot, q))), ["q"], ["position", "rotation", "jacobian"]
    )


def torque_expression(
    robot: RobotModel, q: Expression, dq: Expression, ddq: Expression, payload: Expression
) -> Expression:
    """Return the torque of a motion without rotors, shape (n,).

    Args:
        robot: The arm; its payload and its disturbance do not enter.
        q: Joint positions, shape (n,).
        dq: Joint velocities, shape (n,).
        ddq: Joint accelerations, shape (n,).
        payload: The ten parameters of :attr:`RobotModel.payload`; zeros cost nothing.
    """
    return _newton_euler(_Chain.of(robot), q, dq, ddq, payload)


def tool_expressions(robot: RobotModel, q: Expression) -> tuple[Expression, Expression, Expression]:
    """Return the tool's position, rotation and jacobian at joint positions, see :func:`tool_function`.

    Args:
        robot: The arm.
        q: Joint positions, shape (n,).
    """
    chain = _Chain.of(robot)
    placements: list[tuple[Expression, Expression]] = []
    for joint in chain.joints:
        rotation, position = joint.placed(q)
        if joint.parent >= 0:
            base_rotation, base_position = placements[joint.parent]
            position = base_position + base_rotation @ position
            rotation = base_rotation @ rotation
        placements.append((rotation, position))
    carrier_rotation, carrier_position = placements[chain.tool_joint] if chain.tool_joint >= 0 else (np.eye(3), 0.0)
    position = carrier_position + carrier_rotation @ chain.tool.translation
    columns = [ca.SX.zeros(6)] * robot.n
    for index in chain.tool_path:
        joint, (rotation, origin) = chain.joints[index], placements[index]
        turn = rotation @ joint.axis[3:]
        columns[joint.coordinate] = ca.vertcat(rotation @ joint.axis[:3] + ca.cross(turn, position - origin), turn)
    return position, ca.densify(carrier_rotation @ chain.tool.rotation), ca.densify(ca.horzcat(*columns))


@dataclass(frozen=True)
class _Joint:
    """A joint and the link that it moves.

    Attributes:
        parent: Number of the joint that carries it, -1 for the base.
        coordinate: Its place in q.
        axis: Its motion for a unit velocity, linear before angular, shape (6,); a joint turns about it or slides along.
        rotation: Of its axes at coordinate 0 in the parent's axes, shape (3, 3).
        translation: Of its origin in the parent's axes, shape (3,) [m].
        inertia: Mass, first moments and inertia of the link about the joint's origin, shape (10,).
    """

    parent: int
    coordinate: int
    axis: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    inertia: np.ndarray

    def placed(self, q: Expression) -> tuple[Expression, Expression]:
        """Return rotation and origin in the parent's axes at a position."""
        linear, angular = self.axis[:3], self.axis[3:]
        if not angular.any():
            return ca.SX(self.rotation), self.translation + self.rotation @ (linear * q[self.coordinate])
        angle, skew = q[self.coordinate], pin.skew(angular)
        # Rodrigues' formula for a unit axis.
        turn = np.eye(3) + ca.sin(angle) * skew + (1.0 - ca.cos(angle)) * (skew @ skew)
        return self.rotation @ turn, self.translation


@dataclass(frozen=True)
class _Chain:
    """An arm as numbers.

    Attributes:
        joints: In Pinocchio's order: a joint's parent comes before it.
        flange_joint: Number of the joint whose link carries the payload, -1 for the base.
        flange: Placement of the flange in its axes.
        tool_joint: Number of the joint whose link carries the tool, -1 for the base.
        tool: Placement of the tool in its axes.
        tool_path: Numbers of the joints between base and tool.
        gravity: Acceleration of free fall in base axes, shape (3,) [m/s^2].
    """

    joints: tuple[_Joint, ...]
    flange_joint: int
    flange: pin.SE3
    tool_joint: int
    tool: pin.SE3
    tool_path: tuple[int, ...]
    gravity: np.ndarray

    @classmethod
    def of(cls, robot: RobotModel) -> "_Chain":
        """Read an arm's model, without payload."""
        bare = robot.copy()
        bare.set_payload(np.zeros(10))
        model, data = bare.model, bare.model.createData()
        flange, tool = model.frames[bare.flange_id], model.frames[bare.tool_id]
        path = [joint - 1 for joint in model.supports[tool.parentJoint] if joint > 0]
        return cls(
            joints=tuple(_read_joint(model, data, index) for index in range(1, model.njoints)),
            flange_joint=flange.parentJoint - 1,
            flange=flange.placement.copy(),
            tool_joint=tool.parentJoint - 1,
            tool=pin.SE3(_without_dust(tool.placement.rotation), tool.placement.translation),
            tool_path=tuple(path),
            gravity=np.array(model.gravity.linear),
        )


def _read_joint(model: pin.Model, data: pin.Data, index: int) -> _Joint:
    """Return a joint; its motion is the column of its own jacobian."""
    coordinate = model.joints[index].idx_v
    axis = np.array(pin.computeJointJacobian(model, data, pin.neutral(model), index))[:, coordinate]
    placement = model.jointPlacements[index]
    return _Joint(
        parent=model.parents[index] - 1,
        coordinate=coordinate,
        axis=_without_dust(axis),
        rotation=_without_dust(placement.rotation),
        translation=np.array(placement.translation),
        inertia=np.array(model.inertias[index].toDynamicParameters()),
    )


def _without_dust(array: np.ndarray) -> np.ndarray:
    """Return a copy without what trigonometry left of zeros: each would be multiplied at every tick."""
    return np.where(np.abs(array) < 1e-15, 0.0, array)


def _newton_euler(chain: _Chain, q: Expression, dq: Expression, ddq: Expression, payload: Expression) -> Expression:
    """Return the torque without rotors: velocities and accelerations outwards, forces inwards."""
    placements: list[tuple[Expression, Expression]] = []
    velocities: list[Expression] = []
    accelerations: list[Expression] = []
    forces: list[Expression] = []
    for joint in chain.joints:
        rotation, origin = joint.placed(q)
        velocity, acceleration = ca.SX.zeros(6), ca.vertcat(-chain.gravity, np.zeros(3))
        if joint.parent >= 0:
            velocity, acceleration = velocities[joint.parent], accelerations[joint.parent]
        own = joint.axis * dq[joint.coordinate]
        velocity = _motion_into(rotation, origin, velocity) + own
        acceleration = _motion_into(rotation, origin, acceleration) + joint.axis * ddq[joint.coordinate]
        acceleration += _cross_motion(velocity, own)
        placements.append((rotation, origin))
        velocities.append(velocity)
        accelerations.append(acceleration)
        forces.append(_force(joint.inertia, velocity, acceleration))
    if chain.flange_joint >= 0:
        rotation, origin = chain.flange.rotation, chain.flange.translation
        velocity = _motion_into(rotation, origin, velocities[chain.flange_joint])
        acceleration = _motion_into(rotation, origin, accelerations[chain.flange_joint])
        forces[chain.flange_joint] += _force_out_of(rotation, origin, _force(payload, velocity, acceleration))
    torque = ca.SX.zeros(q.shape[0])
    for index in range(len(chain.joints) - 1, -1, -1):
        joint, (rotation, origin) = chain.joints[index], placements[index]
        torque[joint.coordinate] = ca.dot(joint.axis, forces[index])
        if joint.parent >= 0:
            forces[joint.parent] += _force_out_of(rotation, origin, forces[index])
    return torque


def _motion_into(rotation: Expression, origin: Expression, motion: Expression) -> Expression:
    """Return a motion of the parent's axes in those of a child that lies there."""
    linear, angular = motion[:3], motion[3:]
    return ca.vertcat(rotation.T @ (linear + ca.cross(angular, origin)), rotation.T @ angular)


def _force_out_of(rotation: Expression, origin: Expression, force: Expression) -> Expression:
    """Return a force of a child's axes in those of the parent."""
    linear = rotation @ force[:3]
    return ca.vertcat(linear, rotation @ force[3:] + ca.cross(origin, linear))


def _cross_motion(motion: Expression, other: Expression) -> Expression:
    """Return the rate of a motion that is fixed in moving axes."""
    linear = ca.cross(motion[3:], other[:3]) + ca.cross(motion[:3], other[3:])
    return ca.vertcat(linear, ca.cross(motion[3:], other[3:]))


def _force(parameters: Expression, velocity: Expression, acceleration: Expression) -> Expression:
    """Return what moves a body of ten inertial parameters: the rate of its momentum."""
    mass, moments, inertia = parameters[0], parameters[1:4], _symmetric(parameters[4:10])
    linear, angular = velocity[:3], velocity[3:]
    momentum = mass * linear + ca.cross(angular, moments)
    spin = inertia @ angular + ca.cross(moments, linear)
    force = mass * acceleration[:3] + ca.cross(acceleration[3:], moments) + ca.cross(angular, momentum)
    moment = inertia @ acceleration[3:] + ca.cross(moments, acceleration[:3])
    moment += ca.cross(angular, spin) + ca.cross(linear, momentum)
    return ca.vertcat(force, moment)


def _symmetric(entries: Expression) -> Expression:
    """Return the tensor of xx, xy, yy, xz, yz, zz."""
    xx, xy, yy, xz, yz, zz = (entries[index] for index in range(6))
    rows = (ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))
    return ca.vertcat(*rows)
