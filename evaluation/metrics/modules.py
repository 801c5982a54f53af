"""What the modules of the spiking controller did: gravity torques, weights, gains and spikes as it showed them."""

import math

import numpy as np

from .geometry import root_mean_square
from .registry import UNDEFINED, metric

SMALLEST_GRAVITY = 1e-9
"""Gravity torques below this cannot be divided by: an arm that hangs [N m]."""


def gravity_torque_bias_by_joint(torque: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """Mean error of each joint's learnt gravity torque.

    Args:
        torque: Learnt torques, shape (N, n) [N m].
        gravity: Gravity torques of the model at the same postures, shape (N, n) [N m].

    Returns:
        Shape (n,) [N m].
    """
    return np.asarray((torque - gravity).mean(axis=0))


@metric(
    unit="1",
    better="lower",
    family="modules",
    needs=("torque", "gravity"),
    source="RMS of |learnt - true gravity torque| / RMS of |true gravity torque|",
    label="error of the learnt gravity torque",
    kind="table",
)
def gravity_torque_nrmse(torque: np.ndarray, gravity: np.ndarray) -> float:
    """Error of a learnt gravity torque, as a share of the torque itself.

    The norm is over joints: a joint whose axis is vertical has no gravity torque to divide by.

    Args:
        torque: Learnt torques, shape (N, n) [N m].
        gravity: Gravity torques of the model with the pattern's load at the same postures, shape (N, n) [N m].

    Returns:
        The share [1]; NaN if a sample is not finite or there is no gravity torque.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of samples.
    """
    scale = root_mean_square(np.linalg.norm(gravity, axis=1))
    if scale < SMALLEST_GRAVITY:
        return UNDEFINED
    return root_mean_square(np.linalg.norm(torque - gravity, axis=1)) / scale


@metric(
    unit="N m",
    better="lower",
    family="modules",
    needs=("torque", "gravity"),
    source="norm over joints of the mean of learnt - true gravity torque",
    label="bias of the learnt gravity torque",
    kind="table",
)
def gravity_torque_bias(torque: np.ndarray, gravity: np.ndarray) -> float:
    """Norm of the mean error of a learnt gravity torque; joint by joint see :func:`gravity_torque_bias_by_joint`.

    Args:
        torque: Learnt torques, shape (N, n) [N m].
        gravity: Gravity torques of the model with the pattern's load at the same postures, shape (N, n) [N m].

    Returns:
        The norm [N m]; NaN if a sample is not finite.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of samples.
    """
    return float(np.linalg.norm(gravity_torque_bias_by_joint(torque, gravity)))


@metric(
    unit="1/kg",
    better="none",
    family="modules",
    needs=("weights", "masses"),
    source="least-squares slope of the heavy pattern's mean weight against the load",
    label="weight by load",
    kind="table",
)
def thalamus_weight_slope(weights: np.ndarray, masses: np.ndarray) -> float:
    """How much the heavy pattern's weight grows with the load; 1/3 per kg is right for patterns that are 3 kg apart.

    Args:
        weights: Mean weight of the heavy pattern in each run, shape (R,).
        masses: Load of each run, shape (R,) [kg].

    Returns:
        The slope [1/kg]; NaN if a sample is not finite or there are fewer than three loads.

    Raises:
        EmptyWindow: If there is no run.
        UnequalLengths: If the arrays hold different numbers of runs.
    """
    if len(np.unique(masses)) < 3:
        return UNDEFINED
    spread = masses - masses.mean()
    return float(spread @ weights / (spread @ spread))


@metric(
    unit="kg",
    better="none",
    family="modules",
    needs=("torque", "gravity", "gravity_per_kg"),
    source="least squares of torque = gravity of the arm + m gravity of 1 kg",
    label="load that the torque compensates",
    kind="table",
)
def equivalent_load(torque: np.ndarray, gravity: np.ndarray, gravity_per_kg: np.ndarray) -> float:
    """Load that a compensation torque is right for; less the true load, its error.

    Args:
        torque: Torques of the compensation, shape (N, n) [N m].
        gravity: Gravity torques of the arm without load at the same postures, shape (N, n) [N m].
        gravity_per_kg: What one kilogram adds to them, shape (N, n) [N m].

    Returns:
        The load [kg]; NaN if a sample is not finite or a load exerts no torque.

    Raises:
        EmptyWindow: If there is no sample.
        UnequalLengths: If the arrays hold different numbers of samples.
    """
    if root_mean_square(gravity_per_kg) < SMALLEST_GRAVITY:
        return UNDEFINED
    square = float(np.einsum("kn,kn->", gravity_per_kg, gravity_per_kg))
    return float(np.einsum("kn,kn->", torque - gravity, gravity_per_kg)) / square


@metric(
    unit="1",
    better="none",
    family="modules",
    needs=("spikes", "neurons", "steps"),
    source="spikes / (neurons x time steps)",
    label="spike rate",
    kind="table",
)
def spike_rate(spikes: np.ndarray, neurons: float, steps: float) -> float:
    """Share of the time steps in which a neuron of a layer fires.

    Args:
        spikes: Spikes of the layer, counted in any portions, shape (K,).
        neurons: Number of its neurons.
        steps: Number of time steps that were counted, over all portions.

    Returns:
        The share [1]; NaN if a sample is not finite or no neuron took a step.

    Raises:
        EmptyWindow: If nothing was counted.
    """
    return float(spikes.sum()) / (neurons * steps) if neurons * steps > 0.0 else math.nan
