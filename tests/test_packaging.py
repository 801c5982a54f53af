"""What is installed is what stands in the tree, and it answers quickly."""

import json
import re
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SETUPTOOLS = PROJECT["tool"]["setuptools"]
FOLDERS = {package.partition(".")[2]: folder for package, folder in SETUPTOOLS["package-dir"].items()}
ROOMS = ("torquebench", *(folder for folder in FOLDERS.values()))
OPTIONAL = ("torch", "pybullet", "mujoco", "dask", "distributed", "optuna", "matplotlib")
HEAVY = ("torch", "casadi", "control", "plotly", "pybullet", "scipy", "numba", "pinocchio", "proxsuite", "matplotlib")


def folder_of(package: str) -> Path:
    """Return the folder of an installed package name."""
    _, _, rest = package.partition(".")
    room, _, inner = rest.partition(".")
    top = ROOT / FOLDERS[room] if room in FOLDERS else ROOT / "torquebench" / room
    return top / inner.replace(".", "/") if inner else top


def package_of(folder: Path) -> str:
    """Return the installed name of a folder."""
    parts = folder.relative_to(ROOT).parts
    return ".".join(parts if parts[0] == "torquebench" else ("torquebench", *parts))


def room_folders() -> list[Path]:
    """Return the rooms that the tree holds, mapped or not."""
    rooms = ("torquebench", "controllers", "cbmc", "baselines", "scenarios", "evaluation")
    return [ROOT / room for room in rooms if (ROOT / room / "__init__.py").is_file()]


def test_every_package_of_the_tree_is_listed_and_every_listed_one_exists():
    """A sub-package that is not listed works in the checkout and is missing from the wheel."""
    tree = {package_of(file.parent) for room in room_folders() for file in room.rglob("__init__.py")}
    assert set(SETUPTOOLS["packages"]) == tree


def test_every_folder_with_modules_is_a_package():
    """A folder without an ``__init__.py`` is left out of the wheel without a word."""
    folders = {file.parent for room in room_folders() for file in room.rglob("*.py")}
    assert not [str(folder.relative_to(ROOT)) for folder in folders if not (folder / "__init__.py").is_file()]


def test_every_data_file_is_shipped():
    """Data that a glob misses are found in the checkout only."""
    packages = {folder_of(package): package for package in SETUPTOOLS["packages"]}
    missing = []
    for room in room_folders():
        for file in room.rglob("*"):
            if not file.is_file() or file.suffix in (".py", ".pyc") or "__pycache__" in file.parts:
                continue
            # The nearest package above a file may ship it.
            owner = next(folder for folder in file.parents if folder in packages)
            globs = SETUPTOOLS["package-data"].get(packages[owner], [])
            name = file.relative_to(owner).as_posix()
            if not any(fnmatch(name, glob) and name.count("/") == glob.count("/") for glob in globs):
                missing.append(file.relative_to(ROOT).as_posix())
    assert not missing


def test_the_metadata_that_is_installed_is_that_of_the_tree():
    """After a line in pyproject.toml an editable installation must be renewed: names are read from its metadata."""
    from importlib.metadata import distribution

    installed = {(point.group, point.name, point.value) for point in distribution("torquebench").entry_points}
    declared = {
        (group, name, value)
        for group, points in PROJECT["project"].get("entry-points", {}).items()
        for name, value in points.items()
    }
    declared |= {("console_scripts", name, value) for name, value in PROJECT["project"]["scripts"].items()}
    assert installed == declared


def test_every_entry_point_resolves():
    """A registered name that cannot be loaded is found here and not in the middle of a campaign."""
    points = {
        f"{group}: {name}": value
        for group, entries in PROJECT["project"].get("entry-points", {}).items()
        for name, value in entries.items()
    }
    program = """
import functools, importlib, json, sys
failed = {}
for name, value in json.loads(sys.argv[1]).items():
    module, _, attribute = value.partition(":")
    try:
        functools.reduce(getattr, attribute.split("."), importlib.import_module(module))
    except ModuleNotFoundError as error:
        failed[name] = ["missing", error.name or ""]
    except Exception as error:
        failed[name] = ["broken", f"{type(error).__name__}: {error}"]
print(json.dumps(failed))
"""
    failed = json.loads(run_python("-P", "-c", program, json.dumps(points)).splitlines()[-1])
    broken = {name: reason for name, (kind, reason) in failed.items() if kind == "broken" or reason not in OPTIONAL}
    assert not broken


def test_the_rooms_are_no_top_level_modules():
    """With the root on the path every class would exist twice, and isinstance would lie."""
    doubled = [room for room in ROOMS if room != "torquebench" and room in sys.modules]
    assert not doubled
    from torquebench.controllers import Controller

    assert Controller.__module__ == "torquebench.controllers.controller"


def test_help_imports_nothing_heavy():
    """``--help`` answers at once, whatever a controller needs."""
    if find_spec("torquebench.cli") is None:
        pytest.skip("there is no command line yet")
    program = f"""
import sys
sys.argv = ["torquebench", "--help"]
try:
    from torquebench.cli import main
    main()
except SystemExit as end:
    assert not end.code, end.code
sys.stdout.flush()
print("\\n" + " ".join(name for name in {HEAVY!r} if name in sys.modules))
"""
    assert run_python("-P", "-c", program).splitlines()[-1].split() == []


# Folders that exist on one machine only, and hosts from which one machine installs; split so as not to find itself.
FOREIGN = re.compile(
    r"(?<![\w.$}/-])/(?:home|root|Users|work|opt|mnt|srv)/\w|"
    r"(?:files\.)?python"
    + r"hosted\.org|pypi\."
    + r"org/simple|download\."
    + r"pytorch\.org|(?:extra-)?index"
    + r"-url"
)


def own_files() -> list[Path]:
    """Return the text files of the project."""
    suffixes = {".py", ".toml", ".md", ".cfg", ".ini", ".yml", ".yaml", ".json", ".html", ".js", ".css", ".sh", ""}
    tops = [*room_folders(), *(ROOT / name for name in ("tests", "benchmarks", "examples", "docs", ".ci"))]
    files = [file for top in tops if top.is_dir() for file in top.rglob("*")]
    files += [file for file in ROOT.iterdir() if not file.name.startswith(".")]
    skipped = {"__pycache__", "node_modules", "results", "build", "dist"}
    return [file for file in files if file.is_file() and file.suffix in suffixes and not skipped & set(file.parts)]


def test_no_file_names_a_machine_or_a_package_index():
    """A clone works anywhere: paths are relative, indexes are the installer's business."""
    found = []
    for file in own_files():
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
            if FOREIGN.search(line):
                found.append(f"{file.relative_to(ROOT)}:{number}: {line.strip()[:100]}")
    assert not found, "\n".join(found)


@pytest.mark.parametrize("line", ["open('/" + "home/me/x.csv')", "cd /" + "work/x", "pip --extra-index" + "-url x"])
def test_machine_paths_are_recognised(line):
    assert FOREIGN.search(line)


@pytest.mark.parametrize("line", ["results/home/x", "/tmp/x", "#!/usr/bin/env bash", "evaluation/work/x", "a /root"])
def test_other_paths_are_left_alone(line):
    assert not FOREIGN.search(line)


def run_python(*arguments: str) -> str:
    """Run this interpreter and return what it printed."""
    run = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    return run.stdout
