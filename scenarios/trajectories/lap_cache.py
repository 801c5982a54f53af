"""Solved laps on disk: inverse kinematics of a path costs a fraction of a second, and every worker needs it."""

import hashlib
import os
import tempfile
from pathlib import Path as File

import numpy as np

from ...controllers.cache import cache_folder
from ..robots import Robot
from .kinematics import Lap, lap_samples, solve_lap, spectral_derivative
from .paths import Path

VERSION = "1"
"""Grows whenever the solver's answer changes."""


def cached_lap(robot: Robot, path: Path, *, step: float) -> Lap:
    """Return the joint motion of a path, solved once for an arm, its home and the path's samples.

    Args:
        robot: The arm.
        path: The closed path.
        step: Time between samples [s].

    Raises:
        InvalidInput: If the path cannot be followed.
    """
    times = np.arange(lap_samples(path, step)) * step
    parts = (
        VERSION.encode(),
        robot.urdf.encode(),
        robot.home.tobytes(),
        path.pose(times).tobytes(),
        repr((step, tuple(map(float, path.centre)))).encode(),
    )
    file = cache_folder("laps") / f"{hashlib.sha256(b'|'.join(parts)).hexdigest()[:32]}.npy"
    q = _read(file, (len(times), robot.n))
    if q is None:
        q = solve_lap(robot.model(), path, home=robot.home, step=step).q
        _write(file, q)
    return Lap(q=q, dq=spectral_derivative(q, path.period, order=1), ddq=spectral_derivative(q, path.period, order=2))


def _read(file: File, shape: tuple[int, int]) -> np.ndarray | None:
    """Return a cached array, None if there is none or it is damaged."""
    try:
        q = np.load(file)
    except (OSError, ValueError, EOFError):
        return None
    return np.asarray(q) if q.shape == shape and np.all(np.isfinite(q)) else None


def _write(file: File, q: np.ndarray) -> None:
    """Write an array in one step, so that no reader sees half of it; a full disk only costs the next solution."""
    try:
        with tempfile.NamedTemporaryFile(dir=file.parent, suffix=".tmp", delete=False) as temporary:
            np.save(temporary, q)
        os.replace(temporary.name, file)
    except OSError:
        return
