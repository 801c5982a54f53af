"""Gains per joint: what a user gives, what the maker publishes, and a rule for every other arm."""

from collections.abc import Iterable, Mapping
from typing import cast

import numpy as np

from ..controllers import DesignInertia, InvalidInput, LedgerEntry
from ..controllers.ledger import Source
from .settings import require_positive

EXAMPLE_STIFFNESS = (3000.0, 3000.0, 800.0, 800.0, 200.0, 200.0, 200.0)
"""Joint torque control example of the Flexiv RDK [N m/rad]."""

EXAMPLE_DAMPING = (80.0, 80.0, 40.0, 40.0, 8.0, 8.0, 8.0)
"""Joint torque control example of the Flexiv RDK [N m s/rad]."""

EXAMPLE = "Flexiv RDK, joint torque control example, a seven-joint arm with rotors"

DAMPING_RATIO = 0.7
"""Damping ratio of gains by rule; the RDK's default for joint impedance."""


def checked_gains(name: str, value: object) -> tuple[float, ...] | None:
    """Return a setting of gains as a tuple, so that a list from a file and a tuple from code are one setting.

    Args:
        name: Name of the setting.
        value: One positive number per joint, or None.

    Raises:
        InvalidInput: If it is anything else.
    """
    if value is None:
        return None
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise InvalidInput(f"{value!r} is not a list", f"setting {name!r}", "one positive number per joint, or none")
    gains = tuple(value)
    for gain in gains:
        require_positive(name, gain)
    return tuple(float(cast("float", gain)) for gain in gains)


def wrong_length(joints: int, gains: Mapping[str, tuple[float, ...] | None]) -> str | None:
    """Return why gains do not suit an arm, None if they do.

    Args:
        joints: Number of joints.
        gains: The settings by name.
    """
    for name, given in gains.items():
        if given is not None and len(given) != joints:
            return f"{name} has {len(given)} values, the arm has {joints} joints"
    return None


def spring_and_damper(inertia: np.ndarray, bandwidth: float) -> tuple[np.ndarray, np.ndarray]:
    r"""Return gains by rule.

    .. math:: K_j = I_j w^2, \quad D_j = 2 \zeta I_j w, \quad \zeta = 0.7

    Args:
        inertia: Effective inertia I of each joint, shape (n,) [kg m^2].
        bandwidth: Natural frequency w of each joint on its inertia [rad/s].

    Returns:
        Stiffness [N m/rad] and damping [N m s/rad], shapes (n,).
    """
    return inertia * bandwidth**2, 2.0 * DAMPING_RATIO * bandwidth * inertia


def damping_as_inertia(damping: np.ndarray, mass_matrix: np.ndarray) -> DesignInertia:
    r"""Return what a law of given joint damping declares.

    .. math:: D = \rho M_d, \quad \rho = \lambda_{max}(M^{-1} D)

    Args:
        damping: Diagonal of D, shape (n,), or D, shape (n, n) [N m s/rad].
        mass_matrix: M, shape (n, n) [kg m^2].
    """
    matrix = np.diag(damping) if damping.ndim == 1 else damping
    rate = float(np.max(np.linalg.eigvals(np.linalg.solve(mass_matrix, matrix)).real))
    return DesignInertia(mass_matrix=matrix / rate, damping=rate)


def gain_entries(
    name: str, given: tuple[float, ...] | None, used: np.ndarray, source: Source, note: str, unit: str
) -> tuple[LedgerEntry, LedgerEntry]:
    """Return the ledger's lines on one kind of gain: the setting, and what the run used.

    Args:
        name: Name of the setting.
        given: What the user gave, None for nothing.
        used: What the law uses, shape (n,).
        source: Where it comes from if the user gave nothing.
        note: The document or the rule.
        unit: Its unit in brackets.
    """
    asked = "by the user" if given is not None else f"none: {name}_used"
    if given is not None:
        source, note = "chosen", asked
    return (
        LedgerEntry(setting=name, value=given, source="chosen", note=asked),
        LedgerEntry(setting=f"{name}_used", value=used.tolist(), source=source, note=f"{note} {unit}"),
    )
