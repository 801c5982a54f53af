"""The contract: any object with ``reset`` and ``compute`` is a controller."""

import difflib
import inspect
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .errors import InvalidInput, Refusal, TorquebenchError
from .ledger import LedgerEntry
from .observation import Observation
from .target import Target
from .task import Task


@dataclass(frozen=True, kw_only=True)
class DesignInertia:
    """The inertia that a law was designed with, for the harness's check against the plant.

    Attributes:
        mass_matrix: Joint-space inertia in front of the damping gain at the initial position, shape (n, n) [kg m^2].
        damping: Gain on the velocity error in acceleration form [1/s].
    """

    mass_matrix: np.ndarray
    damping: float


class Controller(ABC):
    """A joint-torque controller; inheriting is optional, the two methods are the contract.

    Settings are keyword arguments of the constructor, JSON-serialisable, with defaults; the constructor is light.

    Attributes:
        uses_model: Whether the law reads ``task.robot``, so that payload knowledge can make a difference.
        estimates_load: Whether the law estimates the load itself (integral action does not count).
        knowledge_levels: The levels that can differ, if the two answers above do not say it; None otherwise.
        carry_over: Whether learnt parameters survive ``reset`` in the protocol ``carried``.
    """

    uses_model: ClassVar[bool] = True
    estimates_load: ClassVar[bool] = False
    knowledge_levels: ClassVar[tuple[str, ...] | None] = None
    carry_over: ClassVar[bool] = False

    @abstractmethod
    def reset(self, task: Task) -> None:
        """Prepare for one episode: all heavy work; forgets everything, unless ``carry_over`` declares otherwise."""

    @abstractmethod
    def compute(self, observation: Observation, target: Target) -> np.ndarray:
        """Return the torque for this tick, shape (n,) [N m]; keep and change neither argument."""

    def supports(self, task: Task) -> str | None:
        """Return None, or the reason why this task is refused."""
        return None

    def diagnostics(self) -> Mapping[str, tuple[np.ndarray, int]]:
        """Return, once after reset, name to (array updated in place, period in ticks)."""
        return {}

    def events(self) -> Mapping[str, np.ndarray]:
        """Return, after a run, bounded buffers of what happened in it, such as spike rasters, by name.

        Asked for only where full traces are kept; the bound is the controller's business.
        """
        return {}

    def snapshot(self) -> Mapping[str, np.ndarray]:
        """Return, after the last run of a chain of protocol ``carried``, what was learnt, by name."""
        return {}

    def operations(self) -> Mapping[str, int]:
        """Return the cumulative operation counters."""
        return {}

    def ledger(self) -> Sequence[LedgerEntry]:
        """Return, after reset, where each setting comes from."""
        return ()

    def design_inertia(self) -> DesignInertia | None:
        """Return, after reset, the inertia that the law was designed with, if it was."""
        return None

    def close(self) -> None:  # noqa: B027 - most controllers hold nothing
        """Release what ``reset`` acquired."""


def hook(controller: object, name: str) -> object:
    """Return a bound optional hook of any object with the two methods, or the default of :class:`Controller`."""
    found = getattr(controller, name, None)
    return found if found is not None else getattr(Controller, name).__get__(controller)


def knowledge_levels(controller: object, known: Sequence[str]) -> tuple[str, ...]:
    """Return the knowledge levels at which a controller can differ.

    Args:
        controller: A configured controller.
        known: The levels that exist.
    """
    declared = getattr(controller, "knowledge_levels", None)
    if declared is not None:
        return tuple(level for level in known if level in declared)
    if not getattr(controller, "uses_model", True):
        return tuple(level for level in known if level == "none")
    if getattr(controller, "estimates_load", False):
        return tuple(level for level in known if level in ("none", "oracle"))
    return tuple(known)


def build_controller(factory: object, settings: Mapping[str, object], *, name: str) -> object:
    """Make a controller from what a door gave: a class, a preset, or an instance.

    Args:
        factory: A class or another callable that takes the settings, or an object with the two methods.
        settings: Keyword arguments.
        name: For messages.

    Raises:
        InvalidInput: If a setting is unknown or refused, or if what came has no ``reset`` and ``compute``.
    """
    is_instance = not isinstance(factory, type) and hasattr(factory, "reset") and hasattr(factory, "compute")
    if is_instance and settings:
        raise InvalidInput("settings for an object that is built already", f"controller {name!r}", "pass its class")
    if not is_instance and not callable(factory):
        raise InvalidInput("is neither a class nor a controller", f"controller {name!r}", "needs reset and compute")
    if not is_instance:
        _check_settings(factory, settings, name)
    try:
        controller = factory if is_instance else factory(**settings)  # type: ignore[operator]
    except TorquebenchError:
        raise
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise InvalidInput(what, f"controller {name!r}", f"settings: {_listed(_settings_of(factory))}") from error
    for method in ("reset", "compute"):
        if not callable(getattr(controller, method, None)):
            raise InvalidInput(f"has no method {method!r}", f"controller {name!r}", "needs reset and compute")
    return controller


def check_inertia(design: DesignInertia | None, plant_mass_matrix: np.ndarray, period: float) -> None:
    """Refuse a law whose design inertia makes it unstable on this plant.

    A discrete damping gain k_d acts on mode i as k_d rho_i h with rho the eigenvalues of M_plant^-1 M_design; with a
    tick of delay the loop is stable only below about 1.

    Args:
        design: What the controller declares, or None.
        plant_mass_matrix: Inertia that the plant's joints have, rotors included, shape (n, n) [kg m^2].
        period: Control period [s].

    Raises:
        Refusal: If the largest k_d rho h exceeds 1; names the figure.
    """
    if design is None:
        return
    ratio = float(np.max(np.linalg.eigvals(np.linalg.solve(plant_mass_matrix, design.mass_matrix)).real))
    figure = ratio * design.damping * period
    if not figure <= 1.0:
        raise Refusal(
            f"designed with up to {ratio:.3g} times the plant's inertia: damping x ratio x period = {figure:.3g}, "
            "stable below about 1"
        )


def _check_settings(factory: object, settings: Mapping[str, object], name: str) -> None:
    """Refuse a setting that a factory does not take, and name the nearest."""
    known = _settings_of(factory)
    for setting in settings:
        if known is not None and setting not in known:
            nearest = difflib.get_close_matches(setting, known, n=1)
            valid = f"did you mean {nearest[0]!r}?" if nearest else f"settings: {_listed(known)}"
            raise InvalidInput(f"unknown setting {setting!r}", f"controller {name!r}", valid)


def _settings_of(factory: object) -> tuple[str, ...] | None:
    """Return the names of a factory's settings, None if it takes any or does not say."""
    try:
        parameters = inspect.signature(factory).parameters  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None
    takes_any = any(parameter.kind is inspect.Parameter.VAR_KEYWORD for parameter in parameters.values())
    return None if takes_any else tuple(parameters)


def _listed(names: tuple[str, ...] | None) -> str:
    return "unknown" if names is None else ", ".join(names) or "none"
