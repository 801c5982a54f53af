r"""The leaky integrate-and-fire neuron of every network here, with the exact gradient through its window.

The paper's equation (lif), discretised at one step with the synapse left out (no table gives its time constant):

.. math::
    h_t = u_{t-1} + (I_t - (u_{t-1} - u_\text{reset})) / \tau_\text{mb}, \qquad
    s_t = \Theta(h_t - u_\text{fire}), \qquad
    u_t = (1 - s_t) h_t + s_t u_\text{reset}, \qquad u_0 = u_\text{reset}

in this order: charge, fire, reset. The paper lists firing first, which would only waste the first step of a window.
The non-spiking neuron has an infinite threshold, so its answer is the potential. This is SpikingJelly's ``LIFNode``
with ``decay_input=True``. The functions below are the plain NumPy form; the modules run compiled ones.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Lif:
    """Parameters of a layer of neurons, by the paper's names.

    Attributes:
        u_reset: Potential at the start of a window and after a spike.
        u_fire: Threshold; infinite for a non-spiking neuron.
        tau_mb: Membrane time constant [steps].
    """

    u_reset: float = 0.0
    u_fire: float = math.inf
    tau_mb: float

    def leak(self, steps: int) -> np.ndarray:
        r"""Return what a current at each step leaves in the last potential of a non-spiking neuron, shape (steps,).

        .. math:: u_T = u_\text{reset} + \sum_t c_t I_t, \qquad c_t = (1 - 1/\tau_\text{mb})^{T-t} / \tau_\text{mb}
        """
        return (1.0 - 1.0 / self.tau_mb) ** np.arange(steps - 1, -1, -1.0) / self.tau_mb


@dataclass(frozen=True, slots=True)
class Window:
    """What a layer did in one window of T steps; leading axis is time.

    Attributes:
        charged: Potentials before the reset, h, shape (T, ...).
        spikes: 0 or 1, shape (T, ...).
        potential: Potentials after the last step, u_T, shape (...).
    """

    charged: np.ndarray
    spikes: np.ndarray
    potential: np.ndarray


def run_window(currents: np.ndarray, lif: Lif) -> Window:
    """Let a layer that starts at rest answer to a window of currents.

    Args:
        currents: Shape (T, ...); for a constant one ``np.broadcast_to(current, (T, *current.shape))``.
        lif: The layer's neurons.
    """
    potential = np.full(currents.shape[1:], lif.u_reset)
    charged, spikes = np.empty(currents.shape), np.empty(currents.shape)
    for step, current in enumerate(currents):
        charged[step] = potential + (current - (potential - lif.u_reset)) / lif.tau_mb
        spikes[step] = charged[step] >= lif.u_fire
        potential = (1.0 - spikes[step]) * charged[step] + spikes[step] * lif.u_reset
    return Window(charged, spikes, potential)


def window_gradient(
    window: Window, lif: Lif, slope: float, spike_gradient: np.ndarray, potential_gradient: np.ndarray | float = 0.0
) -> np.ndarray:
    """Propagate a loss back through a window, through the resets too (nothing is detached).

    Args:
        window: What :func:`run_window` returned.
        lif: The layer's neurons.
        slope: The surrogate's nu.
        spike_gradient: dL/ds, shape (T, ...).
        potential_gradient: dL/du_T, shape (...).

    Returns:
        dL/dI, shape (T, ...).
    """
    carried = np.zeros(window.potential.shape) + potential_gradient
    derivative = surrogate_derivative(window.charged - lif.u_fire, slope)
    gradient = np.empty(window.charged.shape)
    for step in range(len(gradient) - 1, -1, -1):
        through_spike = spike_gradient[step] + carried * (lif.u_reset - window.charged[step])
        through_charge = through_spike * derivative[step] + carried * (1.0 - window.spikes[step])
        gradient[step] = through_charge / lif.tau_mb
        carried = through_charge * (1.0 - 1.0 / lif.tau_mb)
    return gradient


def surrogate_derivative(margin: np.ndarray, slope: float) -> np.ndarray:
    r"""Return the derivative of the paper's :math:`\sigma(x) = 1 / (1 + e^{-\nu x})`, used in place of a step's.

    Args:
        margin: Potential above the threshold, h - u_fire, any shape; minus infinity for a non-spiking neuron.
        slope: The surrogate's nu.
    """
    decay = np.exp(-np.abs(slope * margin))  # even in x, so that neither end overflows
    return np.asarray(slope * decay / (1.0 + decay) ** 2)
