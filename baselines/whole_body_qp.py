"""Whole-body QP: the impedance law's tasks as an objective, what the drives and joints can do as constraints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..controllers import (
    Controller,
    DesignInertia,
    InvalidInput,
    LedgerEntry,
    Observation,
    RigidBodyState,
    Target,
    Task,
)
from .cartesian_impedance import PUBLISHED, impedance_torque, posture_acceleration, spring_wrench
from .damping import DAMPING_DESIGNS, square_root_damping, tool_mobility
from .gains import double_integrator_gains
from .qp_tasks import acceleration_gains, free_acceleration, limit_rows, limited_torque, task_matrices, torque_limits
from .quadratic_program import QuadraticProgram
from .rest import tick_at_rest
from .settings import require_bool, require_not_negative, require_one_of, require_positive, require_whole
from .viability import acceleration_limits, viable_accelerations

GAIN_FORMS = ("acceleration", "force")
FORCE_SETTINGS = ("linear_stiffness", "angular_stiffness", "damping_ratio", "damping_design")
"""Settings of the force form alone."""

CHOSEN: dict[str, str] = {
    "gain_form": "acceleration: the same error dynamics everywhere; force: the impedance's stiffness and damping",
    "bandwidth": "double pole of the tool's error, in acceleration form [rad/s]",
    "linear_stiffness": "the nominal of the Rizon 4 is 10000 [N/m]",
    "angular_stiffness": "1500 stands in one public configuration; the maker's figures disagree [N m/rad]",
    "damping_ratio": "the RDK's default is 0.7, its range 0.3 to 0.8",
    "damping_design": "with the model's apparent inertia",
    "posture_stiffness": "of the posture task [1/s^2]",
    "posture_damping": "of the posture task, critical with the stiffness [1/s]",
    "pose_weight": "of the pose against the posture, both in the metric of the inertia",
    "effort_weight": "of the squared torque against the posture; 1e-4 has no visible effect on tracking [1/(kg m^2)]",
    "slack_weight": "of leaving the acceleration bounds, times each joint's inertia; far above the pose weight",
    "position_margin": "kept from the position limits [rad]",
    "velocity_share": "share of the velocity limits that may be used",
    "acceleration_share": "share of the torque left after gravity that braking counts on",
    "tolerance": "of the solver, primal and dual [N m, rad/s^2]",
    "outer_iterations": "cap: a tick that needs more falls back",
    "inner_iterations": "cap: the solver's own default allowed a tick of 0.8 s",
    "warm_start": "from the last tick's solution",
}
"""What there is to say of the settings."""


@dataclass(kw_only=True)
class WholeBodyQp(Controller):
    r"""Joint acceleration that serves pose, posture and effort by weight, within the limits of drives and joints.

    .. math::
        \min_{\ddot q, s} \; & w_p \|J \ddot q - a^*\|^2_\Lambda + \|\ddot q - a_0\|^2_M
            + w_e \|M \ddot q + h\|^2 + w_s \|s\|^2_{\mathrm{diag} M} \\
        \text{s.t.} \; & \max(-\tau_{max}, \tau_{k-1} - \Delta) \le M \ddot q + h
            \le \min(\tau_{max}, \tau_{k-1} + \Delta) \\
        & \ddot q_{min}(q, \dot q) \le \ddot q + s \le \ddot q_{max}(q, \dot q)

    and the torque is M times the acceleration plus h. Posture a_0 and the tool's wrench F are those of
    :class:`torquebench.baselines.cartesian_impedance.CartesianImpedance` with full feed-forward, and

    .. math:: a^* = ((1 + w_p) \Lambda^{-1} F - J a_0) / w_p

    takes the posture's pull out of the pose, so that without an active limit and without effort the optimum is the
    impedance law's acceleration exactly, for every weight: in force form the two controllers differ by constraints
    only. In acceleration form :math:`F = \Lambda (\ddot x_d - \dot J \dot q + k_d \dot e + k_p e)`. The acceleration
    bounds come from viability. The solver works with the difference d to the free acceleration, in which the same
    objective is :math:`d^T (M + w_p J^T \Lambda J) d` and effort. A tick that is not solved falls back to the free
    torque, clipped.
    Sources: Del Prete, IEEE Robotics and Automation Letters 3 (2018) (bounds); Bambade and others, ProxQP, Robotics:
    Science and Systems (2022) (solver).

    Attributes:
        gain_form: ``"acceleration"`` or ``"force"``.
        bandwidth: Double pole of the tool's error in acceleration form [rad/s].
        linear_stiffness: Stiffness of the tool's position in force form [N/m].
        angular_stiffness: Stiffness of the tool's orientation in force form [N m/rad].
        damping_ratio: Share of critical damping in force form.
        damping_design: A name in :data:`torquebench.baselines.damping.DAMPING_DESIGNS`, in force form.
        posture_stiffness: Stiffness towards the planned posture [1/s^2].
        posture_damping: Damping towards the planned joint velocity [1/s].
        pose_weight: w_p, against the posture's 1.
        effort_weight: w_e, 0 without effort task [1/(kg m^2)].
        slack_weight: w_s.
        position_margin: Distance that is kept from the position limits [rad].
        velocity_share: Share of the velocity limits that may be used.
        acceleration_share: Share of the torque left after gravity that braking counts on.
        tolerance: Largest residual of a solution [N m, rad/s^2].
        outer_iterations: Cap of the solver's outer iterations.
        inner_iterations: Cap of the inner iterations in each.
        warm_start: Whether the solver starts at the last tick's solution.
    """

    gain_form: str = "acceleration"
    bandwidth: float = 20.0
    linear_stiffness: float = 10000.0
    angular_stiffness: float = 1500.0
    damping_ratio: float = 0.7
    damping_design: str = "square_root"
    posture_stiffness: float = 25.0
    posture_damping: float = 10.0
    pose_weight: float = 1e4
    effort_weight: float = 1e-4
    slack_weight: float = 1e6
    position_margin: float = 0.02
    velocity_share: float = 0.98
    acceleration_share: float = 0.5
    tolerance: float = 1e-6
    outer_iterations: int = 20
    inner_iterations: int = 20
    warm_start: bool = True

    def __post_init__(self) -> None:
        """Check the settings."""
        require_one_of("gain_form", self.gain_form, GAIN_FORMS)
        require_one_of("damping_design", self.damping_design, DAMPING_DESIGNS)
        require_bool("warm_start", self.warm_start)
        words = ("gain_form", "damping_design", "warm_start")
        may_be_zero = ("posture_stiffness", "posture_damping", "effort_weight", "position_margin")
        for field in fields(self):
            if field.name in may_be_zero:
                require_not_negative(field.name, getattr(self, field.name))
            elif field.name not in words:
                require_positive(field.name, getattr(self, field.name))
        for name in ("velocity_share", "acceleration_share"):
            if getattr(self, name) > 1.0:
                raise InvalidInput(f"{getattr(self, name)!r} is above 1", f"setting {name!r}", "a share of a limit")
        for name in ("outer_iterations", "inner_iterations"):
            require_whole(name, getattr(self, name), least=1)

    def reset(self, task: Task) -> None:
        """Take the model and the limits, and allocate for one episode."""
        self.robot, self.period = task.robot, float(task.period)
        self.initial_q = task.initial_q.copy()
        self._take_gains()
        self._take_limits(task)
        self._allocate(task.robot.n)
        self.fallbacks, self._iterations = 0, np.zeros(1, dtype=np.int64)
        self._build_programs()
        self.compute(*tick_at_rest(task))
        # The tick that loaded the kernels must not be seen in the counters, nor in the first warm start.
        self.fallbacks, self._iterations[0] = 0, 0
        self._build_programs()

    def _take_gains(self) -> None:
        self._is_force = self.gain_form == "force"
        self._design = DAMPING_DESIGNS[self.damping_design] if self._is_force else square_root_damping
        self._ratio = float(self.damping_ratio)
        self._stiffness = np.repeat([float(self.linear_stiffness), float(self.angular_stiffness)], 3)
        self._no_limit, self._feedforward = np.full(6, np.inf), np.ones(2)
        self._gains = np.array(double_integrator_gains(self.bandwidth, self.period))
        self._posture = np.array([self.posture_stiffness, self.posture_damping], dtype=float)
        self._weights = np.array([1.0, self.pose_weight, self.effort_weight, self.slack_weight], dtype=float)

    def _take_limits(self, task: Task) -> None:
        robot, rate = task.robot, task.actuation.torque_rate
        self._effort = np.array(task.actuation.effort, dtype=float)
        # A hair below the limiter's step: its own rounding must not count a torque at the limit as clipped.
        self._step = np.full(robot.n, np.inf) if rate is None else (1.0 - 1e-9) * task.period * np.array(rate)
        self._lower, self._upper = robot.lower + self.position_margin, robot.upper - self.position_margin
        self._velocity = self.velocity_share * robot.velocity
        self._reach, self._brake = acceleration_limits(robot, task.reference, self._effort, self.acceleration_share)

    def _allocate(self, n: int) -> None:
        self._mobility, self._damping, self._inertia = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        self._spring, self._free, self._torque = np.zeros(6), np.zeros(n), np.zeros(n)
        self._free_acceleration, self._still = np.zeros(n), np.zeros(2 * n)
        self._torque_bounds, self._acceleration_bounds = np.zeros((2, n)), np.zeros((2, n))
        self._hessian, self._gradient = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
        self._rows, self._bounds = np.zeros((2 * n, 2 * n)), np.zeros((2, 2 * n))
        self._rows[n:, :n] = self._rows[n:, n:] = np.eye(n)

    def _build_programs(self) -> None:
        """Build the solver of an episode; a subclass may need more than one."""
        self._program = self._new_program(2 * self.robot.n, 2 * self.robot.n)
        self._solvers: tuple[QuadraticProgram, ...] = (self._program,)

    def _new_program(self, variables: int, rows: int) -> QuadraticProgram:
        return QuadraticProgram(
            variables,
            rows,
            tolerance=self.tolerance,
            outer=self.outer_iterations,
            inner=self.inner_iterations,
            warm=self.warm_start,
        )

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        q, dq = observation.q, observation.dq
        state = self.robot.at(q, dq)
        mass, free, bounds = state.mass_matrix, self._free, self._torque_bounds
        self._free_law(state, observation, target)
        free_acceleration(mass, state.bias, free, self._free_acceleration)
        least, most = self._acceleration_bounds
        viable_accelerations(
            q, dq, self._lower, self._upper, self._velocity, self._reach, self._brake, self.period, least, most
        )
        feasible = torque_limits(observation.command, self._effort, self._step, bounds[0], bounds[1])
        limit_rows(mass, free, self._free_acceleration, bounds, self._acceleration_bounds, self._rows, self._bounds)
        beyond = self._solve(state) if feasible else None
        self._iterations[0] = sum(program.last_iterations for program in self._solvers) if feasible else 0
        if beyond is None:
            self.fallbacks += 1
            beyond = self._still
        limited_torque(mass, free, beyond, bounds, self._torque)
        return self._torque

    def _free_law(self, state: RigidBodyState, observation: Observation, target: Target) -> None:
        """Fill the torque that pose and posture ask for where nothing limits them, and the tool's inertia."""
        q, dq = observation.q, observation.dq
        tool_mobility(state.mass_matrix, state.jacobian, self._mobility)
        self._design(self._mobility, self._stiffness, self._ratio, self._damping, self._inertia)
        if self._is_force:
            spring_wrench(state.pose, target.pose, self._stiffness, self._no_limit, self._spring)
        else:
            acceleration_gains(state.pose, target.pose, self._gains, self._inertia, self._spring, self._damping)
        posture_acceleration(q, dq, target.q, target.dq, target.ddq, self._posture, self._free)
        impedance_torque(
            state.mass_matrix,
            state.bias,
            state.jacobian,
            state.jacobian_bias,
            dq,
            target.twist,
            target.acceleration,
            self._spring,
            self._damping,
            self._inertia,
            self._feedforward,
            self._free,
        )

    def _solve(self, state: RigidBodyState) -> np.ndarray | None:
        """Return d and the slacks, None if they were not found."""
        hessian, gradient, bounds = self._hessian, self._gradient, self._bounds
        task_matrices(state.mass_matrix, state.jacobian, self._inertia, self._free, self._weights, hessian, gradient)
        return self._program.solve(hessian, gradient, self._rows, bounds[0], bounds[1])

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return the solver's iterations, every tick."""
        return {"iterations": (self._iterations, 1)}

    def operations(self) -> Mapping[str, int]:
        """Return solves, iterations and fallbacks of the episode so far."""
        programs = self._solvers
        return {
            "qp_solves": sum(program.solves for program in programs),
            "qp_iterations": sum(program.iterations for program in programs),
            "qp_fallbacks": self.fallbacks,
        }

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from, and the accelerations that follow from the model and the plan."""
        limits = (
            (
                "acceleration_limit",
                self._reach,
                "torque limit over the joint's inertia, smallest on the plan [rad/s^2]",
            ),
            ("braking_acceleration", self._brake, "acceleration_share of what gravity leaves of it [rad/s^2]"),
        )
        return (
            *(self._entry(field.name) for field in fields(self)),
            *(LedgerEntry(setting=name, value=v.tolist(), source="rule", note=note) for name, v, note in limits),
        )

    def _entry(self, setting: str) -> LedgerEntry:
        """Return the origin of one setting: published if the impedance has it from a document."""
        value, note = getattr(self, setting), CHOSEN[setting]
        used = self._is_force if setting in FORCE_SETTINGS else not (setting == "bandwidth" and self._is_force)
        if not used:
            return LedgerEntry(setting=setting, value=value, source="chosen", note="without effect in this gain form")
        published, document = PUBLISHED.get(setting, (None, ""))
        if setting in PUBLISHED and value == published:
            return LedgerEntry(setting=setting, value=value, source="published", note=document)
        return LedgerEntry(setting=setting, value=value, source="chosen", note=note)

    def design_inertia(self) -> DesignInertia:
        r"""Return the joint damping at the start as inertia times its fastest rate; limits only take from it.

        .. math:: B = J^T D J + d_n N^T M, \quad \tau = -B \dot q + \dots
        """
        state = self.robot.at(self.initial_q, np.zeros(self.robot.n))
        mass, jacobian = state.mass_matrix, state.jacobian
        tool_mobility(mass, jacobian, self._mobility)
        self._design(self._mobility, self._stiffness, self._ratio, self._damping, self._inertia)
        damping = self._damping if self._is_force else self._gains[1] * self._inertia
        posture = mass - jacobian.T @ self._inertia @ jacobian
        joint_damping = jacobian.T @ damping @ jacobian + self.posture_damping * posture
        rate = float(np.max(np.linalg.eigvals(np.linalg.solve(mass, joint_damping)).real))
        return DesignInertia(mass_matrix=joint_damping / rate, damping=rate)
