"""Rigid-body model of a fixed-base arm with any number of joints, on Pinocchio.

Pinocchio's results live in its ``Data``; the arrays kept here are views of it, taken once, so that a tick costs the
dynamics and no wrapping.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .errors import InvalidInput, UnknownName

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass(slots=True)
class RigidBodyState:
    """Everything a law needs at one state; one preallocated record, refilled in place by :meth:`RobotModel.at`.

    Attributes:
        mass_matrix: Inertia with rotor inertia and payload, shape (n, n) [kg m^2].
        bias: Coriolis, centrifugal and gravity torque less the disturbance, shape (n,) [N m].
        gravity: Gravity torque less the disturbance, shape (n,) [N m].
        pose: Tool pose in the base frame, shape (4, 4) [m].
        position: Its translation, a view, shape (3,) [m].
        rotation: Its rotation, a view, shape (3, 3).
        jacobian: Base-aligned axes at the tool point, linear before angular, shape (6, n).
        jacobian_bias: Time derivative of the jacobian times dq, same axes, shape (6,) [m/s^2, rad/s^2].
    """

    mass_matrix: np.ndarray
    bias: np.ndarray
    gravity: np.ndarray
    pose: np.ndarray
    position: np.ndarray
    rotation: np.ndarray
    jacobian: np.ndarray
    jacobian_bias: np.ndarray


class RobotModel:
    r"""The arm as a controller knows it: :math:`M(q) \ddot q + h(q, \dot q) = \tau`.

    Payload and disturbance are set by knowledge providers and are read-only to controllers. The payload enters mass
    matrix, bias, gravity and inverse dynamics; the disturbance is subtracted in bias, gravity and inverse dynamics
    already, so that M a + bias = tau holds with nothing to add. A law uses bias or gravity, never both.

    Attributes:
        n: Number of joints.
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].
        velocity: Velocity limits, shape (n,) [rad/s].
        effort: Torque limits, shape (n,) [N m].
        rotor_inertia: Apparent rotor inertia at the joints, shape (n,) [kg m^2].
        payload: Load beyond the gripper: m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the flange origin in flange
            axes, shape (10,), read-only [kg, kg m, kg m^2].
        disturbance: Joint torque of unknown origin that acts on the arm, shape (n,), read-only [N m].
        revision: Grows whenever payload or disturbance is set.
    """

    def __init__(self, urdf: str, *, tool_frame: str, flange_frame: str, rotor_inertia: np.ndarray) -> None:
        """Build the model from the text of a URDF.

        Args:
            urdf: The URDF as text.
            tool_frame: Name of the frame whose pose is controlled.
            flange_frame: Name of the frame that carries the payload.
            rotor_inertia: Apparent rotor inertia, shape (n,) [kg m^2].

        Raises:
            InvalidInput: If the URDF cannot be read or a joint has no single coordinate.
            UnknownName: If a frame does not exist.
        """
        self._source = (urdf, tool_frame, flange_frame)
        self.model = _read_model(urdf)
        self.data = self.model.createData()
        self.n = int(self.model.nv)
        self.tool_id = _frame(self.model, tool_frame)
        self.flange_id = _frame(self.model, flange_frame)
        self.lower = self.model.lowerPositionLimit.copy()
        self.upper = self.model.upperPositionLimit.copy()
        self.velocity = self.model.velocityLimit.copy()
        self.effort = self.model.effortLimit.copy()
        self.rotor_inertia = np.array(rotor_inertia, dtype=float)
        self.model.armature = self.rotor_inertia
        flange = self.model.frames[self.flange_id]
        self._flange_joint, self._flange_placement = flange.parentJoint, flange.placement.copy()
        self._bare_inertia = self.model.inertias[self._flange_joint].copy()
        self._payload, self._disturbance = np.zeros(10), np.zeros(self.n)
        self.payload, self.disturbance = _read_only(self._payload), _read_only(self._disturbance)
        self.revision = 0
        self._no_acceleration = np.zeros(self.n)
        self._take_views()

    def _take_views(self) -> None:
        """Take the views of Pinocchio's data and allocate the record, once."""
        self._mass, self._nle, self._gravity = self.data.M, self.data.nle, self.data.g
        self._tau = self.data.tau
        placement = self.data.oMf[self.tool_id]
        self._position, self._rotation = placement.translation, placement.rotation
        self._torque = np.zeros(self.n)
        pose = np.eye(4)
        self._state = RigidBodyState(
            mass_matrix=np.zeros((self.n, self.n)),
            bias=np.zeros(self.n),
            gravity=np.zeros(self.n),
            pose=pose,
            position=pose[:3, 3],
            rotation=pose[:3, :3],
            jacobian=np.zeros((6, self.n), order="F"),
            jacobian_bias=np.zeros(6),
        )

    @property
    def tool_mass(self) -> float:
        """Known mass fixed to the flange: gripper and the like, without payload [kg]."""
        return float(self.tool_parameters[0])

    @property
    def tool_parameters(self) -> np.ndarray:
        """What is known to be fixed to the flange, without payload, as :attr:`payload`, shape (10,)."""
        frames = self.model.frames
        flange, tool = frames[self.flange_id], pin.Inertia.Zero()
        for frame in frames:
            ancestor = frame
            while ancestor.parentFrame and ancestor.name != flange.name:
                ancestor = frames[ancestor.parentFrame]
            if ancestor.name == flange.name:
                tool += flange.placement.actInv(frame.placement).act(frame.inertia)
        return np.array(tool.toDynamicParameters())

    def at(self, q: np.ndarray, dq: np.ndarray) -> RigidBodyState:
        """Fill and return the record of this model at one state.

        Args:
            q: Joint positions, shape (n,) [rad].
            dq: Joint velocities, shape (n,) [rad/s].

        Returns:
            The model's one record, valid until the next call.
        """
        model, data, state = self.model, self.data, self._state
        # With zero joint acceleration the frame's classical acceleration is the jacobian's time derivative times dq.
        pin.forwardKinematics(model, data, q, dq, self._no_acceleration)
        pin.updateFramePlacement(model, data, self.tool_id)
        acceleration = pin.getFrameClassicalAcceleration(model, data, self.tool_id, _WORLD_ALIGNED)
        np.copyto(state.jacobian_bias, acceleration.vector)
        pin.computeJointJacobians(model, data)
        # Of a single joint Pinocchio returns a vector.
        jacobian = pin.getFrameJacobian(model, data, self.tool_id, _WORLD_ALIGNED)
        np.copyto(state.jacobian, jacobian.reshape(6, self.n))
        np.copyto(state.position, self._position)
        np.copyto(state.rotation, self._rotation)
        pin.nonLinearEffects(model, data, q, dq)
        np.subtract(self._nle, self._disturbance, out=state.bias)
        pin.computeGeneralizedGravity(model, data, q)
        np.subtract(self._gravity, self._disturbance, out=state.gravity)
        pin.crba(model, data, q)
        np.copyto(state.mass_matrix, self._mass)
        return state

    def inverse_dynamics(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
        """Return the torque of a motion, less the disturbance.

        Args:
            q: Joint positions, shape (n,) [rad].
            dq: Joint velocities, shape (n,) [rad/s].
            ddq: Joint accelerations, shape (n,) [rad/s^2].

        Returns:
            Torque, shape (n,) [N m]; the model's own buffer, valid until the next call.
        """
        pin.rnea(self.model, self.data, q, dq, ddq)
        np.subtract(self._tau, self._disturbance, out=self._torque)
        return self._torque

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Return the gravity torque less the disturbance, shape (n,) [N m]; a new array."""
        pin.computeGeneralizedGravity(self.model, self.data, q)
        return np.array(self._gravity - self._disturbance)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Return the mass matrix with rotor inertia and payload, shape (n, n) [kg m^2]; a new array."""
        return np.array(pin.crba(self.model, self.data, q))

    def forward_kinematics(self, q: np.ndarray) -> np.ndarray:
        """Return the tool pose in the base frame, shape (4, 4) [m]; a new array."""
        return self._frame_pose(q, self.tool_id)

    def flange_pose(self, q: np.ndarray) -> np.ndarray:
        """Return the flange pose in the base frame, shape (4, 4) [m]; a new array."""
        return self._frame_pose(q, self.flange_id)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the tool jacobian, base-aligned, linear before angular, shape (6, n); a new array."""
        jacobian = pin.computeFrameJacobian(self.model, self.data, q, self.tool_id, _WORLD_ALIGNED)
        return np.array(jacobian).reshape(6, self.n)

    def tool_path(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the tool poses along a joint path.

        Args:
            q: Joint positions, shape (N, n) [rad].

        Returns:
            Positions in the base frame, shape (N, 3) [m], and rotations, shape (N, 3, 3).
        """
        positions, rotations, _ = self.tool_motion(q, np.zeros_like(q))
        return positions, rotations

    def tool_motion(self, q: np.ndarray, dq: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the tool poses and twists along a joint path.

        Args:
            q: Joint positions, shape (N, n) [rad].
            dq: Joint velocities, shape (N, n) [rad/s].

        Returns:
            Positions in the base frame, shape (N, 3) [m], rotations, shape (N, 3, 3), and twists in base-aligned axes
            at the tool point, linear before angular, shape (N, 6) [m/s, rad/s].
        """
        positions, rotations, twists = np.empty((len(q), 3)), np.empty((len(q), 3, 3)), np.empty((len(q), 6))
        model, data, forward = self.model, self.data, pin.forwardKinematics
        tool = model.frames[self.tool_id]
        carrier, motion = data.oMi[tool.parentJoint], data.v[tool.parentJoint]
        position, rotation = carrier.translation, carrier.rotation
        for k, (row, rate) in enumerate(zip(np.ascontiguousarray(q), np.ascontiguousarray(dq), strict=True)):
            forward(model, data, row, rate)
            positions[k], rotations[k], twists[k] = position, rotation, motion.vector
        # The tool is fixed to its joint: its placement there is applied to all rows at once.
        arm, angular = tool.placement.translation, twists[:, 3:]
        turned = rotations @ np.stack([twists[:, :3] + np.cross(angular, arm), angular], axis=2)
        twists = np.concatenate([turned[..., 0], turned[..., 1]], axis=1)
        return positions + rotations @ arm, rotations @ tool.placement.rotation, twists

    def set_payload(self, parameters: np.ndarray) -> None:
        """Set the load beyond the gripper; for knowledge providers.

        Args:
            parameters: As :attr:`payload`, shape (10,).
        """
        np.copyto(self._payload, parameters)
        # A massless body has no centre of mass: dividing the first moment by it would give NaN.
        empty = not self._payload[0]
        inertia = pin.Inertia.Zero() if empty else pin.Inertia.FromDynamicParameters(self._payload)
        self.model.inertias[self._flange_joint] = self._bare_inertia + self._flange_placement.act(inertia)
        self._disturbance[:] = 0.0
        self.revision += 1

    def set_disturbance(self, torque: np.ndarray) -> None:
        """Set the joint torque of unknown origin and clear the payload; for knowledge providers.

        Args:
            torque: What acts on the arm besides the command, shape (n,) [N m].
        """
        if self._payload.any():
            self.set_payload(np.zeros(10))
        np.copyto(self._disturbance, torque)
        self.revision += 1

    def copy(self) -> "RobotModel":
        """Return an independent model with the same payload and disturbance."""
        urdf, tool, flange = self._source
        other = RobotModel(urdf, tool_frame=tool, flange_frame=flange, rotor_inertia=self.rotor_inertia)
        other.set_payload(self._payload)
        np.copyto(other._disturbance, self._disturbance)
        return other

    def _frame_pose(self, q: np.ndarray, frame: int) -> np.ndarray:
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateFramePlacement(self.model, self.data, frame)
        return np.array(self.data.oMf[frame].homogeneous)


def _read_model(urdf: str) -> pin.Model:
    """Read a URDF text; every joint must have one coordinate and one velocity."""
    try:
        model = pin.buildModelFromXML(urdf)
    except Exception as cause:
        raise InvalidInput(f"is not a readable URDF ({cause})", "URDF") from cause
    for joint in range(1, model.njoints):
        if model.nqs[joint] != 1 or model.nvs[joint] != 1:
            raise InvalidInput(
                f"joint {model.names[joint]!r} has {model.nqs[joint]} coordinates",
                "URDF",
                "use revolute joints with wide limits in place of continuous ones, and a fixed base",
            )
    return model


def _frame(model: pin.Model, name: str) -> int:
    if not model.existFrame(name):
        raise UnknownName("frame", name, tuple(frame.name for frame in model.frames))
    return int(model.getFrameId(name))


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
