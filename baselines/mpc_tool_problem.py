"""One plan whose cost is the tool's pose, the joints following their reference weakly."""

import numpy as np

from ..controllers import Preview, RobotModel
from .compiled_function import BufferedFunction
from .mpc_horizon import Horizon, JointCost, terminal_cost
from .mpc_kernels import torque_columns, tracking_gradient
from .mpc_problem import PlanProblem
from .mpc_tool_kernels import add_tool_cost, factorise, tool_slopes, unwhiten, whiten
from .symbolic_dynamics import tool_function

POSE_WEIGHT, TURN_WEIGHT, POSTURE_WEIGHT = 10.0, 0.5, 0.01
"""Of tool position, tool orientation and joint position, times the bandwidth to the fourth [1/m^2, 1, 1]."""


class ToolProblem(PlanProblem):
    r"""Tracks the tool.

    .. math:: J = \tfrac12 \sum_{k=1}^N \left( \|p_k - p^d_k\|^2_{W_p} + \|e_{R,k}\|^2_{W_R} \right)
        + \tfrac12 \sum_{k=1}^N \|x_k - r_k\|^2_Q + \tfrac12 \sum_{k=0}^{N-1} \|u_k - u^r_k\|^2

    The joints' own cost Q is weak in position: it says where the redundant motion goes. Its velocities damp as those of
    :class:`~.mpc_problem.JointProblem` do. The last knot's weights are those of all that comes after it. The Hessian
    changes with the tool's jacobian and is factorised in every call.
    """

    def __init__(self, robot: RobotModel, horizon: Horizon, *, bandwidth: float, limit: np.ndarray) -> None:
        """Allocate.

        Args:
            robot: The arm.
            horizon: Knots and blocks.
            bandwidth: Of the regulator that the cost describes [rad/s].
            limit: Largest torque, shape (n,) [N m].
        """
        super().__init__(robot, horizon, bandwidth=bandwidth, limit=limit)
        n, knots = robot.n, horizon.knots
        self._tool = BufferedFunction(tool_function(robot), points=knots)
        end, position = terminal_cost(bandwidth, horizon.interval), bandwidth**4
        weights = np.repeat(np.diag([POSTURE_WEIGHT * position, 2.0 * bandwidth**2])[None], knots, axis=0)
        weights[-1] = np.diag([POSTURE_WEIGHT * end[0, 0], end[1, 1]])
        self._weights = weights
        self._tool_weights = np.tile(position * np.repeat([POSE_WEIGHT, TURN_WEIGHT], 3), (knots, 1))
        self._tool_weights[-1] *= end[0, 0] / position
        self._joint_hessian = np.kron(JointCost(weights).hessian(horizon), np.eye(n))
        self._hessian = self._joint_hessian.copy()
        self._slopes, self._curvatures = np.zeros((knots, n)), np.zeros((knots, n, n))

    def _condense(self, derivatives: np.ndarray, reference: Preview) -> None:
        basis = (self.horizon.position, self.horizon.velocity, self.horizon.selection)
        errors = (self._q_error, self._dq_error, self._ddq_error)
        tracking_gradient(*errors, self._weights, *basis, self._gradient)
        torque_columns(derivatives, *basis, self._columns)
        self._tool.inputs["q"][:] = self.q[1:]
        tool = self._tool()
        goal = reference.pose[1:]
        pose = (tool["position"], tool["rotation"], tool["jacobian"])
        tool_slopes(*pose, goal, self._tool_weights, self._slopes, self._curvatures)
        np.copyto(self._hessian, self._joint_hessian)
        add_tool_cost(self._slopes, self._curvatures, self.horizon.position, self._gradient, self._hessian)
        factorise(self._hessian)
        whiten(self._hessian, self._columns)
        whiten(self._hessian, self._gradient[:, None])

    def _accelerations(self, change: np.ndarray) -> np.ndarray:
        unwhiten(self._hessian, change)
        return change.reshape(-1, self.robot.n)
