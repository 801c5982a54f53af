"""The folder of everything that can be computed again: compiled kernels and solved motions, keyed by version."""

import hashlib
import os
import sys
import tempfile
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

VARIABLE = "TORQUEBENCH_CACHE"
"""Environment variable that names another place for the cache."""

KERNEL_ROOMS = ("controllers", "baselines", "cbmc", "scenarios")


@cache
def cache_folder(purpose: str) -> Path:
    """Return a writable folder for one purpose, made if it is missing.

    In order: the variable ``TORQUEBENCH_CACHE``, the user's cache folder, the system's temporary folder.

    Args:
        purpose: Name of the subfolder.
    """
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "torquebench"
    named = os.environ.get(VARIABLE)
    for root in ((Path(named),) if named else ()) + (home, Path(tempfile.gettempdir()) / f"torquebench-{os.getuid()}"):
        folder = root / _generation() / purpose
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return Path(tempfile.mkdtemp(prefix="torquebench-"))


def _generation() -> str:
    """Return what a cache depends on: versions of this package, of Python and of the compiler."""
    try:
        package, numba = version("torquebench"), version("numba")
    except PackageNotFoundError:
        package, numba = "unknown", "unknown"
    return f"{package}-python{sys.version_info.major}.{sys.version_info.minor}-numba{numba}"


def _kernel_digest() -> str:
    """Return a short hash of all files with kernels: numba does not see a change in a file that another calls."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for room in KERNEL_ROOMS:
        for file in sorted((root / room).rglob("*.py")):
            source = file.read_bytes()
            if b"njit" in source:
                digest.update(source)
    return digest.hexdigest()[:12]


# numba reads the variable when it is imported, so it is set before any module with a kernel can be.
os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder(f"kernels-{_kernel_digest()}")))
