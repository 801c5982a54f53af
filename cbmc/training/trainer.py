"""Training of one pattern: postures and torques in, folded weights out."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import torch

from ..patterns import Patterns
from .network import GROUP, PURKINJE, Network, Weights, leak_weights
from .recipes import Recipe
from .watch import Watch

REFIT_SAMPLES = 30_000
"""Postures that the ridge regression of the readout sees."""
RIDGE = 1e-6
"""Its penalty, for each posture."""
SMALLEST_STD = 0.05
"""Below this a joint's torque counts as constant: a vertical axis carries no gravity torque [N m]."""
RANDOM_PURKINJE = 4.0
"""Scale of PC weights that stay random; as drawn they hardly make PC fire."""
BATCHES = 512
"""Postures of a batch outside training."""


def train_pattern(
    parts: Sequence[np.ndarray], torques: Sequence[np.ndarray], recipe: Recipe, *, load: float, seed: int, watch: Watch
) -> Patterns:
    """Train one pattern; the same seed gives the same bits on one machine.

    Args:
        parts: Postures, each of shape (N_i, n) [rad].
        torques: Their gravity torques, each of shape (N_i, n) [N m].
        recipe: How.
        load: Load beyond the gripper that the torques belong to [kg].
        seed: Seed of weights, batches and label noise.
        watch: Is told how far it is.

    Returns:
        One pattern, float32, without notes.
    """
    q, torque = np.concatenate(parts), np.concatenate(torques)
    scaling = _Scaling.of(q, torque, recipe)
    weights = Weights.drawn(q.shape[1], seed)
    generator = torch.Generator().manual_seed(seed + 1)
    with _one_thread(), torch.no_grad():
        if recipe.optimiser == "sgd":
            data = [(scaling.inputs(x), scaling.targets(y)) for x, y in zip(parts, torques, strict=True)]
            _descend(weights, data, recipe, generator, watch)
        elif recipe.steps:
            _adam(weights, scaling.inputs(q), scaling.targets(torque), recipe, generator, watch)
        else:
            weights.purkinje.mul_(RANDOM_PURKINJE)
        readout = scaling.unscaled_readout(weights)
        if recipe.refit:
            chosen = torch.randperm(len(q), generator=generator)[:REFIT_SAMPLES].numpy()
            readout = _ridge(_features(weights, scaling.inputs(q[chosen])), torque[chosen])
    watch(1.0)
    return scaling.export(weights, *readout, load=load)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Scaling:
    """Affine maps around the network, all folded into its weights in the end."""

    q_mean: np.ndarray
    q_gain: np.ndarray
    torque_mean: np.ndarray
    torque_scale: np.ndarray

    @classmethod
    def of(cls, q: np.ndarray, torque: np.ndarray, recipe: Recipe) -> "_Scaling":
        spread, n = q.std(axis=0), q.shape[1]
        return cls(
            q_mean=q.mean(axis=0),
            # A joint that never moves tells nothing: it gets no current.
            q_gain=np.where(spread > 1e-9, recipe.gain / np.maximum(spread, 1e-9), 0.0),
            torque_mean=torque.mean(axis=0) if recipe.scaled else np.zeros(n),
            # Between equal weight of all joints and equal weight of all newton metres.
            torque_scale=np.sqrt(np.maximum(torque.std(axis=0), SMALLEST_STD)) if recipe.scaled else np.ones(n),
        )

    def inputs(self, q: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(((q - self.q_mean) * self.q_gain).astype(np.float32))

    def targets(self, torque: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(((torque - self.torque_mean) / self.torque_scale).astype(np.float32))

    def unscaled_readout(self, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
        scale = self.torque_scale
        return (
            weights.readout.double().numpy() * scale[:, None],
            weights.readout_bias.double().numpy() * scale + self.torque_mean,
        )

    def export(self, weights: Weights, readout: np.ndarray, offset: np.ndarray, *, load: float) -> Patterns:
        granule = weights.granule.double().numpy() * self.q_gain
        return Patterns(
            granule=_single(granule),
            granule_bias=_single(weights.granule_bias.double().numpy() - granule @ self.q_mean),
            purkinje=_single(weights.purkinje.numpy()),
            purkinje_bias=_single(weights.purkinje_bias.numpy()),
            readout=_single(readout),
            readout_bias=_single(offset),
            loads=(load,),
        )


def _single(array: np.ndarray) -> np.ndarray:
    """Return a float32 copy with the axis of patterns in front."""
    return array[None].astype(np.float32)


def _adam(
    weights: Weights, x: torch.Tensor, y: torch.Tensor, recipe: Recipe, generator: torch.Generator, watch: Watch
) -> None:
    """Adam (Kingma and Ba 2015, its default decays) on random batches, the rate a half cosine to zero."""
    network = Network(weights, batch=recipe.batch, slope=recipe.slope)
    first, second = torch.zeros_like(weights.vector), torch.zeros_like(weights.vector)
    for step in range(1, recipe.steps + 1):
        chosen = torch.randint(len(x), (recipe.batch,), generator=generator)
        slope = (network.forward(x[chosen]) - y[chosen]).mul_(2.0 / (recipe.batch * y.shape[1]))
        gradient = network.backward(slope).vector
        first.lerp_(gradient, 0.1)
        second.mul_(0.999).addcmul_(gradient, gradient, value=0.001)
        rate = 0.5 * recipe.rate * (1.0 + np.cos(np.pi * step / recipe.steps))
        spread = (second / (1.0 - 0.999**step)).sqrt_().add_(1e-8)
        weights.vector.addcdiv_(first, spread, value=-rate / (1.0 - 0.9**step))
        watch(step / recipe.steps)


def _descend(
    weights: Weights,
    parts: Sequence[tuple[torch.Tensor, torch.Tensor]],
    recipe: Recipe,
    generator: torch.Generator,
    watch: Watch,
) -> None:
    """The paper's Algorithm 2: batches in the order of the path, fresh label noise, paths alternating."""
    network = Network(weights, batch=recipe.batch, slope=recipe.slope)
    momentum, rates = torch.zeros_like(weights.vector), _folded_rates(weights, recipe.rate)
    for epoch in range(recipe.epochs):
        for x, y in parts:
            for start in range(0, len(x) - recipe.batch + 1, recipe.batch):
                rows = slice(start, start + recipe.batch)
                noise = torch.randn((recipe.batch, y.shape[1]), generator=generator) * recipe.label_noise
                slope = (network.forward(x[rows]) - y[rows] - noise).mul_(2.0 / (recipe.batch * y.shape[1]))
                momentum.mul_(recipe.momentum).add_(network.backward(slope).vector)
                weights.vector.addcmul_(rates, momentum, value=-1.0)
        watch((epoch + 1) / recipe.epochs)


def _folded_rates(weights: Weights, rate: float) -> torch.Tensor:
    """Return each parameter's rate so that a folded group moves as the mean of its 20 neurons would.

    Each neuron gets a twentieth of the gradient of the mean, so the mean moves by a twentieth of the rate; a bias
    acts through the window's leak, once in its gradient and once in its effect.
    """
    rates = Weights.zeros(weights.granule.shape[1])
    rates.vector.fill_(rate)
    rates.readout.fill_(rate / GROUP)
    rates.readout_bias.fill_(rate / GROUP * float(leak_weights().sum()) ** 2)
    return rates.vector


def _features(weights: Weights, x: torch.Tensor) -> np.ndarray:
    """Return the weighted PC spikes of postures, shape (N, PC)."""
    network = Network(weights, batch=BATCHES, slope=1.0)
    features = np.empty((len(x), PURKINJE))
    for start in range(0, len(x), BATCHES):
        rows = x[start : start + BATCHES]
        padded = torch.zeros((BATCHES, x.shape[1]))
        padded[: len(rows)] = rows
        features[start : start + len(rows)] = network.features(padded)[: len(rows)].numpy()
    return features


def _ridge(features: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the readout, shape (n, PC), and offset, shape (n,), of least squared error [N m]."""
    columns = np.hstack((features, np.ones((len(features), 1))))
    square = columns.T @ columns + RIDGE * len(columns) * np.eye(columns.shape[1])
    solution = np.linalg.solve(square, columns.T @ torque).T
    return solution[:, :-1], solution[:, -1]


@contextmanager
def _one_thread() -> Iterator[None]:
    """Keep torch on one thread: sums over several depend on how they are shared out."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
