"""What a load at the flange does to the joints, linear in its inertial parameters."""

import numpy as np
import pinocchio as pin

from ..controllers import RobotModel

MASS_AND_MOMENT, ALL = 4, 10
"""How many of m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz (flange axes, about the flange origin) a regressor may take."""


def pseudo_inertia(parameters: np.ndarray) -> np.ndarray:
    r"""Return the ten inertial parameters as a matrix that a change of frame acts on.

    .. math:: J = \begin{bmatrix} \tfrac12 \mathrm{tr}(I) 1 - I & m c \\ m c^T & m \end{bmatrix}, \quad J' = T J T^T

    Source: Wensing, Kim, Slotine, Linear matrix inequalities for physically consistent inertial parameter
    identification, IEEE RA-L 3 (2018).

    Args:
        parameters: m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the frame's origin, shape (10,).
    """
    mass, x, y, z, xx, xy, yy, xz, yz, zz = parameters
    rotational = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    matrix = np.empty((4, 4))
    matrix[:3, :3] = 0.5 * np.trace(rotational) * np.eye(3) - rotational
    matrix[:3, 3] = matrix[3, :3] = x, y, z
    matrix[3, 3] = mass
    return matrix


def inertial_parameters(matrix: np.ndarray) -> np.ndarray:
    """Return the ten parameters of a pseudo-inertia, shape (10,); the inverse of :func:`pseudo_inertia`."""
    rotational = np.trace(matrix[:3, :3]) * np.eye(3) - matrix[:3, :3]
    return np.array([matrix[3, 3], *matrix[:3, 3], *rotational[np.tril_indices(3)]])


class PayloadRegressor:
    r"""Mixed regressor of a load at the flange.

    .. math:: Y(q, \dot q, \dot q_r, \ddot q_r) \phi = M_\phi \ddot q_r + C_\phi(q, \dot q) \dot q_r + g_\phi

    A joint torque regressor knows one velocity only; as the velocity terms are a quadratic form of it, their
    polarisation yields the mixed term with the matrix C of Christoffel symbols:

    .. math:: Y = Y_1(q, 0, \ddot q_r) + \tfrac14 [Y_1(q, \dot q + \dot q_r, 0) - Y_1(q, \dot q - \dot q_r, 0)]

    Attributes:
        value: Y, shape (n, p) [N m/kg, N m/(kg m), N m/(kg m^2)]; refilled by :meth:`fill`.
    """

    def __init__(self, robot: RobotModel, parameters: int = ALL) -> None:
        """Prepare for one arm; its model is read, never changed.

        Args:
            robot: The arm.
            parameters: p, all ten or the first four: mass and first moment.
        """
        self.model, self.data = robot.model, robot.model.createData()
        flange = self.model.frames[robot.flange_id]
        placement = flange.placement.homogeneous
        units = (pseudo_inertia(row) for row in np.eye(ALL)[:parameters])
        moved = [inertial_parameters(placement @ unit @ placement.T) for unit in units]
        self._transfer = np.array(moved).T.copy()
        first = ALL * (flange.parentJoint - 1)
        self._columns = slice(first, first + ALL)
        n = robot.n
        self._sum, self._difference, self._still = np.zeros(n), np.zeros(n), np.zeros(n)
        self._joint, self.value = np.zeros((n, ALL)), np.zeros((n, parameters))

    def fill(self, q: np.ndarray, dq: np.ndarray, dq_r: np.ndarray, ddq_r: np.ndarray) -> np.ndarray:
        """Fill and return Y.

        Args:
            q: Joint positions, shape (n,) [rad].
            dq: Joint velocities, shape (n,) [rad/s].
            dq_r: Reference velocities, shape (n,) [rad/s].
            ddq_r: Reference accelerations, shape (n,) [rad/s^2].
        """
        np.add(dq, dq_r, out=self._sum)
        np.subtract(dq, dq_r, out=self._difference)
        joint = self._joint
        # Gravity is in all three, so it stays once; Pinocchio answers in one buffer, so each is used up at once.
        np.copyto(joint, self._one(q, self._sum, self._still))
        joint -= self._one(q, self._difference, self._still)
        joint *= 0.25
        joint += self._one(q, self._still, ddq_r)
        return np.dot(joint, self._transfer, out=self.value)

    def _one(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
        """Return the columns of the flange's joint, shape (n, 10)."""
        regressor: np.ndarray = pin.computeJointTorqueRegressor(self.model, self.data, q, dq, ddq)[:, self._columns]
        return regressor
