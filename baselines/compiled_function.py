"""CasADi functions as machine code: compiled once, kept under a hash, called without allocation.

A plain call of a CasADi function from Python converts every argument; through its buffer it works on fixed arrays, and
compiled it runs some thirty times as fast as the interpreter. Where no C compiler is installed the interpreter does the
same arithmetic through the same buffers, to the same bits: the compiler is not allowed to contract products and sums.
"""

import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path

import casadi as ca
import numpy as np

from ..controllers import cache_folder

COMPILERS = ("cc", "gcc", "clang")
"""Tried in this order; the environment variable ``CC`` goes before."""

FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC")

PATIENCE = 120.0
"""Longest time for a compilation [s]."""


class BufferedFunction:
    """A CasADi function on fixed arrays, evaluated at several points in one call.

    CasADi counts columns first: an output of shape (r, c) at k points is an array of shape (k, c, r) here.

    Attributes:
        inputs: Name to array, to be filled by the caller: shape (points, size), or (size,) if shared by all points.
        outputs: Name to array, refilled by each call: shape (points, columns, rows), or (points, rows) of a vector.
        is_compiled: Whether it runs as machine code.
    """

    def __init__(self, function: ca.Function, *, points: int, shared: Sequence[str] = ()) -> None:
        """Compile or take from the cache, and allocate.

        Args:
            function: The function at one point; its inputs are vectors.
            points: Number of points.
            shared: Names of the inputs that all points have in common.
        """
        names = function.name_in()
        mapped = function.map(function.name(), "serial", points, [names.index(name) for name in shared], [])
        library = compiled_library(mapped)
        self.is_compiled = library is not None
        self._function = mapped if library is None else ca.external(mapped.name(), str(library))
        self.inputs = {
            name: np.zeros(function.size1_in(name) if name in shared else (points, function.size1_in(name)))
            for name in names
        }
        self.outputs = {name: np.zeros(_shape(function, name, points)) for name in function.name_out()}
        # The buffer points into the arrays; both must live as long as the function does.
        self._buffer, self._evaluate = self._function.buffer()
        for index, array in enumerate(self.inputs.values()):
            self._buffer.set_arg(index, array.data)  # type: ignore[call-arg]
        for index, array in enumerate(self.outputs.values()):
            self._buffer.set_res(index, array.data)  # type: ignore[call-arg]

    def __call__(self) -> Mapping[str, np.ndarray]:
        """Evaluate at what the inputs hold, and return the outputs."""
        self._evaluate()
        return self.outputs


def _shape(function: ca.Function, name: str, points: int) -> tuple[int, ...]:
    rows, columns = function.size_out(name)
    return (points, rows) if columns == 1 else (points, columns, rows)


def compiled_library(function: ca.Function) -> Path | None:
    """Return the shared library of a function, compiled if the cache has none; None without a working C compiler.

    The name is a hash of the C source, in which the model is written out, the flags, CasADi's version, the compiler
    and the processor. Several processes may compile at once: each writes a file of its own and moves it into place.

    Args:
        function: What to compile.
    """
    compiler = find_compiler()
    if compiler is None:
        return None
    generator = ca.CodeGenerator(f"{function.name()}.c")
    generator.add(function)
    source = generator.dump()
    parts = (source, *FLAGS, version("casadi"), compiler, _version_of(compiler), _processor())
    name = f"{function.name()}_{hashlib.sha256(chr(0).join(parts).encode()).hexdigest()[:24]}.so"
    library = cache_folder("casadi") / name
    if library.is_file() or _compile(source, compiler, library):
        return library
    return None


def find_compiler() -> str | None:
    """Return the path of a C compiler, None if there is none."""
    named = os.environ.get("CC", "")
    found = (shutil.which(name) for name in (named, *COMPILERS) if name)
    return next((path for path in found if path), None)


def _compile(source: str, compiler: str, library: Path) -> bool:
    """Compile into place, and return whether that worked."""
    with tempfile.TemporaryDirectory(dir=library.parent) as folder:
        written, built = Path(folder) / "source.c", Path(folder) / "built.so"
        written.write_text(source, encoding="utf-8")
        command = [compiler, *FLAGS, str(written), "-o", str(built), "-lm"]
        try:
            done = subprocess.run(command, capture_output=True, timeout=PATIENCE, check=False)
        except (OSError, subprocess.TimeoutExpired):
            return False
        if done.returncode or not built.is_file():
            return False
        os.replace(built, library)
    return True


@cache
def _version_of(compiler: str) -> str:
    try:
        asked = subprocess.run([compiler, "--version"], capture_output=True, text=True, timeout=PATIENCE, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return "unknown"
    return asked.stdout


@cache
def _processor() -> str:
    """Return what tells processors apart: code for one may not run on another."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor()
    facts = [line for line in text.splitlines() if line.startswith(("model name", "flags", "Features"))]
    return "\n".join((platform.machine(), *sorted(set(facts))))
