"""What stands in for a module: fixed answers for ablations, plain arithmetic for null controls."""

from dataclasses import replace

import numpy as np

from ..controllers import RobotModel
from .pathways import Ascending, Descending
from .stack import ThirdOrder
from .thalamus import Thalamus, ThalamusTable

STANDARD_GRAVITY = 9.81
"""As the simulators have it [m/s^2]."""

FILTER_MEMBRANE = ThalamusTable().filter.tau_mb


class FixedWeights:
    """In place of the thalamus: weights that never change, behind the same filter."""

    def __init__(self, descending: Descending, weights: np.ndarray) -> None:
        """Take the pathway.

        Args:
            descending: Its weights are set here and never again.
            weights: Shape (patterns,).
        """
        descending.weights[:] = weights
        self._down = descending

    def weigh(self) -> None:
        """Do nothing: the weights are fixed."""

    def combine(self) -> None:
        """Move the gravity torque one step towards the mixture, as the thalamus's filter layer does."""
        down = self._down
        down.gravity_torque += (down.weights @ down.compensation - down.gravity_torque) / FILTER_MEMBRANE

    def settle(self) -> None:
        """Set the gravity torque to the mixture."""
        np.dot(self._down.weights, self._down.compensation, out=self._down.gravity_torque)

    def learn(self, weight_gradient: np.ndarray) -> None:
        """Do nothing."""


class WeightIntegrator(FixedWeights):
    r"""In place of the thalamus: one line that integrates the error along the patterns' difference.

    .. math:: w_H \leftarrow \mathrm{clip}(w_H + 10^{-4} \sum_i (100 e_i + 10^{-4} \dot e_i) (\tau_H - \tau_L)_i, 0, 1)
    """

    RATE, POSITION, VELOCITY = 1e-4, 100.0, 1e-4

    def __init__(self, ascending: Ascending, descending: Descending) -> None:
        """Take the pathways; light before heavy, both weights one half."""
        super().__init__(descending, np.array([0.5, 0.5]))
        self._up = ascending

    def weigh(self) -> None:
        """Integrate."""
        up, compensation = self._up, self._down.compensation
        error, error_rate = up.q_desired - up.q, up.dq_desired - up.dq
        along = (self.POSITION * error + self.VELOCITY * error_rate) @ (compensation[1] - compensation[0])
        heavy = min(1.0, max(0.0, self._down.weights[1] + self.RATE * along))
        self._down.weights[:] = (1.0 - heavy, heavy)


class ForceMass(FixedWeights):
    """In place of the thalamus: the load read off the force sensor."""

    def __init__(
        self, ascending: Ascending, descending: Descending, *, tool_mass: float, loads: tuple[float, float]
    ) -> None:
        """Take the pathways.

        Args:
            ascending: The wrench comes from here.
            descending: The weights go here; light before heavy.
            tool_mass: Mass of the gripper [kg].
            loads: Load beyond the gripper of both patterns [kg].
        """
        super().__init__(descending, np.array([0.5, 0.5]))
        self._up, self._tool, self._loads = ascending, tool_mass, loads

    def weigh(self) -> None:
        """Place the measured mass between the patterns' loads."""
        load = float(np.linalg.norm(self._up.wrench[:3])) / STANDARD_GRAVITY - self._tool
        light, heavy = self._loads
        share = min(1.0, max(0.0, (load - light) / (heavy - light)))
        self._down.weights[:] = (1.0 - share, share)


class NumbThalamus(Thalamus):
    """In place of a thalamus that feels the load: its input is zero for ever."""

    def connect(self, ascending: Ascending, descending: Descending) -> None:
        """Join the pathways, all but that of the wrench."""
        super().connect(replace(ascending, wrench=np.zeros_like(ascending.wrench)), descending)


class UnfilteredThalamus(Thalamus):
    """In place of a thalamus with a filter layer: the mixture itself is the gravity torque."""

    def combine(self) -> None:
        """Set the gravity torque to the mixture."""
        self.settle()


class FixedGains:
    """In place of the brainstem: gains that never change."""

    def __init__(self, descending: Descending, stiffness: np.ndarray, damping: np.ndarray) -> None:
        """Set the gains.

        Args:
            descending: Its gains are set here and never again.
            stiffness: Shape (n,) [N m/rad].
            damping: Shape (n,) [N m s/rad].
        """
        descending.stiffness[:], descending.damping[:] = stiffness, damping

    def gains(self) -> None:
        """Do nothing: the gains are fixed."""

    def learn(self, gain_gradient: np.ndarray) -> None:
        """Do nothing."""


class HeldCompensation:
    """In place of a cerebellum that follows the arm: its answer at the first call, for ever."""

    def __init__(self, cerebellum: ThirdOrder) -> None:
        """Take the cerebellum that answers once."""
        self._cerebellum: ThirdOrder | None = cerebellum

    def compensate(self) -> None:
        """Ask once."""
        if self._cerebellum is not None:
            self._cerebellum.compensate()
            self._cerebellum = None


class ModelPatterns:
    """In place of the cerebellum: exact gravity torques of the patterns' loads, for checks of the loop alone."""

    def __init__(self, ascending: Ascending, descending: Descending, models: tuple[RobotModel, ...]) -> None:
        """Take the pathways.

        Args:
            ascending: Joint positions come from here.
            descending: Compensation is filled.
            models: One model with its payload set for each pattern.
        """
        self._up, self._down, self._models = ascending, descending, models

    def compensate(self) -> None:
        """Fill the compensation from the models."""
        for row, model in zip(self._down.compensation, self._models, strict=True):
            row[:] = model.gravity(self._up.q)
