"""Tiers: how much of a real drive and of real sensors stands between a command and the arm."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import BeforeValidator, Field

from ..controllers import Actuation, InvalidInput, UnknownName
from .elasticity import Elasticity, build_elasticity
from .validation import Number, Record, as_tuple


@dataclass(frozen=True, kw_only=True)
class Tier:
    """The constants of one tier for one robot.

    Attributes:
        name: Name of the tier.
        period: Control period [s].
        rotor_inertia: Apparent rotor inertia, shape (n,) [kg m^2].
        delay_ticks: Ticks between command and torque.
        torque_lag: Time constant of the torque loop, 0 without [s].
        torque_rate: Torque rate limits, shape (n,), infinite without [N m/s].
        coulomb: Coulomb friction, shape (n,) [N m].
        viscous: Viscous friction, shape (n,) [N m s/rad].
        coulomb_velocity: Velocity at which Coulomb friction is fully there [rad/s].
        encoder_quantum: Resolution of the position sensor, 0 for exact sensors [rad].
        velocity_filter_hz: Corner of the velocity filter, None for exact velocity [Hz].
        wrench_noise: Standard deviation of the force and torque noise, shape (6,) [N, N m].
        wrench_bias: Standard deviation of the bias, drawn once a run, shape (6,) [N, N m].
        wrench_filter_hz: Corner of the force and torque filter, None without [Hz].
        elasticity: Constants of elastic joints, None where motor and link are one.
        substeps: Integration steps of the plant in one control period.
    """

    name: str
    period: float
    rotor_inertia: np.ndarray
    delay_ticks: int
    torque_lag: float
    torque_rate: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray
    coulomb_velocity: float
    encoder_quantum: float
    velocity_filter_hz: float | None
    wrench_noise: np.ndarray
    wrench_bias: np.ndarray
    wrench_filter_hz: float | None
    elasticity: Elasticity | None = None
    substeps: int = 1

    @property
    def step(self) -> float:
        """Integration step of the plant [s]."""
        return self.period / self.substeps

    def actuation(self, effort: np.ndarray) -> Actuation:
        """Return the tier's published facts for controllers.

        Args:
            effort: Torque limits of the arm, shape (n,) [N m].
        """
        limited = bool(np.isfinite(self.torque_rate).any())
        joints = self.elasticity
        return Actuation(
            tier=self.name,
            delay_ticks=self.delay_ticks,
            torque_lag=self.torque_lag if joints is None else joints.current_lag,
            velocity_filter_hz=self.velocity_filter_hz,
            effort=effort.copy(),
            torque_rate=self.torque_rate.copy() if limited else None,
            rotor_inertia=self.rotor_inertia.copy(),
            joint_stiffness=None if joints is None else joints.stiffness.copy(),
        )


NotNegative = Annotated[Number, Field(ge=0)]
Positive = Annotated[Number, Field(gt=0)]


class TierTable(Record):
    """The constants of a tier in a robot's file; what is left out or 0 is absent in the tier."""

    armature_scale: NotNegative = 1.0
    delay_ticks: Annotated[int, Field(ge=0)] = 0
    torque_loop_time_constant: NotNegative = 0.0
    torque_rate_limit: Annotated[tuple[Positive, ...], BeforeValidator(as_tuple)] = ()
    joint_stiffness: Annotated[tuple[Positive, ...], BeforeValidator(as_tuple)] = ()
    joint_damping_time: NotNegative = 0.0
    motor_inertia: Annotated[tuple[Positive, ...], BeforeValidator(as_tuple)] = ()
    torque_feedback_gain: NotNegative = 0.0
    torque_feedback_damping_ratio: NotNegative = 0.0
    current_loop_time_constant: NotNegative = 0.0
    substeps: Annotated[int, Field(ge=1)] = 1
    coulomb: Annotated[tuple[NotNegative, ...], BeforeValidator(as_tuple)] = ()
    viscous: Annotated[tuple[NotNegative, ...], BeforeValidator(as_tuple)] = ()
    coulomb_velocity_scale: Positive = 1.0
    encoder_bits: Annotated[int, Field(ge=0)] = 0
    velocity_filter_hz: NotNegative = 0.0
    ft_noise_sigma: Annotated[tuple[NotNegative, ...], BeforeValidator(as_tuple)] = ()
    ft_bias_sigma: Annotated[tuple[NotNegative, ...], BeforeValidator(as_tuple)] = ()
    ft_filter_hz: NotNegative = 0.0


def default_tiers(effort: np.ndarray, rotor_inertia: np.ndarray) -> dict[str, dict[str, object]]:
    """Return tiers for an arm whose file gives none: drives scaled to its torque limits.

    The shares are those of the Rizon 4s: 130 times the limit in a second, friction of 0.6 percent of it, springs that
    give 1/140 rad at the limit. A joint without a rotor gets one of 0.02 kg m^2 for each newton metre in ``elastic``.

    Args:
        effort: Torque limits, shape (n,) [N m].
        rotor_inertia: Rotor inertia, 0 where nothing is known, shape (n,) [kg m^2].
    """
    friction = tuple(0.006 * effort)
    actuated: dict[str, object] = {
        "delay_ticks": 1,
        "torque_loop_time_constant": 0.0015,
        "torque_rate_limit": tuple(130.0 * effort),
        "coulomb": friction,
        "viscous": friction,
        "coulomb_velocity_scale": 0.02,
        "encoder_bits": 20,
        "velocity_filter_hz": 150.0,
        "ft_noise_sigma": (0.1, 0.1, 0.1, 0.005, 0.005, 0.005),
        "ft_bias_sigma": (0.5, 0.5, 0.5, 0.02, 0.02, 0.02),
        "ft_filter_hz": 100.0,
    }
    tight = actuated | {"torque_rate_limit": tuple(32.5 * effort)}
    elastic = actuated | {
        "torque_loop_time_constant": 0.0,
        "joint_stiffness": tuple(140.0 * effort),
        "joint_damping_time": 0.001,
        "motor_inertia": tuple(np.where(rotor_inertia > 0.0, rotor_inertia, 0.02 * effort)),
        "torque_feedback_gain": 2.0,
        "torque_feedback_damping_ratio": 1.0,
        "current_loop_time_constant": 0.0005,
        "substeps": 4,
    }
    bare: dict[str, object] = {"armature_scale": 0.0}
    return {"ideal": {}, "actuated": actuated, "tight_rate": tight, "elastic": elastic, "paper_bullet": bare}


def build_tier(
    name: str,
    constants: Mapping[str, Mapping[str, object]],
    rotor_inertia: np.ndarray,
    changes: Mapping[str, object] | None = None,
) -> Tier:
    """Make a tier from a robot's table of constants.

    Args:
        name: Name of the tier.
        constants: The robot's tiers, names to constants as in its data file.
        rotor_inertia: Full rotor inertia of the robot, shape (n,) [kg m^2]; the tier scales it.
        changes: Constants in place of the robot's own, those of :class:`TierTable`.

    Raises:
        UnknownName: If the robot has no such tier.
        InvalidInput: If a changed constant has not one value for each joint.
        InvalidInput: If it has elastic joints and no rotors.
    """
    if name not in constants:
        raise UnknownName("tier", name, tuple(constants))
    n = rotor_inertia.shape[0]
    _check_lengths(changes or {}, n)
    table = {**constants[name], **(changes or {})}

    def row(key: str, default: float, size: int = n) -> np.ndarray:
        return np.broadcast_to(np.asarray(table.get(key, default), dtype=float), size).copy()

    def number(key: str, default: float = 0.0) -> float:
        return float(table.get(key, default))  # type: ignore[arg-type]

    def optional(key: str) -> float | None:
        return number(key) or None

    bits, joints = optional("encoder_bits"), build_elasticity(table, rotor_inertia)
    scaled = number("armature_scale", 1.0) * rotor_inertia
    return Tier(
        name=name,
        period=number("dt", 1e-3),
        rotor_inertia=scaled if joints is None else joints.apparent_inertia,
        delay_ticks=int(number("delay_ticks")),
        torque_lag=number("torque_loop_time_constant"),
        torque_rate=row("torque_rate_limit", np.inf),
        coulomb=row("coulomb", 0.0),
        viscous=row("viscous", 0.0),
        coulomb_velocity=number("coulomb_velocity_scale", 1.0),
        encoder_quantum=0.0 if bits is None else 2.0 * np.pi / 2.0**bits,
        velocity_filter_hz=optional("velocity_filter_hz"),
        wrench_noise=row("ft_noise_sigma", 0.0, 6),
        wrench_bias=row("ft_bias_sigma", 0.0, 6),
        wrench_filter_hz=optional("ft_filter_hz"),
        elasticity=joints,
        substeps=int(number("substeps", 1.0)),
    )


def _check_lengths(changes: Mapping[str, object], n: int) -> None:
    """Refuse a list that has not one value for each joint, or for each of the six of a wrench."""
    for key, value in changes.items():
        expected = 6 if key.startswith("ft_") else n
        if isinstance(value, list | tuple) and len(value) != expected:
            raise InvalidInput(f"{key} has {len(value)} values", "tier_constants", f"expected {expected}")
