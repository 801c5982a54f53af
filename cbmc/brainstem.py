"""The brainstem: chooses each joint's feedback gains from where the arm is and where it should be.

Source: the paper's section "Brainstem module", its table of training and neuron parameters, and its algorithm.
"""

from dataclasses import dataclass, field

import numba
import numpy as np

from ..controllers.kernels import bind
from . import online_kernels as net
from .neuron import Lif
from .online_network import Descent, OnlineNetwork
from .pathways import Ascending, Descending

LOW, HIGH = 0, 1


@dataclass(frozen=True, kw_only=True)
class BrainstemTable:
    """The paper's table "Training and neuron parameters of the brainstem module".

    Attributes:
        hidden_neurons: Neurons of the hidden layer.
        hidden: Its LIF neurons.
        output: The non-spiking output neurons; their reset is the gains' value at birth, 200 and 20.
        window: Steps of a window, T.
        surrogate_slope: nu.
        stiffness_scale: a, in k_p = a u [N m/rad].
        damping_scale: b, in k_v = b u [N m s/rad].
        descent: Learning rate and momentum.
    """

    hidden_neurons: int = 10
    hidden: Lif = field(default=Lif(u_reset=0.0, u_fire=0.005, tau_mb=5.0))
    output: Lif = field(default=Lif(u_reset=10.0, tau_mb=5.0))
    window: int = 15
    surrogate_slope: float = 5.0
    stiffness_scale: float = 20.0
    damping_scale: float = 2.0
    descent: Descent = field(default=Descent(learning_rate=0.01, momentum=0.5))


class Brainstem:
    """Four signals of each joint in, hidden spikes, two gains for each joint out.

    Attributes:
        network: The network; its ``potentials``, ``parameters``, ``hidden_spikes``, ``tally``.
        stiffness_range: Least and largest k_p of each joint, shape (2, n) [N m/rad]; infinite (the paper prints none)
            until the caller fills it in place.
        damping_range: Least and largest k_v of each joint, shape (2, n) [N m s/rad]; likewise.
        clamped: Calls in which a gain was out of range, shape (2, 2, n), int64: first k_p then k_v, low then high.
    """

    def __init__(self, joints: int, table: BrainstemTable, rng: np.random.Generator, *, biases: bool = True) -> None:
        """Draw a network.

        Args:
            joints: Number of joints, n.
            table: The paper's parameters, ``BrainstemTable()``; other values are not the paper's.
            rng: Draws weights and biases.
            biases: Whether the layers have biases.
        """
        self.joints, self.table = joints, table
        self.network = OnlineNetwork(
            layers=(4 * joints, table.hidden_neurons, 2 * joints),
            hidden=table.hidden,
            output=table.output,
            window=table.window,
            surrogate_slope=table.surrogate_slope,
            descent=table.descent,
            biases=biases,
        )
        self.network.initialise(rng)
        self._ranges = np.empty((2, 2, joints))
        self._ranges[:, LOW], self._ranges[:, HIGH] = -np.inf, np.inf
        self.stiffness_range, self.damping_range = self._ranges
        self.clamped = np.zeros((2, 2, joints), dtype=np.int64)
        self._scale = np.array([table.stiffness_scale, table.damping_scale])
        self._side = np.zeros((2, joints), dtype=np.int64)
        self._gradient = np.zeros(2 * joints)

    def connect(self, ascending: Ascending, descending: Descending) -> None:
        """Join the pathways; their arrays are the module's inputs and outputs from now on."""
        signals = (ascending.q_desired, ascending.dq_desired, ascending.q, ascending.dq)
        limits = (self._ranges, self._scale, self._side)
        gains = (descending.stiffness, descending.damping)
        self._gains = bind(_regulate, *signals, *limits, self.clamped, *gains, *self.network.state)
        self._learn = bind(_learn, self._gradient, self._scale, self._side, *self.network.state)

    def gains(self) -> None:
        r"""Fill ``descending.stiffness`` and ``descending.damping``: one window, raw inputs in rad and rad/s.

        .. math:: k_{p,i} = a\, u_{\text{bs},i}, \qquad k_{v,i} = b\, u_{\text{bs},n+i}

        A gain out of range takes the nearer end and is counted.
        """
        self._gains()

    def learn(self, gain_gradient: np.ndarray) -> None:
        """Update the network; what would push a clamped gain further out is left out.

        Args:
            gain_gradient: dL/dK, k_p of all joints before k_v, shape (2n,) [rad/(N m)] and [rad/(N m s)].
        """
        self._gradient[:] = gain_gradient
        self._learn()


@numba.njit(cache=True)
def _regulate(  # type: ignore[no-untyped-def]
    q_desired, dq_desired, q, dq, ranges, scale, side, clamped, stiffness, damping, memory, at, constants, tally
):
    """Network, scaling and clamp."""
    n, x = q.shape[0], at[net.X]
    for i in range(n):
        memory[x + i] = q_desired[i]
        memory[x + n + i] = dq_desired[i]
        memory[x + 2 * n + i] = q[i]
        memory[x + 3 * n + i] = dq[i]
    net.forward(memory, at, constants, tally)
    for gain in range(2):
        for i in range(n):
            value = scale[gain] * memory[at[net.U] + gain * n + i]
            side[gain, i] = 0
            if value < ranges[gain, LOW, i]:
                value, side[gain, i] = ranges[gain, LOW, i], -1
                clamped[gain, LOW, i] += 1
            elif value > ranges[gain, HIGH, i]:
                value, side[gain, i] = ranges[gain, HIGH, i], 1
                clamped[gain, HIGH, i] += 1
            if gain == 0:
                stiffness[i] = value
            else:
                damping[i] = value


@numba.njit(cache=True)
def _learn(gradient, scale, side, memory, at, constants, tally):  # type: ignore[no-untyped-def]
    """Scaling backwards, then the network's update; descent moves a gain against its gradient."""
    n = side.shape[1]
    for gain in range(2):
        for i in range(n):
            outward = -gradient[gain * n + i] * side[gain, i] > 0.0
            memory[at[net.OUTPUT_GRADIENT] + gain * n + i] = 0.0 if outward else scale[gain] * gradient[gain * n + i]
    net.update(memory, at, constants, tally)
