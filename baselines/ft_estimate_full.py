"""Payload from the force and torque sensor with its inertia: ten parameters where the motion shows them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .ft_estimate import FtEstimate
from .ft_filter import CENTRED, FULL
from .ft_mechanics import ELEMENTS
from .settings import require_not_negative, require_positive

TENSOR = np.array([[4, 5, 7], [5, 6, 8], [7, 8, 9]])
"""Place of each element of the inertia among the ten parameters."""
SEEN = 0.25
"""A direction of the inertia is seen when this share of its prior variance is left: half the standard deviation."""


@dataclass(kw_only=True)
class FtEstimateFull(FtEstimate):
    r"""Knowledge level that weighs the load with the flange's sensor, and finds its inertia where the motion shows it.

    To the states of :class:`.FtEstimate` come six, shape (16,) with the bias: what the inertia about the flange
    differs by from that of the ball which the other level supplies. The ball follows mass and moments through the
    centre c at which the covariance was opened,

    .. math:: I = D(c) \begin{bmatrix} m \\ m c \end{bmatrix} + \delta, \quad \delta \sim N(0, \sigma^2)

    so the balance stays linear in all states and no centre is taken as known. On a motion of constant orientation the
    data have rank four and nothing is learnt of delta; a turn whose torque on the spread stays below a reading's noise
    counts as an uncertainty of the reading. With the posterior covariance of delta what is told is

    .. math:: \hat I + \frac{P_\delta}{\sigma^2} \left( I_{ball}(\hat m, \hat c) - D(c) \hat x \right)

    that is, the data where they have spoken and the ball about the estimated centre where they have not; then the
    nearest body with a positive definite pseudo-inertia and the same mass and centre.

    Source: Schmidt, Application of state-space methods to navigation problems (1966), for states that are considered
    and not estimated; Wensing, Kim, Slotine, Linear matrix inequalities for physically consistent inertial parameter
    identification (RA-L 2018), for the pseudo-inertia; the rest is this project's.

    Attributes:
        inertia_spread: Spread of each inertia about that of the ball [kg m^2].
        inertia_drift: Random walk of the inertias [kg m^2/sqrt(s)].
        thinnest: Least root mean square extent of the load in any direction that is told [m].
    """

    inertia_spread: float = 0.02
    inertia_drift: float = 4e-5
    thinnest: float = 0.005
    load: ClassVar[int] = FULL

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        require_not_negative("inertia_drift", self.inertia_drift)
        require_positive("inertia_spread", self.inertia_spread)
        require_positive("thinnest", self.thinnest)

    @property
    def parameters_seen(self) -> int:
        """How many of the load's ten parameters the data have shown; the others are the prior's."""
        shares = np.linalg.eigvalsh(self._unlearnt())
        return CENTRED + int(np.count_nonzero(shares < SEEN))

    def findings(self) -> Mapping[str, object]:
        """Return what a reader of the run should know: of how many parameters the motion told anything."""
        return {"parameters_seen": self.parameters_seen}

    def _constants(self) -> np.ndarray:
        constants = super()._constants()
        constants["inertia_spread"] = self.inertia_spread
        constants["drift"][0, CENTRED:] = self.inertia_drift**2 * self.period
        return constants

    def _told(self) -> np.ndarray:
        """Return the ten parameters of a real body: the data's inertia, the ball's where they show none."""
        memory = self._memory[0]
        linear = memory["follows"] @ memory["estimate"][:CENTRED]
        told = self._payload.copy()
        told[4:] = linear + memory["estimate"][CENTRED:FULL] + self._unlearnt() @ (told[4:] - linear)
        return real_body(told, thinnest=self.thinnest, widest=self.reach)

    def _unlearnt(self) -> np.ndarray:
        """Return the share of the prior variance of the inertia's difference that is left, shape (6, 6)."""
        return np.asarray(self.covariance[CENTRED:FULL, CENTRED:FULL] / self.inertia_spread**2)


def real_body(parameters: np.ndarray, *, thinnest: float, widest: float) -> np.ndarray:
    r"""Return the body with the same mass and centre whose pseudo-inertia is positive definite, nearest in inertia.

    The second moments of mass about its centre, :math:`\frac12 tr(I) 1 - I`, are given eigenvalues within the limits.

    Args:
        parameters: Ten parameters about any point, shape (10,).
        thinnest: Least root mean square extent along an axis [m].
        widest: Largest [m].
    """
    mass, first = parameters[0], parameters[1:4]
    if mass <= 0.0:
        return np.zeros(10)
    shift = (first @ first * np.eye(3) - np.outer(first, first)) / mass
    about = parameters[TENSOR] - shift
    extents, axes = np.linalg.eigh(0.5 * np.trace(about) * np.eye(3) - about)
    second = axes * np.clip(extents, mass * thinnest**2, mass * widest**2) @ axes.T
    tensor = np.trace(second) * np.eye(3) - second + shift
    return np.array([mass, *first, *(tensor[place] for place in ELEMENTS)])
