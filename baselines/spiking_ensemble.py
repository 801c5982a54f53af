"""A population of leaky integrate-and-fire neurons that learns a function online by the PES rule."""

from collections.abc import Callable

import numba
import numpy as np

from ..controllers.kernels import bind

MEMBRANE, REFRACTORY, SYNAPSE = 0.02, 0.002, 0.02
"""Time constants of membrane, refractory period and synapse [s]."""

SLOWEST, FASTEST = 50.0, 150.0
"""Range of the rates at which neurons fire at the rim of the unit ball [Hz]."""

HIGHEST_INTERCEPT = 0.9
"""Neurons that begin to fire nearer to the rim than this would need a gain without bound."""

SILENT = 1e-3
"""Below this filtered rate a neuron neither speaks nor learns: it has not fired for 0.2 s [Hz]."""

SPIKES, UPDATES, DECODES, TICKS = range(4)
"""Entries of the tally."""


class SpikingEnsemble:
    r"""n neurons with random preferred directions; decoders learn from an error, weight by weight, on the spot.

    .. math:: J_i = \alpha_i \langle x, e_i \rangle + b_i, \quad \tau_m \dot v_i = J_i - v_i, \quad u = D a,
        \quad \Delta D = \frac{\kappa h}{n} \epsilon a^T

    a are the spikes behind an exponential synapse [Hz]. Tuning curves are drawn by their maximal rates and intercepts.
    Source: MacNeil, Eliasmith, Fine-tuning and the stability of recurrent neural networks, PLoS ONE 6 (2011)
    (prescribed error sensitivity); Eliasmith, Anderson, Neural Engineering (2003) (tuning curves).

    Attributes:
        stimulus: x, shape (inputs,), written by the caller before :meth:`tick`.
        error: epsilon, shape (outputs,), written by the caller.
        output: u, shape (outputs,), in the unit of epsilon.
        decoders: D transposed, shape (neurons, outputs).
        tally: Spikes, decoder updates, decoding products, ticks; cumulative, int64.
    """

    def __init__(
        self, neurons: int, inputs: int, outputs: int, *, rate: float, period: float, rng: np.random.Generator
    ) -> None:
        """Draw the tuning curves.

        Args:
            neurons: Number of neurons.
            inputs: Dimension of x.
            outputs: Dimension of u.
            rate: Learning rate kappa [1/(s Hz^2)].
            period: Time between two ticks [s].
            rng: Where the draws come from.
        """
        directions = rng.standard_normal((neurons, inputs))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        gain, bias = tuning(rng.uniform(SLOWEST, FASTEST, neurons), rng.uniform(-1.0, HIGHEST_INTERCEPT, neurons))
        # Inputs come first, so that the sum over them runs along the neurons in memory.
        self.encoders, self.bias = np.ascontiguousarray((directions * gain[:, None]).T), bias
        self.stimulus, self.error, self.output = np.zeros(inputs), np.zeros(outputs), np.zeros(outputs)
        self.decoders, self.activity = np.zeros((neurons, outputs)), np.zeros(neurons)
        self._potential, self._rest = rng.uniform(0.0, 1.0, neurons), np.zeros(neurons)
        self.tally = np.zeros(4, dtype=np.int64)
        synapse = -np.expm1(-period / SYNAPSE)
        constants = np.array([period, -np.expm1(-period / MEMBRANE), synapse, rate * period / neurons])
        signals = self.stimulus, self.error, self.output
        state = self._potential, self._rest, self.activity, np.zeros(neurons)
        weights = self.encoders, self.bias, self.decoders
        self.tick: Callable[[], None] = bind(tick, signals, weights, state, constants, self.tally)


def tuning(fastest: np.ndarray, intercept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""Return gain and bias of neurons from where they begin to fire and how fast they fire at the rim.

    .. math:: r(J) = \frac{1}{\tau_r - \tau_m \ln(1 - 1/J)}, \quad r(\alpha + b) = r_{max},
        \quad \alpha c + b = 1

    Args:
        fastest: Rate at the rim of the unit ball in the preferred direction, shape (n,) [Hz].
        intercept: Projection c at which firing begins, shape (n,).

    Returns:
        alpha and b, shapes (n,).
    """
    current = -1.0 / np.expm1((REFRACTORY - 1.0 / fastest) / MEMBRANE)
    gain = (current - 1.0) / (1.0 - intercept)
    return gain, 1.0 - gain * intercept


@numba.njit(cache=True)
def tick(signals, weights, state, constants, tally):  # type: ignore[no-untyped-def]
    """Show the neurons the stimulus, decode with the decoders of the last tick, then let these learn from the error.

    Args:
        signals: Stimulus, error, output.
        weights: Encoders times gains, shape (inputs, n), biases, decoders, shape (n, outputs).
        state: Potentials, refractory time left [s], filtered rates [Hz] and a scratch for currents, shapes (n,).
        constants: Period [s], leak of a whole tick, share of the synapse, learning rate times period over n.
        tally: Counters, changed in place.
    """
    stimulus, error, output = signals
    encoders, bias, decoders = weights
    potential, rest, activity, current = state
    period, leak, synapse, rate = constants[0], constants[1], constants[2], constants[3]
    n, outputs = bias.shape[0], output.shape[0]
    for i in range(n):
        current[i] = bias[i]
    for d in range(stimulus.shape[0]):
        x = stimulus[d]
        for i in range(n):
            current[i] += x * encoders[d, i]
    fired, heard = 0, 0
    for j in range(outputs):
        output[j] = 0.0
    for i in range(n):
        spike = _fire(current[i], potential, rest, i, period, leak)
        fired += spike
        activity[i] += synapse * (spike / period - activity[i])
        if activity[i] > SILENT:
            heard += 1
            for j in range(outputs):
                output[j] += decoders[i, j] * activity[i]
                decoders[i, j] += rate * error[j] * activity[i]
    tally[SPIKES] += fired
    tally[UPDATES] += heard * outputs
    tally[DECODES] += heard * outputs
    tally[TICKS] += 1


@numba.njit(cache=True)
def _fire(current, potential, rest, i, period, leak):  # type: ignore[no-untyped-def]
    """Advance one membrane by a tick and return whether it fired; the instant of a spike is exact."""
    waited = rest[i]
    rest[i] = max(waited - period, 0.0)
    share = leak
    if waited > 0.0:
        if waited >= period:
            return 0
        share = -np.expm1(-(period - waited) / MEMBRANE)
    v = potential[i] + (current - potential[i]) * share
    if v <= 1.0:
        potential[i] = max(v, 0.0)
        return 0
    # The membrane crossed 1 within the tick, and rests from then on.
    since = -MEMBRANE * np.log1p(-(v - 1.0) / (current - 1.0))
    potential[i] = 0.0
    rest[i] = max(REFRACTORY - since, 0.0)
    return 1
