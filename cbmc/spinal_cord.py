"""The spinal cord: turns errors into spikes of agonist and antagonist fibres, and these into torque, at 1 kHz.

Source: the paper's section "Spinal cord module", its table of neuron parameters, and its algorithm.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numba
import numpy as np

from ..controllers.kernels import bind
from .neuron import Lif
from .pathways import Ascending, Descending

BLOCK = 16
"""Ticks for which random numbers are drawn at once: a longer block would make one tick late."""

CALLS, SPIKES = 0, 1


@dataclass(frozen=True, kw_only=True)
class SpinalCordTable:
    """The paper's table "Neuron parameters of the spinal cord module", and the reading of its sum.

    Attributes:
        membrane: The non-spiking output neurons, one for each joint, one step per tick.
        position_width: Delta q, the largest position error that is encoded [rad].
        velocity_width: Delta dq, the largest velocity error that is encoded [rad/s].
        fibres: k, encoding neurons of one signal of one joint; half agonist, half antagonist.
        spike_gain: What one spike is worth. None is 2 Delta / k, the mean, which decodes the error itself in rad and
            rad/s, so that the brainstem's gains are gains of a PD law. 1.0 is the printed sum, 100 times as stiff.
    """

    membrane: Lif = field(default=Lif(u_reset=0.0, tau_mb=2.0))
    position_width: float = 0.5
    velocity_width: float = 0.5
    fibres: int = 100
    spike_gain: float | None = None

    @property
    def widths(self) -> np.ndarray:
        """Largest errors encoded, position and velocity, shape (2,) [rad, rad/s]."""
        return np.array([self.position_width, self.velocity_width])

    @property
    def spike_worth(self) -> np.ndarray:
        """What one spike of position and of velocity is worth, shape (2,)."""
        mean = 2.0 * self.widths / self.fibres
        return mean if self.spike_gain is None else np.full(2, self.spike_gain)


class RateEncoder:
    r"""The paper's encoder: a fibre fires where the error, as a share of Delta, reaches a uniform draw.

    Of a signal's k fibres the agonist half answers to positive errors, the antagonist half to negative ones, so that
    only one half is drawn. Their signed sum is sign(e) Binomial(k/2, min(abs(e)/Delta, 1)). Draws are independent
    over fibres, joints, signals and ticks (the printed index j alone would share them over joints).

    Attributes:
        position: s_q, signed spikes times their worth, shape (n,) [rad].
        velocity: s_dq, shape (n,) [rad/s].
        spikes: Signed spikes of the last tick, positions before velocities, shape (2, n), int64.
    """

    def __init__(self, joints: int, table: SpinalCordTable, rng: np.random.Generator) -> None:
        """Make an encoder that draws from this generator, in blocks of 16 ticks."""
        self._rng, self._tick = rng, BLOCK
        # Single precision halves the cost of a tick and moves a probability by 6e-8 at most.
        self._uniforms = np.empty((BLOCK, 2, joints, table.fibres // 2), dtype=np.float32)
        self._encoded = np.zeros((2, joints))
        self.position, self.velocity = self._encoded
        self.spikes = np.zeros((2, joints), dtype=np.int64)

    def connect(self, *arrays: np.ndarray) -> Callable[[], None]:
        """Return what runs one tick of encoder and membrane on these arrays (:meth:`SpinalCord.connect`)."""
        self._kernel = bind(_act_on_spikes, *arrays, self._encoded, self.spikes, self._uniforms, tick=True)
        return self._act

    def _act(self) -> None:
        if self._tick == BLOCK:
            self._rng.random(out=self._uniforms, dtype=np.float32)
            self._tick = 0
        self._kernel(self._tick)
        self._tick += 1


class ExactEncoder:
    """No spikes: the mean of what the rate encoder would give, saturation included. An ablation, not the paper's.

    Attributes:
        position: s_q, shape (n,) [rad].
        velocity: s_dq, shape (n,) [rad/s].
        spikes: Stay zero, shape (2, n), int64.
    """

    def __init__(self, joints: int) -> None:
        """Make an encoder without randomness."""
        self._encoded = np.zeros((2, joints))
        self.position, self.velocity = self._encoded
        self.spikes = np.zeros((2, joints), dtype=np.int64)

    def connect(self, *arrays: np.ndarray) -> Callable[[], None]:
        """Return what runs one tick of encoder and membrane on these arrays."""
        return bind(_act_on_means, *arrays, self._encoded)


class SpinalCord:
    """Encoder, gains, and one non-spiking neuron for each joint, whose potential is the torque.

    Attributes:
        encoder: The encoder.
        encoded_position: s_q of the last tick, shape (n,) [rad].
        encoded_velocity: s_dq of the last tick, shape (n,) [rad/s].
        spikes: Signed spikes of the last tick, positions before velocities, shape (2, n), int64. Only one half of
            the fibres can fire, so the magnitude is the count.
        tally: Ticks, spikes; cumulative, int64.
    """

    def __init__(self, joints: int, table: SpinalCordTable, encoder: RateEncoder | ExactEncoder) -> None:
        """Make a spinal cord.

        Args:
            joints: Number of joints, n.
            table: The paper's parameters, ``SpinalCordTable()``; other values are not the paper's.
            encoder: ``RateEncoder(joints, table, rng)``, or ``ExactEncoder(joints)``.
        """
        self.joints, self.table, self.encoder = joints, table, encoder
        self.encoded_position, self.encoded_velocity = encoder.position, encoder.velocity
        self.spikes = encoder.spikes
        self.tally = np.zeros(2, dtype=np.int64)
        membrane = (table.membrane.u_reset, table.membrane.tau_mb, float(table.fibres // 2))
        self._constants = np.array([*table.widths, *table.spike_worth, *membrane])

    def connect(self, ascending: Ascending, descending: Descending) -> None:
        """Join the pathways; their arrays are the module's inputs and outputs from now on."""
        self._torque = descending.torque
        signals = (ascending.q_desired, ascending.dq_desired, ascending.q, ascending.dq)
        orders = (descending.gravity_torque, descending.stiffness, descending.damping, descending.torque)
        self._act = self.encoder.connect(*signals, *orders, self._constants, self.tally)

    def act(self) -> None:
        r"""Take one tick; the membrane's potential u_sp is ``descending.torque``.

        .. math::
            \delta u_i = \tau_{g,i} + k_{p,i} s_{q,i} + k_{v,i} s_{\dot q,i}, \qquad
            u_i \leftarrow u_i + (\delta u_i - (u_i - u_\text{reset})) / \tau_\text{mb}
        """
        self._act()

    def settle(self, torque: np.ndarray) -> None:
        """Put the membrane at a torque, shape (n,) [N m]; a warm start takes the gravity torque."""
        self._torque[:] = torque


WIDTH, WORTH, RESET, TAU, HALF = 0, 2, 4, 5, 6  # entries of the kernels' constants


@numba.njit(cache=True)
def _integrate(gravity, stiffness, damping, torque, constants, encoded):  # type: ignore[no-untyped-def]
    """Take one step of the output neurons."""
    for i in range(torque.shape[0]):
        increment = gravity[i] + stiffness[i] * encoded[0, i] + damping[i] * encoded[1, i]
        torque[i] += (increment - (torque[i] - constants[RESET])) / constants[TAU]


@numba.njit(cache=True)
def _count_fired(uniforms, share):  # type: ignore[no-untyped-def]
    """Return how many draws a share of Delta reaches."""
    threshold, count = np.float32(share), np.int32(0)
    for j in range(uniforms.shape[0]):
        count += np.int32(uniforms[j] <= threshold)
    return count


@numba.njit(cache=True)
def _act_on_spikes(  # type: ignore[no-untyped-def]
    q_desired, dq_desired, q, dq, gravity, stiffness, damping, torque, constants, tally, encoded, spikes, uniforms, tick
):
    """Encode with the draws of one tick of the block, then integrate."""
    tally[CALLS] += 1
    for signal in range(2):
        for i in range(q.shape[0]):
            error = q_desired[i] - q[i] if signal == 0 else dq_desired[i] - dq[i]
            fired = (
                0 if error == 0.0 else _count_fired(uniforms[tick, signal, i], abs(error) / constants[WIDTH + signal])
            )
            tally[SPIKES] += fired
            spikes[signal, i] = fired if error > 0.0 else -fired
            encoded[signal, i] = spikes[signal, i] * constants[WORTH + signal]
    _integrate(gravity, stiffness, damping, torque, constants, encoded)


@numba.njit(cache=True)
def _act_on_means(  # type: ignore[no-untyped-def]
    q_desired, dq_desired, q, dq, gravity, stiffness, damping, torque, constants, tally, encoded
):
    """Encode the mean spike sum, then integrate."""
    tally[CALLS] += 1
    for signal in range(2):
        for i in range(q.shape[0]):
            error = q_desired[i] - q[i] if signal == 0 else dq_desired[i] - dq[i]
            share = min(max(error / constants[WIDTH + signal], -1.0), 1.0)
            encoded[signal, i] = share * constants[HALF] * constants[WORTH + signal]
    _integrate(gravity, stiffness, damping, torque, constants, encoded)
