"""The benchmark's own trajectories, and the door to those of others."""

import tomllib
from collections.abc import Callable
from functools import cache, partial
from importlib.resources import files

import numpy as np

from ...controllers.discovery import load
from ...controllers.errors import InvalidInput, UnknownName
from .paths import HarmonicPath, Path, circle, eight, fourier, rotated_circle, yz_circle

SHAPES: dict[str, Callable[..., HarmonicPath]] = {
    "circle": circle,
    "rotated_circle": rotated_circle,
    "yz_circle": yz_circle,
    "eight": eight,
    "fourier": fourier,
}
"""Kinds of the data files."""


@cache
def suite() -> dict[str, HarmonicPath]:
    """Return the paper's paths by name, T1 to T8 before S1 to S3."""
    return _read("trajectories.toml")


@cache
def further_suite() -> dict[str, HarmonicPath]:
    """Return the sixteen further paths by name, M1 to M16; nothing may be trained or tuned on them."""
    return _read("further_motions.toml")


def _read(file: str) -> dict[str, HarmonicPath]:
    """Return the paths of a data file by name."""
    package = __name__.rsplit(".", 2)[0]
    table = tomllib.loads((files(package) / "data" / file).read_text(encoding="utf-8"))
    paths = {}
    for entry in table["trajectory"]:
        settings = {key: value for key, value in entry.items() if key not in ("kind", "centre")}
        x, y, z = entry["centre"]
        paths[entry["name"]] = SHAPES[entry["kind"]](centre=(x, y, z), **settings)
    return paths


def suite_path(name: str) -> HarmonicPath:
    """Return one of the benchmark's own paths.

    Args:
        name: Its name in the data files, for example ``"T1"``.

    Raises:
        UnknownName: If they have no such path.
    """
    own = suite() | further_suite()
    if name not in own:
        raise UnknownName("trajectory", name, tuple(own))
    return own[name]


T1 = partial(suite_path, "T1")
T2 = partial(suite_path, "T2")
T3 = partial(suite_path, "T3")
T4 = partial(suite_path, "T4")
T5 = partial(suite_path, "T5")
T6 = partial(suite_path, "T6")
T7 = partial(suite_path, "T7")
T8 = partial(suite_path, "T8")
S1 = partial(suite_path, "S1")
S2 = partial(suite_path, "S2")
S3 = partial(suite_path, "S3")
M1 = partial(suite_path, "M1")
M2 = partial(suite_path, "M2")
M3 = partial(suite_path, "M3")
M4 = partial(suite_path, "M4")
M5 = partial(suite_path, "M5")
M6 = partial(suite_path, "M6")
M7 = partial(suite_path, "M7")
M8 = partial(suite_path, "M8")
M9 = partial(suite_path, "M9")
M10 = partial(suite_path, "M10")
M11 = partial(suite_path, "M11")
M12 = partial(suite_path, "M12")
M13 = partial(suite_path, "M13")
M14 = partial(suite_path, "M14")
M15 = partial(suite_path, "M15")
M16 = partial(suite_path, "M16")


def load_path(name: object) -> Path:
    """Return the path behind a registered name, ``package.module:name``, ``./file.py:name`` or a Python object.

    Args:
        name: One of the four doors; what stands behind it is a path, or is called without arguments and returns one.

    Raises:
        UnknownName: If nobody registered the name.
        InvalidInput: If it gives no path, or one that is not closed or contradicts itself (:func:`check_path`).
    """
    found = load("trajectories", name)
    where = f"trajectory {name!r}" if isinstance(name, str) else "trajectory"
    if callable(found) and (isinstance(found, type) or not isinstance(found, Path)):
        try:
            found = found()
        except Exception as cause:
            raise InvalidInput(f"could not be built: {type(cause).__name__}: {cause}", where) from cause
    if not isinstance(found, Path):
        valid = "a path has name, period, centre, group, pose(t), twist(t) and acceleration(t)"
        raise InvalidInput(f"is a {type(found).__name__}, no path", where, valid)
    check_path(found)
    return found


def check_path(path: Path) -> None:
    """Refuse a path whose functions disagree; a slip in a derivative would otherwise pass as a controller's error.

    Args:
        path: The path, sampled at 512 times.

    Raises:
        InvalidInput: If a shape is wrong, a value is not finite, a rotation is none, the path does not close to
            1e-9, or twist and acceleration are not the derivatives of pose and twist to a thousandth.
    """
    where = f"trajectory {path.name!r}"
    if not (np.isfinite(path.period) and path.period > 0.0):
        raise InvalidInput(f"its period is {path.period} s", where, "give a positive number of seconds")
    t, h = np.linspace(0.0, path.period, 512), 1e-5
    values = {"pose": path.pose(t), "twist": path.twist(t), "acceleration": path.acceleration(t)}
    for (function, value), shape in zip(values.items(), ((512, 4, 4), (512, 6), (512, 6)), strict=True):
        if np.shape(value) != shape:
            raise InvalidInput(f"{function}(t) gives shape {np.shape(value)} for 512 times", where, f"expected {shape}")
        if not np.all(np.isfinite(value)):
            raise InvalidInput(f"{function}(t) is not finite", where)
        if np.abs(value[-1] - value[0]).max() > 1e-9 * max(1.0, np.abs(value).max()):
            gap = np.abs(value[-1] - value[0]).max()
            raise InvalidInput(f"{function}(t) differs by {gap:.3g} after one period", where, "a path is closed")
    rotation = values["pose"][:, :3, :3]
    if np.abs(rotation @ rotation.transpose(0, 2, 1) - np.eye(3)).max() > 1e-9 or np.linalg.det(rotation).min() < 0.0:
        raise InvalidInput("pose(t) holds a rotation that is none", where, "rows must be orthonormal, right-handed")
    before, after = path.pose(t - h), path.pose(t + h)
    linear = (after[:, :3, 3] - before[:, :3, 3]) / (2.0 * h)
    spin = (after[:, :3, :3] - before[:, :3, :3]) @ rotation.transpose(0, 2, 1) / (2.0 * h)
    angular = np.stack((spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]), axis=1)
    _compare("twist(t)", values["twist"], np.hstack((linear, angular)), "pose(t)", where)
    slope = (path.twist(t + h) - path.twist(t - h)) / (2.0 * h)
    _compare("acceleration(t)", values["acceleration"], slope, "twist(t)", where)


def _compare(what: str, given: np.ndarray, differences: np.ndarray, source: str, where: str) -> None:
    """Refuse a derivative that is not one."""
    error, scale = np.abs(given - differences).max(), np.abs(differences).max()
    if error > 1e-3 * max(scale, 1e-2):
        raise InvalidInput(f"{what} differs from the derivative of {source} by {error:.3g}", where)
