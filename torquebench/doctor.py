"""What this installation consists of: every library, where it comes from, whether it works, what its absence costs."""

import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

from .controllers import cache_folder, discovery

PYBULLET_WHEELS_END = (3, 12)
"""First Python version for which PyBullet has no wheel."""

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Environment variables that size the thread pools; workers set all of them to 1 for themselves."""

PROBE_TIMEOUT = 120.0
"""Longest time that an import may take [s]."""


@dataclass(frozen=True, kw_only=True)
class Library:
    """A library that this package can use.

    Attributes:
        module: Name under which it is imported.
        distribution: Name under which it is installed.
        cost: What does not work without it.
        required: Whether nothing runs without it.
    """

    module: str
    distribution: str
    cost: str
    required: bool = True


LIBRARIES = (
    Library(module="numpy", distribution="numpy", cost="nothing runs"),
    Library(module="scipy", distribution="scipy", cost="no statistics, no gain design"),
    Library(module="numba", distribution="numba", cost="nothing runs: the tick is compiled"),
    Library(module="pinocchio", distribution="pin", cost="nothing runs: it is the arm's model"),
    Library(
        module="pybullet",
        distribution="pybullet",
        cost="the Pinocchio plant takes over (same equations)",
        required=sys.version_info < PYBULLET_WHEELS_END,
    ),
    Library(module="casadi", distribution="casadi", cost="nothing runs: a report counts what every law computes"),
    Library(module="proxsuite", distribution="proxsuite", cost="nothing runs: a report counts what every law computes"),
    Library(module="control", distribution="control", cost="no computed torque, no predictive controllers, no margins"),
    Library(module="click", distribution="click", cost="no command line"),
    Library(module="rich", distribution="rich", cost="no command line"),
    Library(module="pydantic", distribution="pydantic", cost="robot and benchmark files cannot be read"),
    Library(module="jinja2", distribution="Jinja2", cost="no report"),
    Library(module="safetensors", distribution="safetensors", cost="trained patterns cannot be read"),
    Library(
        module="torch",
        distribution="torch",
        cost="patterns cannot be trained; running is not affected",
        required=False,
    ),
    Library(module="matplotlib", distribution="matplotlib", cost="no print figures", required=False),
)


@dataclass(frozen=True, kw_only=True)
class LibraryState:
    """One library as it was found.

    Attributes:
        library: What was looked for.
        version: Installed version, empty if its distribution is not installed.
        origin: Folder from which it is imported, empty if it cannot be found.
        problem: One line on what is wrong, empty if it works.
    """

    library: Library
    version: str
    origin: str
    problem: str

    @property
    def state(self) -> str:
        """``ok``, ``missing`` or ``broken``."""
        if not self.problem:
            return "ok"
        return "broken" if self.origin else "missing"


@dataclass(frozen=True, kw_only=True)
class PlugInState:
    """The registered plug-ins of one kind.

    Attributes:
        kind: One of the kinds that discovery knows.
        count: Number of registered names.
        broken: One line for each name that cannot be loaded although its libraries are there.
    """

    kind: str
    count: int
    broken: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Machine:
    """Where this runs.

    Attributes:
        python: Version and implementation.
        executable: The interpreter.
        platform: System, release and processor.
        cores: Cores that this process may use.
        threads: Environment variables of the thread pools, empty where unset.
        kernel_cache: Folder of the compiled kernels.
        compiler: Path of a C compiler, empty if there is none; none is needed.
    """

    python: str
    executable: str
    platform: str
    cores: int
    threads: Mapping[str, str]
    kernel_cache: str
    compiler: str


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """Everything that was found.

    Attributes:
        version: Version of this package.
        origin: Folder of this package.
        machine: Where this runs.
        libraries: Every library.
        plug_ins: Every kind of plug-in.
        warnings: One line for each trap that was found.
    """

    version: str
    origin: str
    machine: Machine
    libraries: tuple[LibraryState, ...]
    plug_ins: tuple[PlugInState, ...]
    warnings: tuple[str, ...]

    @property
    def healthy(self) -> bool:
        """Whether all required parts work."""
        required = all(found.state == "ok" for found in self.libraries if found.library.required)
        return required and not any(kind.broken for kind in self.plug_ins)


def diagnose(libraries: Sequence[Library] = LIBRARIES) -> Diagnosis:
    """Look at this installation; every library is imported once, in a process of its own.

    Args:
        libraries: What to look for.
    """
    entry_points = [(kind, name) for kind in discovery.KINDS for name in _names(kind)]
    answers = probe([library.module for library in libraries], entry_points)
    states = tuple(_library_state(library, answers.get(library.module, "")) for library in libraries)
    plug_ins = tuple(_plug_in_state(kind, answers) for kind in discovery.KINDS)
    return Diagnosis(
        version=_version("torquebench"),
        origin=str(Path(__file__).parent),
        machine=examine_machine(),
        libraries=states,
        plug_ins=plug_ins,
        warnings=tuple(_warnings(states)),
    )


def examine_machine() -> Machine:
    """Return what a comparison's timings depend on."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Machine(
        python=f"{platform.python_version()} ({platform.python_implementation()})",
        executable=sys.executable,
        platform=platform.platform(),
        cores=cores,
        threads={name: os.environ.get(name, "") for name in THREAD_VARIABLES},
        kernel_cache=str(cache_folder("kernels")),
        compiler=next((path for path in map(shutil.which, ("cc", "gcc", "clang")) if path), ""),
    )


def probe(modules: Sequence[str], plug_ins: Sequence[tuple[str, str]] = ()) -> dict[str, str]:
    """Try imports in a process of their own, so that one that crashes takes nobody along.

    Args:
        modules: Names of modules, each in the order given.
        plug_ins: Kinds and names of plug-ins to load after them.

    Returns:
        Module name, or kind and name joined by a slash, to one line on what is wrong; empty if nothing is.
    """
    wanted = [[name] for name in modules] + [list(pair) for pair in plug_ins]
    found: dict[str, str] = {}
    while wanted:
        answers, end = _probe_once(wanted)
        found |= answers
        wanted = wanted[len(answers) :]
        if wanted:
            # The process ended before it answered for this one; the rest gets a process of its own.
            found["/".join(wanted.pop(0))] = end
    return found


# Prints one JSON line for each import on a descriptor of its own: libraries greet on standard output.
_PROBE = """
import importlib, json, os, sys
out = os.fdopen(os.dup(1), "w")
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
for names in json.loads(sys.argv[1]):
    problem = ""
    try:
        if len(names) == 1:
            importlib.import_module(names[0])
        else:
            from torquebench.controllers import discovery
            discovery.load(*names)
    except BaseException as error:
        problem = " ".join(f"{type(error).__name__}: {error}".split())
    print(json.dumps(["/".join(names), problem]), file=out, flush=True)
"""


def _probe_once(wanted: Sequence[Sequence[str]]) -> tuple[dict[str, str], str]:
    """Return the answers that came before the process ended, and how it ended."""
    command = [sys.executable, "-P", "-c", _PROBE, json.dumps(wanted)]
    try:
        run = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            timeout=PROBE_TIMEOUT,
        )
        output, end = run.stdout, f"its import ended the process (status {run.returncode})"
    except subprocess.TimeoutExpired as expired:
        output = expired.stdout.decode() if isinstance(expired.stdout, bytes) else expired.stdout or ""
        end = f"its import took more than {PROBE_TIMEOUT:g} s"
    answers: dict[str, str] = {}
    for line in output.splitlines():
        name, problem = json.loads(line)
        answers[name] = problem
    return answers, end


def _library_state(library: Library, answer: str) -> LibraryState:
    installed, origin = _version(library.distribution), _origin(library.module)
    problem = answer if origin else "not installed"
    if origin and not installed and not problem:
        problem = f"comes from no distribution named {library.distribution!r}"
    return LibraryState(library=library, version=installed, origin=origin, problem=problem)


def _plug_in_state(kind: str, answers: Mapping[str, str]) -> PlugInState:
    """Return the plug-ins of a kind; one whose optional library is missing is not broken."""
    try:
        count = len(discovery.registered(kind))
    except Exception as error:
        return PlugInState(kind=kind, count=0, broken=(" ".join(str(error).split()),))
    optional = [library.module for library in LIBRARIES if not library.required]
    excused = [f"No module named '{module}'" for module in optional]
    broken = tuple(
        f"{name.partition('/')[2]}: {problem}"
        for name, problem in answers.items()
        if name.startswith(f"{kind}/") and problem and not any(excuse in problem for excuse in excused)
    )
    return PlugInState(kind=kind, count=count, broken=broken)


def _names(kind: str) -> tuple[str, ...]:
    try:
        return discovery.names(kind)
    except Exception:
        return ()


def _warnings(states: Sequence[LibraryState]) -> list[str]:
    """Return the traps that people fall into."""
    found = []
    namesake = _distribution("pinocchio")
    if namesake is not None:
        found.append(
            f"the distribution 'pinocchio' {namesake.version} is another package that takes the name of 'pin': "
            "uninstall pinocchio, then reinstall pin"
        )
    versions = {state.library.module: state for state in states}
    bullet = versions.get("pybullet")
    if bullet is not None and bullet.state != "ok" and not bullet.library.required:
        found.append(
            f"PyBullet has no wheel for Python {sys.version_info.major}.{sys.version_info.minor}: "
            "campaigns run on the Pinocchio plant and say so"
        )
    if "PYTHONPATH" in os.environ:
        found.append("PYTHONPATH is set: libraries that it names take precedence over the installed ones")
    return found


def _distribution(name: str) -> Distribution | None:
    try:
        return distribution(name)
    except PackageNotFoundError:
        return None


def _version(name: str) -> str:
    found = _distribution(name)
    return found.version if found is not None else ""


def _origin(module: str) -> str:
    """Return the folder from which a module would be imported, without importing it; empty if there is none."""
    try:
        spec = find_spec(module)
    except (ImportError, ValueError):
        return ""
    if spec is None:
        return ""
    if spec.submodule_search_locations:
        return str(next(iter(spec.submodule_search_locations)))
    return str(Path(spec.origin).parent) if spec.origin else ""
