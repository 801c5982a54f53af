"""Plain NumPy forms of the compiled networks: to read, and to hold the kernels against. Slow, and no part of a run."""

from dataclasses import dataclass

import numpy as np

from .cerebellum import CerebellumTable
from .neuron import Lif, Window, run_window, window_gradient
from .online_network import Descent
from .patterns import Patterns


@dataclass(frozen=True, slots=True)
class CerebellumAnswer:
    """What all patterns said in one window.

    Attributes:
        torque: Shape (P, n) [N m].
        granule: GC spikes, shape (P, T, GC).
        purkinje: PC spikes, shape (P, T, PC).
    """

    torque: np.ndarray
    granule: np.ndarray
    purkinje: np.ndarray


def compensate(patterns: Patterns, table: CerebellumTable, q: np.ndarray) -> CerebellumAnswer:
    """Run every pattern at one posture in double precision.

    Args:
        patterns: Trained patterns.
        table: Neurons and window.
        q: Joint angles, shape (n,) [rad].
    """
    leak, pc = table.nuclei.leak(table.window), patterns.purkinje_bias.shape[1]
    torque, granule, purkinje = [], [], []
    for p in range(patterns.count):
        current = patterns.granule[p].astype(float) @ q + patterns.granule_bias[p]
        gc = run_window(np.broadcast_to(current, (table.window, current.size)), table.granule).spikes
        now, following = np.split(gc @ patterns.purkinje[p].astype(float), [pc], axis=1)
        now[1:] += following[:-1]
        fired = run_window(now + patterns.purkinje_bias[p], table.purkinje).spikes
        torque.append(patterns.readout[p].astype(float) @ (leak @ fired) + patterns.readout_bias[p])
        granule.append(gc)
        purkinje.append(fired)
    return CerebellumAnswer(np.array(torque), np.array(granule), np.array(purkinje))


@dataclass(kw_only=True)
class TwoLayers:
    """The two-layer network of thalamus and brainstem, layer by layer and step by step.

    Attributes:
        parameters: Hidden weights and biases, output weights and biases.
        hidden: The hidden layer's neurons.
        output: The output layer's neurons.
        window: Steps of a window, T.
        surrogate_slope: nu.
    """

    parameters: list[np.ndarray]
    hidden: Lif
    output: Lif
    window: int
    surrogate_slope: float

    def forward(self, x: np.ndarray) -> np.ndarray:
        """Return the output neurons' last potentials for a constant input, shape (outputs,)."""
        hidden_weights, hidden_biases, output_weights, output_biases = self.parameters
        current = hidden_weights @ x + hidden_biases
        self._x = x
        self._hidden_run: Window = run_window(np.broadcast_to(current, (self.window, current.size)), self.hidden)
        self._output_run: Window = run_window(self._hidden_run.spikes @ output_weights.T + output_biases, self.output)
        return self._output_run.potential

    @property
    def hidden_spikes(self) -> np.ndarray:
        """Spikes of each hidden neuron in the last window, shape (hidden,)."""
        return np.asarray(self._hidden_run.spikes.sum(axis=0))

    def backward(self, gradient: np.ndarray) -> list[np.ndarray]:
        """Return the gradient of each parameter for dL/du of the last window, shape (outputs,)."""
        quiet = np.zeros_like(self._output_run.spikes)
        at_output = window_gradient(self._output_run, self.output, self.surrogate_slope, quiet, gradient)
        at_spikes = at_output @ self.parameters[2]
        at_hidden = window_gradient(self._hidden_run, self.hidden, self.surrogate_slope, at_spikes).sum(axis=0)
        outputs = at_output.T @ self._hidden_run.spikes
        return [np.outer(at_hidden, self._x), at_hidden, outputs, at_output.sum(axis=0)]


def descend(
    parameters: list[np.ndarray], momenta: list[np.ndarray], gradients: list[np.ndarray], descent: Descent
) -> None:
    """Take one step of stochastic gradient descent in place."""
    for parameter, momentum, gradient in zip(parameters, momenta, gradients, strict=True):
        momentum *= descent.momentum
        momentum += gradient + descent.weight_decay * parameter
        parameter -= descent.learning_rate * momentum
