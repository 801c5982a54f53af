"""Who may import whom: the rooms stay apart, so that each can be read, tested and replaced alone."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("controllers", "cbmc", "baselines", "scenarios", "evaluation", "torquebench")
ALLOWED_ROOMS = {
    "controllers": {"controllers"},
    "cbmc": {"cbmc", "controllers"},
    "baselines": {"baselines", "controllers"},
    "scenarios": {"scenarios", "controllers"},
    "evaluation": {"evaluation", "scenarios", "controllers"},
    "torquebench": set(ROOMS),
}
STORE = "torquebench.scenarios.store"


class Import(NamedTuple):
    """One import statement, resolved to installed names."""

    module: str
    """Full name of what is imported, for ``from a import b`` that of ``a``."""
    names: tuple[str, ...]
    relative: bool
    inside: bool
    """Whether it stands in a function."""
    where: str


def source_files(room: str) -> list[Path]:
    return sorted((ROOT / room).rglob("*.py")) if (ROOT / room).is_dir() else []


def installed_name(file: Path) -> list[str]:
    """Return the package that holds a file, as a list of its parts."""
    parts = list(file.relative_to(ROOT).parent.parts)
    return parts if parts[0] == "torquebench" else ["torquebench", *parts]


def imports_of(file: Path) -> Iterator[Import]:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    functions = [
        node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
    ]
    inner = {id(node) for function in functions for node in ast.walk(function)}
    for node in ast.walk(tree):
        where = f"{file.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"
        inside = id(node) in inner
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(alias.name, (), False, inside, where)
        elif isinstance(node, ast.ImportFrom):
            names = tuple(alias.name for alias in node.names)
            if node.level == 0:
                yield Import(node.module or "", names, False, inside, where)
                continue
            package = installed_name(file)
            base = package[: len(package) - node.level + 1]
            yield Import(".".join([*base, *(node.module or "").split(".")]).rstrip("."), names, True, inside, where)


def rooms_of(found: Import) -> set[str]:
    """Return the rooms that an import reaches."""
    parts = found.module.split(".")
    if parts[0] != "torquebench":
        return {parts[0]} & set(ROOMS)
    if len(parts) == 1:
        return {name if name in ROOMS else "torquebench" for name in found.names}
    return {parts[1] if parts[1] in ROOMS else "torquebench"}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_only_the_rooms_it_may(room):
    """Controllers know no harness, laws know no other laws, metrics know no simulator."""
    wrong = [
        f"{found.where} imports {found.module}"
        for file in source_files(room)
        for found in imports_of(file)
        if not rooms_of(found) <= ALLOWED_ROOMS[room]
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("room", ROOMS)
def test_imports_between_rooms_are_relative(room):
    """An absolute import of an own room makes a second copy of its classes when a root folder is on the path."""
    wrong = [
        f"{found.where} imports {found.module}"
        for file in source_files(room)
        for found in imports_of(file)
        if not found.relative and found.module.split(".")[0] in ROOMS
    ]
    assert not wrong, "\n".join(wrong)


def test_evaluation_reads_the_store_and_the_contract_only_in_the_report():
    """A metric must work on a log that no simulator made; the report reads runs and says what was wrong with them."""
    report = ROOT / "evaluation" / "report"
    wrong = [
        f"{found.where} imports {found.module}"
        for file in source_files("evaluation")
        for found in imports_of(file)
        if rooms_of(found) & {"scenarios", "controllers"}
        and not (file.is_relative_to(report) and ("controllers" in rooms_of(found) or found.module == STORE))
    ]
    assert not wrong, "\n".join(wrong)


def metric_files() -> list[Path]:
    """Return everything of metrics and statistics, each a module or a package."""
    room = ROOT / "evaluation"
    files = [room / "statistics.py", *(room / "metrics").rglob("*.py"), *(room / "statistics").rglob("*.py")]
    return sorted(file for file in files if file.is_file())


def test_metrics_and_statistics_need_numpy_and_inside_functions_scipy():
    """An analyst with a CSV of her own robot installs and imports nothing heavy."""
    wrong = [
        f"{found.where} imports {found.module}"
        for file in metric_files()
        for found in imports_of(file)
        if not _belongs_in_a_metric(found)
    ]
    assert metric_files()
    assert not wrong, "\n".join(wrong)


def _belongs_in_a_metric(found: Import) -> bool:
    top = found.module.split(".")[0]
    if top == "scipy":
        return found.inside
    return top in ({"numpy"} | sys.stdlib_module_names) or rooms_of(found) == {"evaluation"}


@pytest.mark.parametrize(
    ("text", "rooms"),
    [
        ("from ..controllers import Task", {"controllers"}),
        ("from .. import scenarios", {"scenarios"}),
        ("from ..scenarios.store import Store", {"scenarios"}),
        ("import torquebench.cbmc", {"cbmc"}),
        ("import baselines", {"baselines"}),
        ("from . import gains", {"baselines"}),
        ("import numpy", set()),
    ],
)
def test_an_import_is_attributed_to_its_room(text, rooms, tmp_path, monkeypatch):
    """The rule is worth what its reader is worth."""
    monkeypatch.setattr(sys.modules[__name__], "ROOT", tmp_path)
    (tmp_path / "baselines").mkdir()
    file = tmp_path / "baselines" / "law.py"
    file.write_text(text, encoding="utf-8")
    (found,) = imports_of(file)
    assert rooms_of(found) == rooms
