r"""One pattern's network in torch, with its gradient written out: fast, and without autograd.

Charge, fire, reset at each of the window's T steps (``h`` before the reset, ``s`` spike, ``u`` after it):

.. math:: h_t = u_{t-1} + (I_t - u_{t-1}) / \tau, \quad s_t = [h_t \ge u_{fire}], \quad u_t = (1 - s_t) h_t

and backwards, with the surrogate :math:`\sigma'(x) = \nu \sigma(\nu x)(1 - \sigma(\nu x))` and the reset not detached:

.. math:: g_h = (g_s - g_u h_t)\, \sigma'(h_t - u_{fire}) + g_u (1 - s_t), \quad g_I = g_h / \tau,
    \quad g_u \leftarrow g_h (1 - 1/\tau)

GC gets a constant current, so its product is taken once a window. PC hears GC at this step and at the previous one:
one product gives both, and the second half arrives a step later. DCN does not spike, so it is linear in
:math:`z = \sum_t c_t s_t`, the PC spikes weighted by DCN's leak; its groups are folded to a row a joint.
Source: the paper's section on the cerebellum; its Table I for all constants.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from itertools import accumulate

import torch

from ..cerebellum import PAPER

GRANULE, PURKINJE, GROUP = 300, 200, PAPER.nuclei_per_joint
"""Neurons of GC and PC, and DCN neurons of each joint."""
WINDOW = PAPER.window
"""Steps T of the time window."""
TAU, THRESHOLD = PAPER.granule.tau_mb, PAPER.granule.u_fire
"""Membrane time constant of GC and PC [steps], and the potential at which they fire; both rest at 0."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Weights:
    """Parameters of one pattern's network, or their gradient: views of one vector.

    Attributes:
        granule: Shape (GC, n).
        granule_bias: Shape (GC,).
        purkinje: For each GC neuron what PC gets at the same step before what it gets a step later, (GC, 2 PC).
        purkinje_bias: Shape (PC,).
        readout: Folded DCN weights, shape (n, PC).
        readout_bias: Folded DCN offsets with the window's leak, shape (n,).
        vector: All of them, shape (count,).
    """

    granule: torch.Tensor
    granule_bias: torch.Tensor
    purkinje: torch.Tensor
    purkinje_bias: torch.Tensor
    readout: torch.Tensor
    readout_bias: torch.Tensor
    vector: torch.Tensor

    @classmethod
    def zeros(cls, joints: int, *, dtype: torch.dtype = torch.float32) -> "Weights":
        """Return parameters that are all zero.

        Args:
            joints: Number of joints n.
            dtype: Precision.
        """
        shapes = ((GRANULE, joints), (GRANULE,), (GRANULE, 2 * PURKINJE), (PURKINJE,), (joints, PURKINJE), (joints,))
        sizes = [torch.Size(shape).numel() for shape in shapes]
        vector = torch.zeros(sum(sizes), dtype=dtype)
        ends = list(accumulate(sizes))
        parts = [vector[end - size : end].view(shape) for end, size, shape in zip(ends, sizes, shapes, strict=True)]
        names = [field.name for field in fields(cls)]
        return cls(**dict(zip(names, [*parts, vector], strict=True)))

    @classmethod
    def drawn(cls, joints: int, seed: int, *, dtype: torch.dtype = torch.float32) -> "Weights":
        """Return parameters drawn as torch draws linear layers: uniform within one over the root of the inputs.

        Args:
            joints: Number of joints n.
            seed: Seed of the draws.
            dtype: Precision.
        """
        weights, generator = cls.zeros(joints, dtype=dtype), torch.Generator().manual_seed(seed)

        def draw(*shape: int, inputs: int) -> torch.Tensor:
            return (2.0 * torch.rand(shape, generator=generator, dtype=dtype) - 1.0) / math.sqrt(inputs)

        weights.granule.copy_(draw(GRANULE, joints, inputs=joints))
        weights.granule_bias.copy_(draw(GRANULE, inputs=joints))
        weights.purkinje.copy_(draw(GRANULE, 2 * PURKINJE, inputs=2 * GRANULE))
        weights.purkinje_bias.copy_(draw(PURKINJE, inputs=2 * GRANULE))
        dcn = draw(joints * GROUP, PURKINJE, inputs=PURKINJE), draw(joints * GROUP, inputs=PURKINJE)
        readout, offset = fold_dcn(*dcn)
        weights.readout.copy_(readout)
        weights.readout_bias.copy_(offset)
        return weights


def leak_weights(dtype: torch.dtype = torch.float32) -> torch.Tensor:
    r"""Return how much a step's current still counts in DCN's last potential, :math:`c_t`, shape (T,)."""
    return torch.from_numpy(PAPER.nuclei.leak(WINDOW)).to(dtype)


def fold_dcn(weight: torch.Tensor, bias: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return DCN as one row and one offset a joint: the mean of each group's last potentials.

    Args:
        weight: Weights of all DCN neurons, shape (20 n, PC).
        bias: Their biases, shape (20 n,).

    Returns:
        Readout of z, shape (n, PC), and what the biases have charged by the end of the window, shape (n,).
    """
    rows = weight.view(-1, GROUP, weight.shape[1]).mean(dim=1)
    return rows, bias.view(-1, GROUP).mean(dim=1) * float(leak_weights(torch.float64).sum())


class Network:
    """Forward and backward pass for batches of one size; every large buffer is allocated once."""

    def __init__(self, weights: Weights, *, batch: int, slope: float) -> None:
        """Take the weights, which the passes read in place.

        Args:
            weights: The parameters.
            batch: Postures of a batch.
            slope: Slope nu of the surrogate gradient.
        """
        self.weights, self.slope, dtype = weights, slope, weights.vector.dtype
        self.gradient = Weights.zeros(weights.granule.shape[1], dtype=dtype)
        self._leak = leak_weights(dtype)
        self._granule = _Layer(GRANULE, batch, dtype)
        self._purkinje = _Layer(PURKINJE, batch, dtype)
        self._current = torch.empty((WINDOW, batch, 2 * PURKINJE), dtype=dtype)
        self._spread = torch.empty((WINDOW, batch, GRANULE), dtype=dtype)

    def features(self, x: torch.Tensor) -> torch.Tensor:
        """Return the weighted PC spikes z of a batch, shape (B, PC).

        Args:
            x: Inputs, shape (B, n).
        """
        weights, current = self.weights, self._current
        constant = torch.addmm(weights.granule_bias, x, weights.granule.T)
        self._granule.run(constant for _ in range(WINDOW))
        torch.mm(_flat(self._granule.spikes), weights.purkinje, out=_flat(current))
        now, later = current[:, :, :PURKINJE], current[:, :, PURKINJE:]
        now += weights.purkinje_bias
        now[1:] += later[:-1]
        self._purkinje.run(now)
        return torch.einsum("t,tbp->bp", self._leak, self._purkinje.spikes)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return the output of a batch, shape (B, n).

        Args:
            x: Inputs, shape (B, n).
        """
        self._x, self._z = x, self.features(x)
        return torch.addmm(self.weights.readout_bias, self._z, self.weights.readout.T)

    def backward(self, slope: torch.Tensor) -> Weights:
        """Return the gradient of a loss after :meth:`forward`; one record, valid until the next call.

        Args:
            slope: Derivative of the loss by the output, shape (B, n).
        """
        weights, gradient, current = self.weights, self.gradient, self._current
        torch.mm(slope.T, self._z, out=gradient.readout)
        torch.sum(slope, dim=0, out=gradient.readout_bias)
        z = slope @ weights.readout
        self._purkinje.back((leak * z for leak in self._leak.flip(0)), self.slope, current[:, :, :PURKINJE])
        torch.sum(current[:, :, :PURKINJE], dim=(0, 1), out=gradient.purkinje_bias)
        # What a spike does a step later, it does to the current of that step; after the last step there is none.
        current[:-1, :, PURKINJE:] = current[1:, :, :PURKINJE]
        current[-1, :, PURKINJE:] = 0.0
        torch.mm(_flat(self._granule.spikes).T, _flat(current), out=gradient.purkinje)
        spread = self._spread
        torch.mm(_flat(current), weights.purkinje.T, out=_flat(spread))
        self._granule.back(spread.unbind()[::-1], self.slope, spread)
        granule = spread.sum(dim=0)
        torch.mm(granule.T, self._x, out=gradient.granule)
        torch.sum(granule, dim=0, out=gradient.granule_bias)
        return gradient


class _Layer:
    """Spiking neurons over a window: what happened, and the way back."""

    def __init__(self, neurons: int, batch: int, dtype: torch.dtype) -> None:
        self.spikes = torch.empty((WINDOW, batch, neurons), dtype=dtype)
        self._charged = torch.empty_like(self.spikes)
        self._silent = torch.empty_like(self.spikes)

    def run(self, currents: Iterable[torch.Tensor]) -> None:
        """Charge, fire and reset from rest, a step for each current."""
        u = torch.zeros_like(self.spikes[0])
        for h, s, silent, current in zip(self._charged, self.spikes, self._silent, currents, strict=True):
            torch.lerp(u, current, 1.0 / TAU, out=h)
            torch.ge(h, THRESHOLD, out=s)
            torch.sub(1.0, s, out=silent)
            torch.mul(h, silent, out=u)

    def back(self, slopes: Iterable[torch.Tensor], nu: float, out: torch.Tensor) -> None:
        """Write the derivatives by the currents, from those by the spikes, last step first."""
        surrogate = torch.sigmoid((self._charged - THRESHOLD).mul_(nu))
        surrogate.mul_(1.0 - surrogate).mul_(nu)
        gu = torch.zeros_like(self.spikes[0])
        for step, slope in zip(range(WINDOW - 1, -1, -1), slopes, strict=True):
            gh = torch.addcmul(slope, gu, self._charged[step], value=-1.0).mul_(surrogate[step])
            gh.addcmul_(gu, self._silent[step])
            torch.mul(gh, 1.0 / TAU, out=out[step])
            torch.mul(gh, 1.0 - 1.0 / TAU, out=gu)


def _flat(window: torch.Tensor) -> torch.Tensor:
    """Return all steps of all postures as rows, a view."""
    return window.view(-1, window.shape[-1])
