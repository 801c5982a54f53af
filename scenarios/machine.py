"""Which machine and which code: what a reader needs to judge timings and to run a campaign again."""

import os
import platform
import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from .digest import library_versions

OWN = "torquebench"


@cache
def machine() -> dict[str, object]:
    """Return processor, number of usable cores, system and Python; no names of hosts or users."""
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
    }


def machine_label() -> str:
    """Return the machine in one line; timings of different machines are never pooled."""
    facts = machine()
    return f"{facts['processor']}, {facts['cores']} cores, {facts['system']}, Python {facts['python']}"


def versions() -> dict[str, str]:
    """Return the versions of this package and of the libraries that enter results."""
    try:
        own = version(OWN)
    except PackageNotFoundError:
        own = "unknown"
    return {OWN: own, **library_versions()}


def commit() -> str:
    """Return the commit of the source tree with ``+`` if it has changes, empty outside a checkout."""
    folder = Path(__file__).resolve().parent
    try:
        top = _git(folder, "rev-parse", "--show-toplevel")
        if Path(top) != folder.parent:
            return ""
        return _git(folder, "rev-parse", "--short=12", "HEAD") + ("+" if _git(folder, "status", "--porcelain") else "")
    except (OSError, subprocess.SubprocessError):
        return ""


def _git(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(folder), *arguments], capture_output=True, text=True, timeout=10, check=True
    )
    return done.stdout.strip()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown processor"
