"""Whole-body QP with strict priorities: the posture gets what the tool's pose leaves, and nothing more."""

from dataclasses import dataclass

import numpy as np

from ..controllers import RigidBodyState
from .qp_null_space import null_basis, null_program, redundancy
from .qp_tasks import task_matrices
from .whole_body_qp import WholeBodyQp

POSE_LEVEL = 1e-6
"""Weight of the posture in the pose's level: enough to make its solution unique."""


@dataclass(kw_only=True)
class WholeBodyQpStrict(WholeBodyQp):
    r"""Two programs a tick: first the pose within all limits, then posture and effort without touching the pose.

    .. math::
        d_1 &= \arg\min_{d, s} \; \|J d\|^2_\Lambda + \epsilon \|d\|^2_M + (w_s / w_p) \|s\|^2_{\mathrm{diag} M}
            \quad \text{s.t. all limits} \\
        d_2 &= \arg\min_d \; \|d\|^2_M + w_e \|M (\ddot q_0 + d) + h\|^2
            \quad \text{s.t.} \quad J d = J d_1, \; \text{all limits}

    with d the joint acceleration beyond the free one, see :class:`WholeBodyQp`. The second program is written in
    coordinates of the null space, so that its equality holds by construction; where the first had to leave a bound,
    the second may stay there. Without an active limit both versions are the same law; with one, weights trade a little
    of the pose for posture and this version does not. An unsolved second level keeps the first level's solution.
    Source: Escande, Mansard, Wieber, Hierarchical quadratic programming, Int. J. Robotics Research 33 (2014).

    Attributes:
        pose_weight: Against the slack only: the pose comes first.
    """

    def _allocate(self, n: int) -> None:
        super()._allocate(n)
        self._pose_weights = np.array([POSE_LEVEL, 1.0, 0.0, self.slack_weight / self.pose_weight])
        self._rest_weights = np.array([1.0, 0.0, self.effort_weight, 1.0])
        freedom = redundancy(self.robot.at(self.initial_q, np.zeros(n)).jacobian)
        self._basis, self._null_rows = np.zeros((n, freedom)), np.zeros((2 * n, freedom))
        self._null_hessian, self._null_gradient = np.zeros((freedom, freedom)), np.zeros(freedom)
        self._null_bounds = np.zeros((2, 2 * n))

    def _build_programs(self) -> None:
        super()._build_programs()
        n, freedom = self._basis.shape
        if freedom:
            self._rest = self._new_program(freedom, 2 * n)
            self._solvers = (self._program, self._rest)

    def _solve(self, state: RigidBodyState) -> np.ndarray | None:
        mass, jacobian, hessian, gradient = state.mass_matrix, state.jacobian, self._hessian, self._gradient
        task_matrices(mass, jacobian, self._inertia, self._free, self._pose_weights, hessian, gradient)
        first = self._program.solve(hessian, gradient, self._rows, self._bounds[0], self._bounds[1])
        if first is None or not self._basis.shape[1]:
            return first
        task_matrices(mass, jacobian, self._inertia, self._free, self._rest_weights, hessian, gradient)
        null_basis(mass, jacobian, self._mobility, self._basis)
        null_program(
            hessian,
            gradient,
            self._rows,
            self._bounds,
            first,
            self._basis,
            self._null_hessian,
            self._null_gradient,
            self._null_rows,
            self._null_bounds,
        )
        least, most = self._null_bounds
        rest = self._rest.solve(self._null_hessian, self._null_gradient, self._null_rows, least, most)
        if rest is not None:
            first[: self._basis.shape[0]] += self._basis @ rest
        return first
