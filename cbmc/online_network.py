"""The two-layer spiking network that thalamus and brainstem share: it answers, takes a gradient, and learns at once."""

from dataclasses import dataclass

import numpy as np

from ..controllers.kernels import bind
from . import online_kernels as kernels
from .neuron import Lif


@dataclass(frozen=True, slots=True, kw_only=True)
class Descent:
    """Stochastic gradient descent as the paper's tables print it, by torch's convention.

    Attributes:
        learning_rate: Step along the momentum.
        momentum: Share of the last momentum that stays.
        weight_decay: Share of a parameter, biases included, that joins its gradient before the momentum.
    """

    learning_rate: float = 0.01
    momentum: float = 0.5
    weight_decay: float = 0.0


class OnlineNetwork:
    """Linear, spiking, linear, non-spiking; constant input for a window; reset before every window.

    Inputs to hidden LIF neurons to non-spiking LIF neurons, fully connected. The answer is the output neurons' last
    potential. The loss is the caller's: the network takes dL/du. Everything lives in one vector, ``memory``, whose
    first part is ``parameters``; the attributes below are views of it, refilled in place.

    Attributes:
        parameters: Hidden weights, hidden biases, output weights, output biases, flat, shape (m,).
        momenta: Shape (m,).
        gradient: Of the last backward pass, the decay included after an update, shape (m,).
        hidden_weights: Shape (hidden, inputs).
        hidden_biases: Shape (hidden,).
        output_weights: Shape (outputs, hidden).
        output_biases: Shape (outputs,).
        inputs: Input of the last window, shape (inputs,).
        potentials: Output of the last window, shape (outputs,).
        output_gradient: dL/du of the last backward pass, shape (outputs,).
        hidden_spikes: Spikes of each hidden neuron in the last window, shape (hidden,), int64.
        tally: Calls, updates, skipped updates, spikes, pairs of spikes in consecutive steps; cumulative, int64.
    """

    def __init__(
        self,
        *,
        layers: tuple[int, int, int],
        hidden: Lif,
        output: Lif,
        window: int,
        surrogate_slope: float,
        descent: Descent,
        biases: bool = True,
    ) -> None:
        """Lay out a network with all parameters zero.

        Args:
            layers: Numbers of inputs, hidden neurons and outputs.
            hidden: The hidden layer's neurons.
            output: The output layer's neurons, non-spiking.
            window: Steps of a window, T.
            surrogate_slope: The surrogate's nu.
            descent: How it learns.
            biases: Whether the layers have biases; off, they stay zero.
        """
        self.layers, self.window, self.biases = layers, window, biases
        self.hidden, self.output, self.surrogate_slope, self.descent = hidden, output, surrogate_slope, descent
        leak = output.leak(window)
        head = [hidden.tau_mb, hidden.u_reset, hidden.u_fire, surrogate_slope, output.u_reset]
        rule = [descent.learning_rate, descent.momentum, descent.weight_decay, float(biases)]
        self.places = kernels.places(*layers, window)
        self.memory = np.zeros(self.places[kernels.END])
        self.constants = np.array([*head, *rule, leak.sum(), *leak])
        self._tally = np.zeros(kernels.LAST + layers[1], dtype=np.int64)
        self._name_views()
        self._forward = bind(kernels.forward, *self.state)
        self._backward = bind(kernels.backward, *self.state[:3])
        self._update = bind(kernels.update, *self.state)

    @property
    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What a kernel that contains the network takes: memory, places, constants, counters."""
        return self.memory, self.places, self.constants, self._tally

    @property
    def skipped(self) -> int:
        """Updates left out because they would not have ended in finite numbers."""
        return int(self._tally[kernels.SKIPPED])

    def initialise(self, rng: np.random.Generator) -> None:
        """Draw weights and biases uniformly within 1/sqrt(inputs of the layer), torch's default; clear the momenta."""
        for weights, biases in (
            (self.hidden_weights, self.hidden_biases),
            (self.output_weights, self.output_biases),
        ):
            bound = 1.0 / np.sqrt(weights.shape[1])
            weights[:] = rng.uniform(-bound, bound, weights.shape)
            biases[:] = rng.uniform(-bound, bound, biases.shape) * self.biases
        self.momenta[:] = 0.0

    def forward(self, x: np.ndarray) -> np.ndarray:
        """Return the potentials for a constant input, shape (outputs,); a view, valid until the next call."""
        self.inputs[:] = x
        self._forward()
        return self.potentials

    def backward(self, gradient: np.ndarray) -> np.ndarray:
        """Return the parameters' gradient for dL/du of the last window, shape (m,); a view."""
        self.output_gradient[:] = gradient
        self._backward()
        return self.gradient

    def update(self, gradient: np.ndarray) -> None:
        """Learn from dL/du of the last window, shape (outputs,)."""
        self.output_gradient[:] = gradient
        self._update()

    def _name_views(self) -> None:
        """Name the blocks of the memory."""
        inputs, hidden, outputs = self.layers
        blocks = np.split(self.memory, self.places[kernels.B1 : kernels.END])
        self.hidden_weights = blocks[0].reshape(hidden, inputs)
        self.hidden_biases, self.output_biases = blocks[1], blocks[3]
        self.output_weights = blocks[2].reshape(outputs, hidden)
        self.parameters = self.memory[: self.places[kernels.MOMENTA]]
        self.momenta, self.gradient, self.inputs, self.potentials, self.output_gradient = blocks[4:9]
        self.tally, self.hidden_spikes = self._tally[: kernels.LAST], self._tally[kernels.LAST :]
