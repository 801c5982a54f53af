r"""What the error tells the second level: the upstream gradients of thalamus and brainstem.

The paper prints losses that are linear in the signed error, :math:`\sum_i 100 (q_{d,i} - q_i) + \sum_i 10^{-4}
(\dot q_{d,i} - \dot q_i)`, for the brainstem with :math:`\sum_i 10^{-3} \tau_i^2`. Differentiated as printed their
gradient does not depend on the error, and the measured q has no graph to the weights. :class:`FeedbackError` reads
them as feedback-error learning: the weighted error itself is the gradient at q, and one constant stands for the
sensitivity of q to torque. The printed forms are :class:`ConstantGradient` and :class:`TorquePenalty`.
"""

from dataclasses import dataclass
from typing import Protocol

import numba
import numpy as np

from ..controllers.kernels import bind
from .pathways import Ascending, Descending


@dataclass(frozen=True, kw_only=True)
class LossWeights:
    """Weights of the printed losses: position error, velocity error, squared torque."""

    position: float = 100.0
    velocity: float = 1e-4
    torque: float = 1e-3


@dataclass(frozen=True, kw_only=True)
class Chain:
    """Membranes between the second level's output and the torque, detached in time.

    Attributes:
        spinal: One over the spinal output neuron's membrane constant.
        filter: One over the filter layer's membrane constant.
    """

    spinal: float = 0.5
    filter: float = 0.2


@dataclass(slots=True)
class Gradients:
    """What a rule fills every second-level call.

    Attributes:
        weights: dL/dw, shape (patterns,).
        gains: dL/dK_P before dL/dK_V, shape (2 n,).
        losses: The printed losses of thalamus and brainstem, for the record, shape (2,).
    """

    weights: np.ndarray
    gains: np.ndarray
    losses: np.ndarray


class Rule(Protocol):
    """Turns errors into upstream gradients."""

    def connect(
        self, ascending: Ascending, descending: Descending, encoded: tuple[np.ndarray, np.ndarray], gradients: Gradients
    ) -> None:
        """Fix the arrays that the rule reads and fills.

        Args:
            ascending: Errors come from here.
            descending: Compensation and torque come from here.
            encoded: Decoded position and velocity error of the spinal encoder, shape (n,) each [rad, rad/s].
            gradients: Is filled.
        """
        ...

    def evaluate(self) -> None:
        """Fill the gradients from what the arrays hold now."""
        ...


@dataclass(kw_only=True)
class FeedbackError:
    r"""Feedback-error learning with one sensitivity.

    .. math::
        h_i &= -\sigma (c_q e_i + c_v \dot e_i) \\
        \partial L / \partial w_p &= \frac{1}{\tau_{sp} \tau_{ft}} \sum_i h_i \, T_{cb,pi} \\
        \partial L / \partial k_{p,i} &= \frac{1}{\tau_{sp}} (h_i + 2 \sigma c_\tau \tau_i) \, s_{q,i}

    Attributes:
        sensitivity: sigma, of joint position to torque [rad/(N m)].
        loss: Weights of the printed losses.
        chain: Membranes on the way to the torque.
    """

    sensitivity: float = 0.2
    loss: LossWeights = LossWeights()
    chain: Chain = Chain()

    def connect(
        self, ascending: Ascending, descending: Descending, encoded: tuple[np.ndarray, np.ndarray], gradients: Gradients
    ) -> None:
        """Bind the rule to the pathways; see :class:`Rule`."""
        constants = (
            np.array([self.sensitivity, self.chain.spinal, self.chain.filter]),
            np.array([self.loss.position, self.loss.velocity, self.loss.torque]),
        )
        plan = (ascending.q_desired, ascending.dq_desired, ascending.q, ascending.dq)
        down = (descending.compensation, descending.torque)
        filled = (gradients.weights, gradients.gains, gradients.losses)
        self._kernel = bind(_feedback_error, constants, plan, down, encoded, filled)

    def evaluate(self) -> None:
        """Fill the gradients from what the arrays hold now."""
        self._kernel()


@numba.njit(cache=True)
def _feedback_error(constants, plan, down, encoded, filled):  # type: ignore[no-untyped-def]
    """Fill gradients and printed losses."""
    sensitivity, spinal, leak = constants[0]
    c_q, c_v, c_tau = constants[1]
    q_desired, dq_desired, q, dq = plan
    compensation, torque = down
    encoded_q, encoded_dq = encoded
    weights, gains, losses = filled
    n = q.shape[0]
    weights[:] = 0.0
    losses[:] = 0.0
    for i in range(n):
        error, error_rate = q_desired[i] - q[i], dq_desired[i] - dq[i]
        weighted = c_q * error + c_v * error_rate
        upstream = -sensitivity * weighted
        for p in range(weights.shape[0]):
            weights[p] += spinal * leak * upstream * compensation[p, i]
        at_torque = upstream + 2.0 * sensitivity * c_tau * torque[i]
        gains[i] = spinal * at_torque * encoded_q[i]
        gains[n + i] = spinal * at_torque * encoded_dq[i]
        losses[0] += weighted
        losses[1] += weighted + c_tau * torque[i] * torque[i]


@dataclass(kw_only=True)
class ConstantGradient:
    """The printed losses differentiated as printed, with a sensitivity in place of the missing graph.

    Attributes:
        sensitivity: Of joint position to torque [rad/(N m)].
        loss: Weights of the printed losses.
        chain: Membranes on the way to the torque.
    """

    sensitivity: float = 1.0
    loss: LossWeights = LossWeights()
    chain: Chain = Chain()

    def connect(
        self, ascending: Ascending, descending: Descending, encoded: tuple[np.ndarray, np.ndarray], gradients: Gradients
    ) -> None:
        """Keep the pathways; see :class:`Rule`."""
        self._up, self._down, self._encoded, self._gradients = ascending, descending, encoded, gradients

    def evaluate(self) -> None:
        """Fill the gradients: the error's size and sign do not enter."""
        constant = -self.sensitivity * (self.loss.position + self.loss.velocity)
        self._gradients.weights[:] = (
            self.chain.spinal * self.chain.filter * constant * self._down.compensation.sum(axis=1)
        )
        at_torque = constant + 2.0 * self.sensitivity * self.loss.torque * self._down.torque
        _fill_gains(self._gradients, self.chain.spinal * at_torque, self._encoded)
        _fill_losses(self._gradients, self.loss, self._up, self._down)


@dataclass(kw_only=True)
class TorquePenalty:
    """What automatic differentiation leaves of the printed losses: only the torque term has a graph to the gains.

    Attributes:
        loss: Weights of the printed losses.
        chain: Membranes on the way to the torque.
    """

    loss: LossWeights = LossWeights()
    chain: Chain = Chain()

    def connect(
        self, ascending: Ascending, descending: Descending, encoded: tuple[np.ndarray, np.ndarray], gradients: Gradients
    ) -> None:
        """Keep the pathways; see :class:`Rule`."""
        self._up, self._down, self._encoded, self._gradients = ascending, descending, encoded, gradients

    def evaluate(self) -> None:
        """Fill the gradients: the thalamus gets none."""
        self._gradients.weights[:] = 0.0
        at_torque = 2.0 * self.loss.torque * self._down.torque
        _fill_gains(self._gradients, self.chain.spinal * at_torque, self._encoded)
        _fill_losses(self._gradients, self.loss, self._up, self._down)


def _fill_gains(gradients: Gradients, at_torque: np.ndarray, encoded: tuple[np.ndarray, np.ndarray]) -> None:
    n = at_torque.shape[0]
    np.multiply(at_torque, encoded[0], out=gradients.gains[:n])
    np.multiply(at_torque, encoded[1], out=gradients.gains[n:])


def _fill_losses(gradients: Gradients, loss: LossWeights, up: Ascending, down: Descending) -> None:
    """Fill the printed losses, for the record."""
    position, velocity = np.sum(up.q_desired - up.q), np.sum(up.dq_desired - up.dq)
    gradients.losses[0] = loss.position * position + loss.velocity * velocity
    gradients.losses[1] = gradients.losses[0] + loss.torque * np.sum(down.torque**2)
