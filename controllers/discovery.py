"""Finds plug-ins by four doors: a registered name, ``package.module:Name``, ``./file.py:Name``, a Python object.

Names are listed from package metadata without importing anything; a plug-in is imported when it is used.
"""

import ast
import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Iterable
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType

from .errors import InvalidInput, PlugInFailure, UnknownName

KINDS = ("controllers", "knowledge", "metrics", "trajectories", "loads", "plants", "robots")
SINGULAR = {"controllers": "controller", "metrics": "metric", "trajectories": "trajectory", "loads": "load"} | {
    "knowledge": "knowledge level",
    "plants": "plant",
    "robots": "robot",
}


@lru_cache(maxsize=len(KINDS))
def registered(kind: str) -> dict[str, EntryPoint]:
    """Return the registered names of one kind and where each points, without importing.

    Args:
        kind: One of :data:`KINDS`.

    Raises:
        UnknownName: If the kind does not exist.
        InvalidInput: If two distributions register one name for different objects.
    """
    if kind not in KINDS:
        raise UnknownName("kind of plug-in", kind, KINDS)
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=f"torquebench.{kind}"):
        other = found.setdefault(point.name, point)
        if other.value != point.value:
            raise InvalidInput(
                f"two distributions register the {SINGULAR[kind]} {point.name!r}: "
                f"{_origin(other)} and {_origin(point)}",
                valid="uninstall one of them",
            )
    return found


def names(kind: str) -> tuple[str, ...]:
    """Return the registered names of one kind."""
    return tuple(registered(kind))


def load(kind: str, name: object) -> object:
    """Return the object behind a door.

    Args:
        kind: One of :data:`KINDS`.
        name: A registered name, ``package.module:Name``, ``./file.py:Name``, or any other object, which is returned.

    Raises:
        UnknownName: If nobody registered the name.
        InvalidInput: If the file or the name inside it does not exist.
        PlugInFailure: If the import fails.
    """
    if not isinstance(name, str):
        return name
    if ":" in name:
        return _from_path(kind, name)
    known = registered(kind)
    if name not in known:
        raise UnknownName(SINGULAR[kind], name, tuple(known))
    try:
        return known[name].load()
    except (Exception, SystemExit) as cause:
        raise PlugInFailure(SINGULAR[kind], name, _origin(known[name]), cause) from cause


def source_digest(kind: str, name: object) -> str:
    """Return the SHA-256 of the source behind a door, empty for what this package registers itself."""
    if isinstance(name, str) and ":" not in name:
        point = registered(kind).get(name)
        if point is None or point.value.startswith("torquebench."):
            return ""
        name = point.value
    if isinstance(name, str):
        module, _, _ = name.rpartition(":")
        origin = module if module.endswith(".py") else _module_file(module)
    else:
        owner = name if isinstance(name, type) else type(name)
        origin = getattr(sys.modules.get(owner.__module__), "__file__", None)
    return hashlib.sha256(Path(origin).read_bytes()).hexdigest() if origin and Path(origin).is_file() else ""


def meaning(point: EntryPoint) -> str:
    """Return the first line of the documentation behind a registered name, read from its source without running it.

    Args:
        point: Where a name points.

    Returns:
        The line; empty where there is no source or no documentation.
    """
    file = _module_file(point.module)
    if file is None:
        return ""
    body = ast.parse(Path(file).read_text(encoding="utf-8")).body
    for here, after in zip(body, [*body[1:], None], strict=True):
        if getattr(here, "name", "") == point.attr and isinstance(here, ast.ClassDef | ast.FunctionDef):
            return (ast.get_docstring(here) or "").partition("\n")[0]
        targets = here.targets if isinstance(here, ast.Assign) else []
        if any(isinstance(target, ast.Name) and target.id == point.attr for target in targets):
            text = after.value if isinstance(after, ast.Expr) else None
            return str(text.value).partition("\n")[0] if isinstance(text, ast.Constant) else ""
    return ""


def _from_path(kind: str, name: str) -> object:
    """Load ``module:Name`` or ``file.py:Name``."""
    where, _, attribute = name.rpartition(":")
    if where.endswith(".py") and not Path(where).is_file():
        raise InvalidInput(f"no such file {where!r}", f"{SINGULAR[kind]} {name!r}", "expected ./file.py:Name")
    try:
        module = _import_file(Path(where)) if where.endswith(".py") else importlib.import_module(where)
    except (Exception, SystemExit) as cause:
        raise PlugInFailure(SINGULAR[kind], name, where, cause) from cause
    found: object = module
    for part in attribute.split("."):
        if not hasattr(found, part):
            raise UnknownName(f"name in {where}", attribute, _public_names(vars(module)))
        found = getattr(found, part)
    return found


@lru_cache(maxsize=64)
def _import_file(path: Path) -> ModuleType:
    """Import a file once per process under a name of its own, so that its classes can be pickled and compared."""
    unique = f"torquebench_file_{hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]}_{path.stem}"
    specification = importlib.util.spec_from_file_location(unique, path)
    if specification is None or specification.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = importlib.util.module_from_spec(specification)
    sys.modules[unique] = module
    try:
        specification.loader.exec_module(module)
    except BaseException:
        del sys.modules[unique]
        raise
    return module


def _module_file(module: str) -> str | None:
    """Return where a module's source stands, None if it cannot be found: loading it will say why."""
    try:
        return getattr(importlib.util.find_spec(module), "origin", None)
    except (ImportError, ValueError):
        return None


def _public_names(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(name for name in names if not name.startswith("_"))


def _origin(point: EntryPoint) -> str:
    """Return distribution and target of an entry point for messages."""
    distribution = point.dist.name if point.dist is not None else "unknown distribution"
    return f"{distribution}, {point.value}"
