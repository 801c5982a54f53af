"""Nonlinear model predictive control: a plan every few ticks, an inner law that follows it at every tick."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import ClassVar

import numpy as np

from ..controllers import Controller, DesignInertia, InvalidInput, LedgerEntry, Observation, Target, Task
from .gains import double_integrator_gains
from .mpc_horizon import Horizon
from .mpc_kernels import planned_state, shift
from .mpc_problem import JointProblem, PlanProblem
from .rest import tick_at_rest
from .settings import require_positive, require_whole

CHOSEN: dict[str, str] = {
    "bandwidth": "of the cost's regulator and of the inner law, the stiff value of computed torque [rad/s]",
    "blocks": "knots that share an acceleration: 20 knots, and 8 unknowns per joint instead of 20",
    "interval": "between two knots: 0.4 s ahead with 20 of them [s]",
    "solve_every": "a plan every 5 ms follows as well as one every tick [ticks]",
    "solve_latency": "the arm follows the plan before until then; a solve takes a fraction of a tick [ticks]",
    "effort_share": "share of the torque limits that a plan may use",
    "observer_gain": "of the disturbance state, as of the knowledge level momentum_observer [1/s]",
}
"""What there is to say of the settings."""

NEVER = -1e6
"""Start of a plan that has long ended [s]."""


@dataclass(kw_only=True)
class Mpc(Controller):
    r"""Follows plans that track the joints over a horizon with every joint's torque within its limits.

    The plan is a sequence of joint accelerations, made by :class:`torquebench.baselines.mpc_problem.JointProblem` from
    the state that the running plan will have reached when the new one is ready. Between its knots it is exact, and at
    every tick

    .. math:: \tau = M(q) (\ddot q_p + k_d (\dot q_p - \dot q) + k_p (q_p - q)) + h(q, \dot q)

    with the model that the knowledge level grants. A solve that finds nothing is counted, and the running plan goes on;
    where a plan has ended, the reference takes its place.
    Sources: Diehl, Bock, Schloeder, SIAM J. Control Optim. 43 (2005) (real-time iteration); Bambade and others, ProxQP,
    Robotics: Science and Systems (2022) (solver); Andersson and others, CasADi, Math. Prog. Comp. 11 (2019) (model).

    Attributes:
        bandwidth: Of the regulator in the cost, and of the inner law [rad/s].
        blocks: Number of knots that share an acceleration, block after block; their sum is the horizon.
        interval: Time between two knots [s].
        solve_every: Ticks between two solves.
        solve_latency: Ticks after which a plan is used; planned from the state predicted for then.
        effort_share: Share of the torque limits that a plan may use.
    """

    bandwidth: float = 40.0
    blocks: Sequence[int] = (1, 1, 1, 1, 2, 2, 4, 8)
    interval: float = 0.02
    solve_every: int = 5
    solve_latency: int = 1
    effort_share: float = 1.0

    problem_type: ClassVar[type[PlanProblem]] = JointProblem

    def __post_init__(self) -> None:
        """Check the settings."""
        self.blocks = _whole_numbers("blocks", self.blocks)
        for name in ("bandwidth", "interval", "effort_share"):
            require_positive(name, getattr(self, name))
        for name in ("solve_every", "solve_latency"):
            require_whole(name, getattr(self, name), least=1 if name == "solve_every" else 0)
        if self.solve_latency > self.solve_every:
            came = f"{self.solve_latency} is above solve_every = {self.solve_every}"
            raise InvalidInput(came, "setting 'solve_latency'", "a plan must be ready before the next is begun")

    def reset(self, task: Task) -> None:
        """Compile or load the model's equations, and allocate for one episode."""
        self.robot, self.period, self.initial_q = task.robot, float(task.period), task.initial_q.copy()
        self.stiffness, self.damping = double_integrator_gains(self.bandwidth, self.period)
        self.horizon = Horizon.of(tuple(self.blocks), self.interval)
        self._limit = self.effort_share * np.array(task.actuation.effort, dtype=float)
        self._knots = self.interval * np.arange(self.horizon.knots + 1)
        self.problem = self.problem_type(self.robot, self.horizon, bandwidth=self.bandwidth, limit=self._limit)
        self._allocate(task.robot.n)
        self._begin()
        self.compute(*tick_at_rest(task))
        # The tick that loaded the kernels must not be seen in the counters, nor in the first plan.
        self._begin()

    def _allocate(self, n: int) -> None:
        knots, blocks = self.horizon.selection.shape
        self._start, self._accelerations = np.zeros((2, n)), np.zeros((blocks, n))
        self._running = (np.zeros((knots + 1, n)), np.zeros((knots + 1, n)), np.zeros((knots, n)))
        self._aim, self._acceleration, self._error = np.zeros((3, n)), np.zeros(n), np.zeros(n)
        self._shown = np.zeros(2, dtype=np.int64)

    def _begin(self) -> None:
        """Start an episode without a plan."""
        self.problem.restart()
        self._disturbance = self.robot.disturbance
        self._tick, self.fallbacks = 0, 0
        self._started, self._begins, self._is_waiting = NEVER, NEVER, False

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        q, dq, now = observation.q, observation.dq, observation.time
        phase = self._tick % self.solve_every
        if phase == self.solve_latency % self.solve_every:
            self._adopt()
        self._follow(q, dq, now, target)
        if phase == 0:
            self._plan(q, dq, now, target)
            if self.solve_latency == 0:
                self._adopt()
                self._follow(q, dq, now, target)
        self._tick += 1
        return self.robot.inverse_dynamics(q, dq, self._acceleration)

    def _follow(self, q: np.ndarray, dq: np.ndarray, now: float, target: Target) -> None:
        """Fill the acceleration that follows the running plan, or the reference beyond its end."""
        aim, acceleration, error = self._aim, self._acceleration, self._error
        if not planned_state(*self._running, self.interval, now - self._started, aim):
            aim[0], aim[1], aim[2] = target.q, target.dq, target.ddq
        np.subtract(aim[0], q, out=error)
        error *= self.stiffness
        np.add(aim[2], error, out=acceleration)
        np.subtract(aim[1], dq, out=error)
        error *= self.damping
        acceleration += error

    def _plan(self, q: np.ndarray, dq: np.ndarray, now: float, target: Target) -> None:
        """Solve for the plan that starts when this one is ready."""
        ahead = self.solve_latency * self.period
        self._start[0] = q + ahead * dq + 0.5 * ahead**2 * self._acceleration
        self._start[1] = dq + ahead * self._acceleration
        begins = now + ahead
        reference = target.preview(begins + self._knots)
        self._linearise_about(reference.dq, begins)
        found = self.problem.solve(self._start, self._accelerations, reference, self._disturbance)
        self._begins, self._is_waiting = begins, found is not None
        self.fallbacks += found is None
        self._shown[:] = self.problem.program.last_iterations, found is None

    def _linearise_about(self, reference_dq: np.ndarray, begins: float) -> None:
        """Fill the accelerations that the next solve starts from: the running plan's, or the reference's."""
        elapsed = (begins - self._started) / self.interval
        accelerations = self._running[2]
        if elapsed > self.horizon.knots:
            accelerations, elapsed = np.diff(reference_dq, axis=0) / self.interval, 0.0
        shift(accelerations, elapsed, self.horizon.selection, self._accelerations)

    def _adopt(self) -> None:
        """Run the plan that waits for its time, if there is one."""
        if self._is_waiting:
            problem = self.problem
            for running, found in zip(self._running, (problem.q, problem.dq, problem.ddq), strict=True):
                np.copyto(running, found)
            self._started = self._begins
        self._is_waiting = False

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return, for every solve, the solver's iterations and whether it found nothing."""
        return {"solve": (self._shown, self.solve_every)}

    def operations(self) -> Mapping[str, int]:
        """Return solves, those that a limit made hard, iterations and fallbacks of the episode so far."""
        program = self.problem.program
        return {
            "mpc_solves": -(-self._tick // self.solve_every),
            "qp_solves": program.solves,
            "qp_iterations": program.iterations,
            "mpc_fallbacks": self.fallbacks,
        }

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting comes from, and how the model's equations run here."""
        rule = "discrete LQR of the double integrator with Q = diag(w^4, 2 w^2), R = 1, w the bandwidth"
        how = "machine code" if self.problem.is_compiled else "CasADi's interpreter: no working C compiler"
        names = [field.name for field in fields(self)]
        return (
            *(LedgerEntry(setting=name, value=self._value(name), source="chosen", note=CHOSEN[name]) for name in names),
            LedgerEntry(setting="stiffness", value=self.stiffness, source="rule", note=f"inner law, {rule} [1/s^2]"),
            LedgerEntry(setting="damping", value=self.damping, source="rule", note=f"inner law, {rule} [1/s]"),
            LedgerEntry(setting="equations", value=how, source="rule", note="the same arithmetic to the bit"),
        )

    def _value(self, name: str) -> object:
        value = getattr(self, name)
        return list(value) if name == "blocks" else value

    def design_inertia(self) -> DesignInertia:
        """Return the model's mass matrix at the start: the linearised joints are damped with it."""
        return DesignInertia(mass_matrix=self.robot.mass_matrix(self.initial_q), damping=self.damping)


def _whole_numbers(name: str, value: object) -> tuple[int, ...]:
    """Return a setting of whole numbers as a tuple: a list from a file and a tuple from code are one setting."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise InvalidInput(f"{value!r} is not a list", f"setting {name!r}", "whole numbers, such as [1, 1, 2]")
    numbers = tuple(value)
    for number in numbers or (0,):
        require_whole(name, number, least=1)
    return numbers
