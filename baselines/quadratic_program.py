"""Quadratic programs, solved again every tick: the solver's object is kept, and so is its last solution."""

import numpy as np

from .active_set import holds, refine, refine_projection, settle, settle_projection
from .portable_proxqp import proxqp

UNLIMITED = 1e20
"""What ProxQP takes for an infinite bound."""

GAPS = (100.0, 100.0)
"""Duality gap that is allowed, absolute and relative to the objective, in tolerances: a sum over rows of residuals."""

PROJECTION_GAPS = (1e4, 0.0)
"""The same of a projection, whose objective may be large in units that mean nothing to its rows."""

PENALTY = 1e-3
"""Inverse weight of a violated row in a projection; the solver's own 0.1 took twice as many iterations there."""


class KeptSolver:
    r"""ProxQP with its workspace kept from tick to tick, warm start, and a bounded number of iterations.

    A program that cannot be solved within the iterations has no solution here, rather than a wrong or a late one: with
    the solver's own caps one contradictory tick took 0.8 s. A warm start that fails is tried once more from cold; after
    a failure the next program starts cold.

    It is asked only where the active rows of the last solution, or of a few corrections of them, are not those of this
    one. What is kept of its answer is the set of active rows, and the minimiser on them is computed here: to the bit in
    every run, and exact where the solver has a tolerance.
    Source: Bambade, El-Kazdadi, Taylor, Carpentier, ProxQP, Robotics: Science and Systems (2022).

    Attributes:
        solves: Programs that were solved or tried.
        asked: Those of them that were handed to the solver.
        iterations: Corrections of the active rows and inner iterations of the solver, of all of them.
        last_iterations: The same of the last one.
    """

    _hessian_type = proxqp.dense.HessianType.Dense
    _penalty: float | None = None
    _gaps = GAPS

    def __init__(
        self, variables: int, rows: int, *, tolerance: float, outer: int, inner: int, warm: bool = True
    ) -> None:
        """Allocate.

        Args:
            variables: Number of variables.
            rows: Number of rows.
            tolerance: Largest residual, primal and dual, in the rows' and the gradient's units.
            outer: Largest number of outer iterations.
            inner: Largest number of inner iterations in each.
            warm: Whether a solve starts at the last solution.
        """
        self._program = proxqp.dense.QP(variables, 0, rows, False, self._hessian_type)
        settings = self._program.settings
        settings.eps_abs, settings.eps_rel = tolerance, 0.0
        # Small residuals alone are no optimum: from a warm start they hold with the last tick's multipliers, rows still
        # pushing that are far from their bounds by now. The duality gap sees that.
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = (share * tolerance for share in self._gaps)
        settings.max_iter, settings.max_iter_in = outer, inner
        # The preconditioner costs more than it saves: the unknowns are scaled by whoever states the program.
        settings.compute_preconditioner = False
        settings.initial_guess = proxqp.NO_INITIAL_GUESS
        self._warm = proxqp.WARM_START_WITH_PREVIOUS_RESULT if warm else proxqp.NO_INITIAL_GUESS
        self._tolerance, self._is_new = tolerance, True
        self._sides = np.zeros(rows)
        self.solves = self.asked = self.iterations = self.last_iterations = 0

    def _guess(self) -> np.ndarray:
        """Return the active rows to begin with: those of the last solution, or none from cold."""
        if self._warm == proxqp.NO_INITIAL_GUESS:
            self._sides[:] = 0.0
        return self._sides

    def _settled(self, tried: int) -> bool:
        """Count a program and the sets that were tried, negative without success; return whether it is solved."""
        self.solves += 1
        self.last_iterations = abs(tried) - 1
        self.iterations += self.last_iterations
        return tried > 0

    def _attempt(
        self, hessian: np.ndarray, gradient: np.ndarray, rows: np.ndarray, least: np.ndarray, most: np.ndarray
    ) -> np.ndarray | None:
        """Return the solver's answer, a new array, or None if there is none to the tolerance."""
        program, settings = self._program, self._program.settings
        data = (hessian, gradient, None, None, rows, least, most)
        if self._is_new:
            program.init(*data, compute_preconditioner=False, mu_in=self._penalty)
            self._is_new = False
        else:
            program.update(*data, update_preconditioner=False, mu_in=self._penalty)
        self.asked += 1
        before = self.last_iterations
        is_solved = self._run()
        if not is_solved and settings.initial_guess != proxqp.NO_INITIAL_GUESS:
            # The last tick's multipliers can lead astray where many rows change sides at once.
            settings.initial_guess = proxqp.NO_INITIAL_GUESS
            is_solved = self._run()
        self.iterations += self.last_iterations - before
        settings.initial_guess = self._warm if is_solved else proxqp.NO_INITIAL_GUESS
        multipliers = program.results.z
        self._sides[:] = np.sign(multipliers) * (np.abs(multipliers) > self._tolerance) if is_solved else 0.0
        return np.array(program.results.x) if is_solved else None

    def _run(self) -> bool:
        """Solve once, and return whether there is a solution."""
        self._program.solve()
        results = self._program.results
        self.last_iterations += int(results.info.iter)
        return bool(results.info.status == proxqp.PROXQP_SOLVED and np.isfinite(results.x).all())


class QuadraticProgram(KeptSolver):
    r"""One quadratic program.

    .. math:: \min_x \tfrac12 x^T H x + g^T x \quad \text{s.t.} \quad l \le C x \le u
    """

    def solve(
        self, hessian: np.ndarray, gradient: np.ndarray, rows: np.ndarray, least: np.ndarray, most: np.ndarray
    ) -> np.ndarray | None:
        """Return the minimiser, a new array, or None if it was not found to the tolerance.

        Args:
            hessian: H, positive definite, shape (v, v).
            gradient: g, shape (v,).
            rows: C, shape (r, v).
            least: l, shape (r,).
            most: u, shape (r,).
        """
        data, solution = (hessian, gradient, rows, least, most), np.empty_like(gradient)
        if self._settled(settle(*data, self._guess(), self._tolerance, solution)):
            return solution
        answer = self._attempt(*data)
        if answer is not None:
            refine(*data, self._program.results.z, self._tolerance, answer)
        return answer


class ProjectionProgram(KeptSolver):
    r"""One quadratic program whose Hessian is the identity: the point of a polyhedron that is nearest to -g.

    .. math:: \min_x \tfrac12 x^T x + g^T x \quad \text{s.t.} \quad l \le C x \le u

    Where -g violates no row it is the solution, and nothing is tried.
    """

    _hessian_type = proxqp.dense.HessianType.Diagonal
    _penalty = PENALTY
    _gaps = PROJECTION_GAPS

    def __init__(
        self, variables: int, rows: int, *, tolerance: float, outer: int, inner: int, warm: bool = True
    ) -> None:
        """Allocate; arguments as of :class:`KeptSolver`."""
        super().__init__(variables, rows, tolerance=tolerance, outer=outer, inner=inner, warm=warm)
        self._identity = np.eye(variables)

    def solve(
        self, gradient: np.ndarray, columns: np.ndarray, least: np.ndarray, most: np.ndarray
    ) -> np.ndarray | None:
        """Return the minimiser, a new array, or None if it was not found to the tolerance.

        Args:
            gradient: g, shape (v,).
            columns: C by column, shape (v, r).
            least: l, shape (r,).
            most: u, shape (r,).
        """
        if holds(columns, least, most, gradient, 0.0):
            self.last_iterations, self._sides[:] = 0, 0.0
            return -gradient
        bounds, solution = (least, most), np.empty_like(gradient)
        if self._settled(settle_projection(gradient, columns, *bounds, self._guess(), self._tolerance, solution)):
            return solution
        answer = self._attempt(self._identity, gradient, columns.T, *bounds)
        if answer is not None:
            refine_projection(gradient, columns, *bounds, self._program.results.z, self._tolerance, answer)
        return answer
