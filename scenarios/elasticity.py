r"""What lies between a motor and its link: a spring, a rotor, and the torque loop that the drive closes around both.

.. math:: \tau_s = K (\theta - q) + D (\dot\theta - \dot q), \quad
          J \ddot\theta = \tau_a - \tau_s - f(\dot\theta), \quad
          \tau_m = \tau_d + k_T (\tau_d - \tau_s) - k_S K (\dot\theta - \dot q)

with :math:`\tau_a` the motor torque :math:`\tau_m` behind the current loop. Below the loop's own frequency a controller
feels a rotor of :math:`J / (1 + k_T)`.
Source: Albu-Schäffer, Ott and Hirzinger, A unified passivity-based control framework for position, torque and
impedance control of flexible joint robots, IJRR 26 (2007).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..controllers import InvalidInput


@dataclass(frozen=True, kw_only=True)
class Elasticity:
    """The constants of elastic joints.

    Attributes:
        stiffness: K, shape (n,) [N m/rad].
        damping: D, shape (n,) [N m s/rad].
        motor_inertia: J, reflected to the joint, shape (n,) [kg m^2].
        torque_gain: k_T of the torque loop.
        rate_gain: k_S on the rate of the spring's torque, shape (n,) [s].
        current_lag: Time constant of the current loop, 0 without [s].
        substeps: Integration steps in one control period.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    motor_inertia: np.ndarray
    torque_gain: float
    rate_gain: np.ndarray
    current_lag: float
    substeps: int

    @property
    def apparent_inertia(self) -> np.ndarray:
        """Rotor inertia that the torque loop leaves apparent, shape (n,) [kg m^2]."""
        return np.asarray(self.motor_inertia / (1.0 + self.torque_gain))

    def current_share(self, step: float) -> float:
        """Return the share of its way to the wanted torque that the current loop goes in one step.

        Args:
            step: Integration step [s].
        """
        return 1.0 - float(np.exp(-step / self.current_lag)) if self.current_lag > 0.0 else 1.0


def build_elasticity(table: Mapping[str, object], rotor_inertia: np.ndarray) -> Elasticity | None:
    """Make the constants from a tier's table, None if it gives no joint stiffness.

    Args:
        table: A tier's constants, as in a robot's file.
        rotor_inertia: Rotor inertia of the robot, for a table that gives no motor inertia, shape (n,) [kg m^2].

    Raises:
        InvalidInput: If a joint has no rotor: a spring alone has nothing to pull at.
    """
    if "joint_stiffness" not in table:
        return None

    def number(key: str) -> float:
        return float(table.get(key, 0.0))  # type: ignore[arg-type]

    inertia = np.array(table.get("motor_inertia", rotor_inertia), dtype=float)
    if not np.all(inertia > 0.0):
        joint = int(np.argmin(inertia > 0.0)) + 1
        raise InvalidInput(f"joint {joint} has no rotor inertia", "elastic tier", "give rotor_inertia or motor_inertia")
    stiffness = np.array(table["joint_stiffness"], dtype=float)
    gain, ratio = number("torque_feedback_gain"), number("torque_feedback_damping_ratio")
    return Elasticity(
        stiffness=stiffness,
        damping=number("joint_damping_time") * stiffness,
        motor_inertia=inertia,
        torque_gain=gain,
        rate_gain=2.0 * ratio * np.sqrt((1.0 + gain) * inertia / stiffness),
        current_lag=number("current_loop_time_constant"),
        substeps=int(table.get("substeps", 1)),  # type: ignore[call-overload]
    )
