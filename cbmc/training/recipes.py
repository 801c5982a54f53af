"""How a pattern is trained: the numbers, by name."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Settings of one training run.

    Attributes:
        optimiser: ``"adam"`` with a cosine to zero on random batches, or ``"sgd"``: the paper's, part after part.
        samples: Postures in the set.
        steps: Updates of ``"adam"``; 0 leaves the random weights and fits the readout only.
        epochs: Passes of ``"sgd"`` over each part of the set.
        batch: Postures of an update.
        rate: Learning rate, at the start.
        momentum: Momentum of ``"sgd"``.
        slope: Slope nu of the surrogate gradient. It does not exist at inference, so a value other than the paper's 5
            changes the training only; with a threshold of 0.1 the gradient of nu = 5 hardly knows where it is.
        gain: Input current of a posture one standard deviation away from the mean.
        label_noise: Standard deviation of the noise on the labels [N m].
        scaled: Whether joints count by the square root of their torque's standard deviation; else equally, and the
            network learns raw torques.
        refit: Whether the readout is fitted by ridge regression at the end.
    """

    optimiser: str = "adam"
    samples: int = 100_000
    steps: int = 0
    epochs: int = 0
    batch: int = 128
    rate: float = 8e-3
    momentum: float = 0.0
    slope: float = 50.0
    gain: float = 1.2
    label_noise: float = 0.0
    scaled: bool = True
    refit: bool = True


PRESETS = {
    "smoke": Recipe(steps=250, samples=20_000),
    "default": Recipe(steps=2000, samples=100_000),
    "best": Recipe(steps=5000, samples=200_000),
    "paper": Recipe(
        optimiser="sgd",
        epochs=50,
        batch=10,
        rate=0.01,
        momentum=0.5,
        slope=5.0,
        gain=1.0,
        label_noise=1.0,
        scaled=False,
        refit=False,
    ),
}
"""Recipes by name; ``paper`` is the paper's Table I and Algorithm 2."""
