"""The thalamus: weighs the cerebellum's patterns by what the hand feels, and filters their mixture.

Source: the paper's section "Thalamus module", its table of training and neuron parameters, and its algorithm.
"""

import math
from dataclasses import dataclass, field

import numba
import numpy as np

from ..controllers.kernels import bind
from . import online_kernels as net
from .neuron import Lif
from .online_network import Descent, OnlineNetwork
from .pathways import Ascending, Descending


@dataclass(frozen=True, kw_only=True)
class ThalamusTable:
    """The paper's table "Training and neuron parameters of the thalamus module".

    Attributes:
        hidden_neurons: Neurons of the hidden layer.
        hidden: Its LIF neurons.
        output: The non-spiking neurons before the softmax; their reset cancels in it, and is kept as printed.
        filter: The non-spiking neurons of the filter layer, one for each joint, one step per call.
        window: Steps of a window, T.
        surrogate_slope: nu.
        descent: Learning rate, momentum, weight decay.
    """

    hidden_neurons: int = 5
    hidden: Lif = field(default=Lif(u_reset=0.0, u_fire=0.01, tau_mb=5.0))
    output: Lif = field(default=Lif(u_reset=10.0, tau_mb=5.0))
    filter: Lif = field(default=Lif(u_reset=0.0, tau_mb=5.0))
    window: int = 10
    surrogate_slope: float = 5.0
    descent: Descent = field(default=Descent(learning_rate=0.01, momentum=0.5, weight_decay=0.001))


class Thalamus:
    """Six inputs, hidden spikes, one potential for each pattern, softmax, then a filter layer that keeps its state.

    Attributes:
        network: The network; its ``potentials`` before the softmax, ``parameters``, ``hidden_spikes``, ``tally``.
        mixtures: Calls of :meth:`combine`, shape (1,), int64.
    """

    def __init__(
        self,
        joints: int,
        patterns: int,
        table: ThalamusTable,
        rng: np.random.Generator,
        *,
        force_scale: tuple[float, float] = (50.0, 10.0),
        biases: bool = True,
    ) -> None:
        """Draw a network.

        Args:
            joints: Number of joints, n: neurons of the filter layer.
            patterns: Number of the cerebellum's patterns, P.
            table: The paper's parameters, ``ThalamusTable()``; other values are not the paper's.
            rng: Draws weights and biases.
            force_scale: Force [N] and torque [N m] that become an input of 1; ``(1.0, 1.0)`` leaves them raw. The
                paper names no scale; raw newtons make the learning rate of the first layer a thousand times larger.
            biases: Whether the layers have biases.
        """
        self.joints, self.patterns, self.table = joints, patterns, table
        self.network = OnlineNetwork(
            layers=(6, table.hidden_neurons, patterns),
            hidden=table.hidden,
            output=table.output,
            window=table.window,
            surrogate_slope=table.surrogate_slope,
            descent=table.descent,
            biases=biases,
        )
        self.network.initialise(rng)
        self.mixtures = np.zeros(1, dtype=np.int64)
        self._scale = 1.0 / np.repeat(np.asarray(force_scale, dtype=float), 3)
        self._gradient = np.zeros(patterns)

    def connect(self, ascending: Ascending, descending: Descending) -> None:
        """Join the pathways; their arrays are the module's inputs and outputs from now on."""
        self._descending = descending
        self._weigh = bind(_weigh, ascending.wrench, self._scale, descending.weights, *self.network.state)
        layer = np.array([self.table.filter.u_reset, self.table.filter.tau_mb])
        joined = (descending.compensation, descending.weights, descending.gravity_torque)
        self._combine = bind(_combine, *joined, layer, self.mixtures)
        self._learn = bind(_learn, self._gradient, descending.weights, *self.network.state)

    def weigh(self) -> None:
        """Turn the load on the flange into the patterns' weights: one window, softmax, ``descending.weights``."""
        self._weigh()

    def combine(self) -> None:
        r"""Take one step of the filter layer, whose potential u_ft is ``descending.gravity_torque``.

        .. math:: u_\text{ft} \leftarrow u_\text{ft} + (T_\text{cb} w - (u_\text{ft} - u_\text{reset})) / \tau_\text{mb}
        """
        self._combine()

    def settle(self) -> None:
        """Put the filter layer where it would come to rest with the present patterns and weights."""
        mixture = self._descending.weights @ self._descending.compensation
        self._descending.gravity_torque[:] = self.table.filter.u_reset + mixture

    def learn(self, weight_gradient: np.ndarray) -> None:
        """Update the network.

        Args:
            weight_gradient: dL/dw, shape (P,).
        """
        self._gradient[:] = weight_gradient
        self._learn()


@numba.njit(cache=True)
def _weigh(wrench, scale, weights, memory, at, constants, tally):  # type: ignore[no-untyped-def]
    """Network and softmax."""
    for i in range(wrench.shape[0]):
        memory[at[net.X] + i] = wrench[i] * scale[i]
    net.forward(memory, at, constants, tally)
    largest = -math.inf
    for p in range(weights.shape[0]):
        largest = max(largest, memory[at[net.U] + p])
    total = 0.0
    for p in range(weights.shape[0]):
        weights[p] = math.exp(memory[at[net.U] + p] - largest)
        total += weights[p]
    for p in range(weights.shape[0]):
        weights[p] /= total


@numba.njit(cache=True)
def _combine(compensation, weights, torque, layer, calls):  # type: ignore[no-untyped-def]
    """The paper's two equations of the filter layer: mixture in, one step, state kept."""
    calls[0] += 1
    for i in range(torque.shape[0]):
        mixture = 0.0
        for p in range(weights.shape[0]):
            mixture += weights[p] * compensation[p, i]
        torque[i] += (mixture - (torque[i] - layer[0])) / layer[1]


@numba.njit(cache=True)
def _learn(gradient, weights, memory, at, constants, tally):  # type: ignore[no-untyped-def]
    """Softmax backwards, dL/du_p = w_p (dL/dw_p - sum_r w_r dL/dw_r), then the network's update."""
    mean = 0.0
    for p in range(weights.shape[0]):
        mean += weights[p] * gradient[p]
    for p in range(weights.shape[0]):
        memory[at[net.OUTPUT_GRADIENT] + p] = weights[p] * (gradient[p] - mean)
    net.update(memory, at, constants, tally)
