"""Computed torque with a spiking population that learns online what the model lacks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numba
import numpy as np

from ..controllers import Controller, DesignInertia, InvalidInput, LedgerEntry, Observation, Target, Task
from .gains import double_integrator_gains
from .rest import tick_at_rest
from .settings import require_not_negative, require_positive
from .spiking_ensemble import DECODES, SPIKES, TICKS, UPDATES, SpikingEnsemble

TUNED_RATE = 0.01
"""Learning rate that was searched [1/(s Hz^2)]."""

TUNING = "power of ten; T6, 3.5 kg, actuated: 0.1 doubles the torque ripple, 1 diverges"


@dataclass(kw_only=True)
class SpikingAdaptive(Controller):
    r"""Feedback linearisation plus the torque of an adaptive spiking ensemble.

    .. math:: \tau = M (\ddot q_d + k_d \dot e + k_p e) + h + D a(q, \dot q), \quad
        \Delta D = \frac{\kappa h}{n} M (k_d \dot e + k_p e) a^T

    The training signal is the law's own feedback torque: what feedback has to do again and again, the ensemble takes
    over, where in (q, dq) it happens. Nothing is learnt before the run.
    Source: DeWolf, Stewart, Slotine, Eliasmith, A spiking neural model of adaptive arm control, Proc. R. Soc. B 283
    (2016), on joint level; learning rule: MacNeil, Eliasmith, PLoS ONE 6 (2011). Own implementation.

    Attributes:
        bandwidth: Place of the double closed-loop pole of the law without the ensemble [rad/s].
        neurons: Number of neurons.
        learning_rate: kappa [1/(s Hz^2)].
    """

    estimates_load: ClassVar[bool] = True

    bandwidth: float = 20.0
    neurons: int = 1000
    learning_rate: float = TUNED_RATE

    def __post_init__(self) -> None:
        """Check the settings."""
        require_positive("bandwidth", self.bandwidth)
        require_not_negative("learning_rate", self.learning_rate)
        if not isinstance(self.neurons, int) or isinstance(self.neurons, bool) or self.neurons < 1:
            raise InvalidInput(
                f"{self.neurons!r} is not a count", "setting 'neurons'", "expected a whole number above 0"
            )

    def reset(self, task: Task) -> None:
        """Draw a new ensemble and compute the gains for one episode."""
        self.robot, self.initial_q = task.robot, task.initial_q.copy()
        self.stiffness, self.damping = double_integrator_gains(self.bandwidth, task.period)
        n = task.robot.n
        self._feedback, self._acceleration, self._plain = np.zeros(n), np.zeros(n), np.zeros(n)
        self._centre, self._scale = centre_and_scale(task.robot.lower, task.robot.upper, task.robot.velocity)
        self._draw(task)
        self.compute(*tick_at_rest(task))
        self._draw(task)

    def _draw(self, task: Task) -> None:
        """Make the ensemble from the run's own stream."""
        n, rng = task.robot.n, np.random.default_rng(task.seed)
        self.ensemble = SpikingEnsemble(self.neurons, 2 * n, n, rate=self.learning_rate, period=task.period, rng=rng)

    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]."""
        q, dq, ensemble, dynamics = observation.q, observation.dq, self.ensemble, self.robot.inverse_dynamics
        feedback, acceleration, torque = self._feedback, self._acceleration, self._plain
        np.subtract(target.q, q, out=feedback)
        feedback *= self.stiffness
        np.subtract(target.dq, dq, out=acceleration)
        acceleration *= self.damping
        feedback += acceleration
        np.add(target.ddq, feedback, out=acceleration)
        np.copyto(torque, dynamics(q, dq, acceleration))
        # Two calls of inverse dynamics differ by M times the feedback: cheaper than the mass matrix.
        np.subtract(torque, dynamics(q, dq, target.ddq), out=ensemble.error)
        place_in_ball(q, dq, self._centre, self._scale, ensemble.stimulus)
        ensemble.tick()
        torque += ensemble.output
        return torque

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return the torque that the ensemble adds, shape (n,) [N m], every 10 ticks."""
        return {"adaptive_torque": (self.ensemble.output, 10)}

    def operations(self) -> Mapping[str, int]:
        """Return spikes, decoder updates and products of the ensemble since reset."""
        tally, encoders = self.ensemble.tally, self.ensemble.encoders
        weights = encoders.size + self.ensemble.decoders.size
        return {
            "ensemble_dense": int(tally[TICKS]) * weights,
            "ensemble_effective_macs": int(tally[TICKS]) * encoders.size,
            "ensemble_spikes": int(tally[SPIKES]),
            "ensemble_parameter_updates": int(tally[UPDATES]),
            "ensemble_effective_acs": int(tally[SPIKES]) * len(self.ensemble.output),
            "ensemble_executed_macs": int(tally[TICKS]) * encoders.size + int(tally[DECODES]),
            "ensemble_membrane_dense": int(tally[TICKS]) * encoders.shape[1],
        }

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return where each setting and gain comes from."""
        rule = "discrete LQR of the double integrator with Q = diag(w^4, 2 w^2), R = 1, w the bandwidth"
        neurons = LedgerEntry(setting="neurons", value=self.neurons, source="chosen", note="by the user")
        if self.neurons == 1000:
            neurons = replace(neurons, source="published", note="abr_control's adaptive arm examples")
        learning = LedgerEntry(setting="learning_rate", value=self.learning_rate, source="chosen", note="[1/(s Hz^2)]")
        if self.learning_rate == TUNED_RATE:
            learning = replace(learning, source="tuned", trials=5, note=f"{TUNING} [1/(s Hz^2)]")
        return (
            LedgerEntry(setting="bandwidth", value=self.bandwidth, source="chosen", note="[rad/s]"),
            neurons,
            learning,
            LedgerEntry(setting="stiffness", value=self.stiffness, source="rule", note=f"{rule} [1/s^2]"),
            LedgerEntry(setting="damping", value=self.damping, source="rule", note=f"{rule} [1/s]"),
        )

    def design_inertia(self) -> DesignInertia:
        """Return the model's mass matrix at the start: the linearised joints are damped with it."""
        return DesignInertia(mass_matrix=self.robot.mass_matrix(self.initial_q), damping=self.damping)


def centre_and_scale(lower: np.ndarray, upper: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""Return what brings joint states into a ball.

    .. math:: x = ((q, \dot q) - c) \cdot s, \quad s = 1 / (\sqrt 2 \cdot \text{half range})

    A joint without finite limits counts as a whole turn and 1 rad/s.

    Args:
        lower: Lower position limits, shape (n,) [rad].
        upper: Upper position limits, shape (n,) [rad].
        velocity: Velocity limits, shape (n,) [rad/s].

    Returns:
        c [rad, rad/s] and s [1/rad, s/rad], shapes (2n,).
    """
    limited = np.isfinite(lower) & np.isfinite(upper) & (upper > lower)
    low, high = np.where(limited, lower, -np.pi), np.where(limited, upper, np.pi)
    fastest = np.where(np.isfinite(velocity) & (velocity > 0.0), velocity, 1.0)
    centre = np.concatenate([0.5 * (low + high), np.zeros_like(fastest)])
    return centre, 1.0 / (np.sqrt(2.0) * np.concatenate([0.5 * (high - low), fastest]))


@numba.njit(cache=True)
def place_in_ball(q: np.ndarray, dq: np.ndarray, centre: np.ndarray, scale: np.ndarray, point: np.ndarray) -> None:
    """Write the scaled joint state, shortened to length 1 if it is longer.

    Args:
        q: Joint positions, shape (n,) [rad].
        dq: Joint velocities, shape (n,) [rad/s].
        centre: Shape (2n,) [rad, rad/s].
        scale: Shape (2n,) [1/rad, s/rad].
        point: Receives the state, shape (2n,).
    """
    n, square = q.shape[0], 0.0
    for i in range(2 * n):
        value = q[i] if i < n else dq[i - n]
        point[i] = (value - centre[i]) * scale[i]
        square += point[i] ** 2
    if square > 1.0:
        length = np.sqrt(square)
        for i in range(2 * n):
            point[i] /= length
