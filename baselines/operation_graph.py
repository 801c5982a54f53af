"""A law's tick as an expression graph, and what stands in it: every operation once, after common ones are shared."""

from dataclasses import dataclass, field

import casadi as ca

from ..controllers import RobotModel
from ..controllers.operations import OperationCounts
from .symbolic_dynamics import Expression, tool_expressions, torque_expression

KINDS: dict[int, str] = {
    **dict.fromkeys((ca.OP_MUL, ca.OP_SQ), "multiplications"),
    **dict.fromkeys((ca.OP_ADD, ca.OP_SUB, ca.OP_TWICE), "additions"),
    **dict.fromkeys((ca.OP_DIV, ca.OP_INV, ca.OP_SQRT), "divisions"),
    **dict.fromkeys((ca.OP_SIN, ca.OP_COS, ca.OP_ATAN2, ca.OP_EXP, ca.OP_LOG), "transcendentals"),
    **dict.fromkeys(
        (ca.OP_NEG, ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE), "comparisons"
    ),
    **dict.fromkeys((ca.OP_AND, ca.OP_OR, ca.OP_NOT, ca.OP_IF_ELSE_ZERO, ca.OP_SIGN), "comparisons"),
}
"""CasADi's instructions by their name in :class:`OperationCounts`."""


@dataclass(frozen=True, kw_only=True)
class GraphCounts:
    """What one evaluation of a graph costs.

    Attributes:
        operations: Its operations and the numbers that it touches.
        parameters: Constants and gains that it reads.
        state: Other numbers that it reads or writes.
    """

    operations: OperationCounts
    parameters: int
    state: int


@dataclass(kw_only=True, eq=False)
class TickGraph:
    r"""The symbols of one tick and the equations of an arm, for writing a law as expressions.

    The arm's own payload is part of its last link and costs nothing; the disturbance that a knowledge level tells is
    subtracted, as :class:`RobotModel` does.

    Attributes:
        robot: The arm.
        read: Symbols that come from memory: measurements, plan, what was remembered.
        gains: Symbols of numbers that do not change.
        given: Symbols of intermediate results that a formula and no graph counts, such as eigenvectors.
        written: Expressions that go to memory: torque, what is remembered.
        handed: Expressions that such a formula takes.
    """

    robot: RobotModel
    read: list[Expression] = field(default_factory=list)
    gains: list[Expression] = field(default_factory=list)
    given: list[Expression] = field(default_factory=list)
    written: list[Expression] = field(default_factory=list)
    handed: list[Expression] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Make the symbols that every law has."""
        n = self.robot.n
        self.q, self.dq = self.reading("q", n), self.reading("dq", n)
        self.q_ref, self.dq_ref, self.ddq_ref = (self.reading(name, n) for name in ("q_ref", "dq_ref", "ddq_ref"))
        self.command, self._disturbance = self.reading("command", n), self.reading("disturbance", n)
        self._rotor = self.gain("rotor", n)
        self.still = ca.SX.zeros(n)

    def reading(self, name: str, rows: int, columns: int = 1) -> Expression:
        """Return a symbol that is read from memory."""
        self.read.append(ca.SX.sym(name, rows, columns))
        return self.read[-1]

    def gain(self, name: str, rows: int = 1) -> Expression:
        """Return a symbol of numbers that do not change."""
        self.gains.append(ca.SX.sym(name, rows))
        return self.gains[-1]

    def result(self, name: str, rows: int, columns: int = 1) -> Expression:
        """Return a symbol of what a formula has computed."""
        self.given.append(ca.SX.sym(name, rows, columns))
        return self.given[-1]

    def inverse_dynamics(self, q: Expression, dq: Expression, ddq: Expression) -> Expression:
        """Return the torque of a motion less the disturbance, rotors included."""
        return self._torque(q, dq, ddq) - self._disturbance

    def gravity(self) -> Expression:
        """Return the gravity torque less the disturbance."""
        return torque_expression(self.robot, self.q, self.still, self.still, ca.SX.zeros(10)) - self._disturbance

    def bias(self) -> Expression:
        """Return Coriolis, centrifugal and gravity torque less the disturbance."""
        return self.inverse_dynamics(self.q, self.dq, self.still)

    def mass_matrix(self) -> Expression:
        """Return the inertia with rotors: one triangle is computed, the other is the same numbers."""
        acceleration = ca.SX.sym("acceleration", self.robot.n)
        matrix = ca.jacobian(self._torque(self.q, self.still, acceleration), acceleration)
        return ca.tril2symm(ca.tril(matrix))

    def tool(self) -> tuple[Expression, Expression, Expression]:
        """Return the tool's position, rotation and jacobian."""
        return tool_expressions(self.robot, self.q)

    def count(self) -> GraphCounts:
        """Count what was written so far."""
        inputs = [*self.read, *self.gains, *self.given]
        function = ca.Function("tick", inputs, ca.cse([ca.densify(e) for e in (*self.written, *self.handed)]))
        return count_graph(
            function,
            gains=range(len(self.read), len(self.read) + len(self.gains)),
            inner=range(len(self.read) + len(self.gains), len(inputs)),
            handed=range(len(self.written), len(self.written) + len(self.handed)),
        )

    def _torque(self, q: Expression, dq: Expression, ddq: Expression) -> Expression:
        return torque_expression(self.robot, q, dq, ddq, ca.SX.zeros(10)) + self._rotor * ddq


def count_graph(
    function: ca.Function, *, gains: range = range(0), inner: range = range(0), handed: range = range(0)
) -> GraphCounts:
    """Count the instructions of an expanded function.

    Args:
        function: Of ``SX`` expressions.
        gains: Numbers of the inputs that do not change.
        inner: Numbers of the inputs that are intermediate results.
        handed: Numbers of the outputs that are intermediate results.
    """
    found: dict[str, int] = {}
    constants: set[float] = set()
    parameters = state = 0
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        if code == ca.OP_CONST:
            constants.add(function.instruction_constant(k))
        elif code == ca.OP_INPUT:
            source = function.instruction_input(k)[0]
            parameters += source in gains
            state += source not in gains and source not in inner
        elif code == ca.OP_OUTPUT:
            state += function.instruction_output(k)[0] not in handed
        else:
            found[KINDS[code]] = found.get(KINDS[code], 0) + 1
    parameters += len(constants)
    operations = OperationCounts(**found, touched=parameters + state)
    return GraphCounts(operations=operations, parameters=parameters, state=state)


def cholesky(matrix: Expression) -> Expression:
    """Return the lower factor of a positive definite matrix, written out."""
    n = matrix.shape[0]
    factor = ca.SX.zeros(n, n)
    for i in range(n):
        for j in range(i + 1):
            rest = matrix[i, j] - ca.dot(factor[i, :j], factor[j, :j]) if j else matrix[i, j]
            factor[i, j] = ca.sqrt(rest) if i == j else rest / factor[j, j]
    return factor


def forward(factor: Expression, right: Expression) -> Expression:
    """Return the solution of L X = B, column by column, written out."""
    result = ca.SX.zeros(*right.shape)
    for i in range(right.shape[0]):
        result[i, :] = (right[i, :] - factor[i, :i] @ result[:i, :] if i else right[i, :]) / factor[i, i]
    return result


def rotation_error(rotation: Expression, desired: Expression) -> Expression:
    """Return the rotation vector between two orientations, by the branch that small errors take."""
    turn = desired @ rotation.T
    w = 0.5 * ca.sqrt(1.0 + ca.trace(turn))
    vector = ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]) / (4.0 * w)
    sine = ca.sqrt(ca.sumsqr(vector))
    return vector * (2.0 * ca.atan2(sine, ca.fabs(w)) / sine)


def symmetric_eigen(n: int) -> OperationCounts:
    """Return what eigenvalues and eigenvectors of a symmetric matrix cost, about 9 n^3 operations.

    Source: Golub, Van Loan, Matrix Computations (2013), section 8.3 (symmetric QR with accumulated rotations).
    """
    return OperationCounts(macs=4.5 * n**3)
