"""One plan as a quadratic program: the dynamics linearised about the plan before, the states condensed away."""

from abc import ABC, abstractmethod

import numpy as np
from scipy.linalg import solve_triangular

from ..controllers import Preview, RobotModel
from .compiled_function import BufferedFunction
from .mpc_horizon import Horizon, JointCost, tracking_cost
from .mpc_kernels import reference_accelerations, roll_out, torque_columns, torque_room, tracking_gradient
from .quadratic_program import ProjectionProgram
from .symbolic_dynamics import torque_function

TOLERANCE, OUTER, INNER = 1e-5, 20, 40
"""Largest residual of a solution [N m], and caps of the solver's outer and inner iterations."""


class PlanProblem(ABC):
    r"""Accelerations that track a reference over a horizon, with the joint torque at every knot within its limits.

    .. math::
        \min_v \; & J(q_1, \dots, q_N, \dot q_1, \dots, \dot q_N, u_0, \dots, u_{N-1}) \\
        \text{s.t.} \; & q_{k+1} = q_k + h \dot q_k + \tfrac12 h^2 u_k, \quad \dot q_{k+1} = \dot q_k + h u_k,
            \quad u_k = S_k v \\
        & |M(q_k) u_k + h(q_k, \dot q_k) - d| \le \tau_{max}, \quad k = 0, \dots, N - 1

    With the joint accelerations as input the dynamics are exactly linear and all that is nonlinear is the torque (and
    the tool's pose, if the cost has it). One call is one Gauss-Newton step from the plan before, which is a real-time
    iteration: over successive calls the plan converges while the arm moves. The unknowns are the changes of v in
    coordinates in which the cost's Hessian is the identity.
    Source: Diehl, Bock, Schloeder, A real-time iteration scheme for nonlinear optimization in optimal feedback control,
    SIAM J. Control Optim. 43 (2005).

    Attributes:
        horizon: Knots and blocks.
        q: Positions of the last roll-out at the knots 0 to N, shape (N + 1, n) [rad].
        dq: Its velocities, shape (N + 1, n) [rad/s].
        ddq: Its accelerations, shape (N, n) [rad/s^2].
        is_compiled: Whether the model's equations run as machine code.
        program: The solver, with its counters.
    """

    def __init__(self, robot: RobotModel, horizon: Horizon, *, bandwidth: float, limit: np.ndarray) -> None:
        """Compile, or take from the cache, and allocate.

        Args:
            robot: The arm.
            horizon: Knots and blocks.
            bandwidth: Of the regulator that the cost describes [rad/s].
            limit: Largest torque, shape (n,) [N m].
        """
        n, knots, blocks = robot.n, horizon.knots, horizon.selection.shape[1]
        self.robot, self.horizon, self.bandwidth = robot, horizon, float(bandwidth)
        self.limit = np.array(limit, dtype=float)
        self.torque = BufferedFunction(torque_function(robot), points=knots, shared=("payload", "rotor"))
        self.is_compiled = self.torque.is_compiled
        self.torque.inputs["rotor"][:] = robot.rotor_inertia
        self.q, self.dq, self.ddq = np.zeros((knots + 1, n)), np.zeros((knots + 1, n)), np.zeros((knots, n))
        self._q_error, self._dq_error = np.zeros((knots + 1, n)), np.zeros((knots + 1, n))
        self._ddq_reference, self._ddq_error = np.zeros((knots, n)), np.zeros((knots, n))
        self._gradient, self._columns = np.zeros(blocks * n), np.zeros((blocks * n, knots * n))
        self._least, self._most = np.zeros(knots * n), np.zeros(knots * n)
        self.restart()

    def restart(self) -> None:
        """Forget the last solution and the counters."""
        variables, rows = self._columns.shape
        self.program = ProjectionProgram(variables, rows, tolerance=TOLERANCE, outer=OUTER, inner=INNER)

    def solve(
        self, start: np.ndarray, accelerations: np.ndarray, reference: Preview, disturbance: np.ndarray
    ) -> np.ndarray | None:
        """Return better accelerations of the blocks, shape (b, n), and leave their roll-out; None if none were found.

        Args:
            start: Position and velocity at knot 0, shape (2, n) [rad, rad/s].
            accelerations: Of the blocks, where the torque is linearised, shape (b, n) [rad/s^2].
            reference: The motion at the knots 0 to N.
            disturbance: What acts on the arm besides the command, shape (n,) [N m].
        """
        interval = self.horizon.interval
        self._roll_out(start, accelerations)
        inputs, knots = self.torque.inputs, self.horizon.knots
        inputs["q"][:], inputs["dq"][:], inputs["ddq"][:] = self.q[:knots], self.dq[:knots], self.ddq
        inputs["payload"][:] = self.robot.payload
        outputs = self.torque()
        torque_room(outputs["torque"], disturbance, self.limit, self._least, self._most)
        reference_accelerations(reference.dq, interval, self._ddq_reference)
        np.subtract(self.q, reference.q, out=self._q_error)
        np.subtract(self.dq, reference.dq, out=self._dq_error)
        np.subtract(self.ddq, self._ddq_reference, out=self._ddq_error)
        self._condense(outputs["derivatives"], reference)
        change = self.program.solve(self._gradient, self._columns, self._least, self._most)
        if change is None:
            return None
        better: np.ndarray = accelerations + self._accelerations(change)
        self._roll_out(start, better)
        return better

    def _roll_out(self, start: np.ndarray, accelerations: np.ndarray) -> None:
        """Fill the states and accelerations of a plan."""
        horizon = self.horizon
        matrices = (horizon.position, horizon.velocity, horizon.selection)
        roll_out(start, accelerations, *matrices, horizon.interval, self.q, self.dq, self.ddq)

    @abstractmethod
    def _condense(self, derivatives: np.ndarray, reference: Preview) -> None:
        """Fill gradient and torque rows, by column, in coordinates in which the Hessian is the identity."""

    @abstractmethod
    def _accelerations(self, change: np.ndarray) -> np.ndarray:
        """Return a change in those coordinates as accelerations of the blocks, shape (b, n)."""


class JointProblem(PlanProblem):
    """Tracks the joints: a cost that is the same for all of them, so that its Hessian is known before the run."""

    def __init__(self, robot: RobotModel, horizon: Horizon, *, bandwidth: float, limit: np.ndarray) -> None:
        """Factorise the Hessian and turn the horizon's matrices into its coordinates.

        Args:
            robot: The arm.
            horizon: Knots and blocks.
            bandwidth: Of the regulator that the cost describes [rad/s].
            limit: Largest torque, shape (n,) [N m].
        """
        super().__init__(robot, horizon, bandwidth=bandwidth, limit=limit)
        cost: JointCost = tracking_cost(horizon, bandwidth)
        factor = np.linalg.cholesky(cost.hessian(horizon))
        self._weights = cost.weights
        self._unwhiten = solve_triangular(factor, np.eye(len(factor)), lower=True).T
        self._position, self._velocity = horizon.position @ self._unwhiten, horizon.velocity @ self._unwhiten
        self._selection = horizon.selection @ self._unwhiten

    def _condense(self, derivatives: np.ndarray, reference: Preview) -> None:
        basis = (self._position, self._velocity, self._selection)
        errors = (self._q_error, self._dq_error, self._ddq_error)
        tracking_gradient(*errors, self._weights, *basis, self._gradient)
        torque_columns(derivatives, *basis, self._columns)

    def _accelerations(self, change: np.ndarray) -> np.ndarray:
        return np.asarray(self._unwhiten @ change.reshape(len(self._unwhiten), -1))
