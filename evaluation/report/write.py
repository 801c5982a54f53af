"""From a run store to the files of a report."""

import os
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from ...controllers import InvalidInput
from ...scenarios.store import Store
from .claims import claims_of
from .conformance import ConformanceOf, conformance_table, no_conformance
from .efficiency import CostsOf, no_costs
from .exports import comparisons_csv, probes_csv, runs_csv, summary_json
from .findings import find_all
from .gravity import GravityOf, no_gravity
from .page import render
from .panels import panels_of
from .run_files import all_runs, file_name, robot_key, run_script
from .table_files import table_files
from .worlds import Run, worlds_of

FOLDER = "report"
"""Where a report goes within its store."""
FIGURES, TABLES = "figures", "tables"
"""Where its figures and its tables go within it."""
RUNS = "runs"
"""Where what the page loads of each run goes within it."""
OURS = re.compile(
    r"w\d[\w-]*\.(svg|csv|md|tex)|(claims[\w-]*|(sensitivity|conformance|definitions)-table|gate-\d+)\.(csv|md|tex)"
)
"""Names of the figures and tables that a report puts there."""

SkeletonOf = Callable[[str, str], Mapping[str, object] | None]
"""Takes name and tool point of a robot to what the replay draws of it, None if it is not there."""


def no_skeleton(robot: str, tool: str) -> None:
    """Draw no arm."""


@dataclass(frozen=True)
class ReportFiles:
    """The files of a report.

    Attributes:
        index: The page.
        summary: Every figure of the page, for programs.
        runs: One row for each run.
        comparisons: One row for each comparison with a reference.
        figures: Folder with every figure of the page as an SVG file.
        tables: Folder with every table of the page as CSV, Markdown and LaTeX.
    """

    index: Path
    summary: Path
    runs: Path
    comparisons: Path
    figures: Path
    tables: Path


def write_report(
    store_folder: Path,
    out: Path | None = None,
    *,
    costs_of: CostsOf = no_costs,
    gravity_of: GravityOf = no_gravity,
    conformance_of: ConformanceOf = no_conformance,
    skeleton_of: SkeletonOf = no_skeleton,
) -> ReportFiles:
    """Write the report of a run store; the same store gives the same bytes.

    All texts but those of single runs are made before the first file is touched, and each file is replaced as a whole,
    so a report that cannot be written leaves the old one as it was.

    Args:
        store_folder: Folder of the store.
        out: Folder of the report; ``report`` within the store if None.
        costs_of: Knows what controllers compute; asked once for each.
        gravity_of: Knows how well the patterns of spiking controllers know gravity; asked once for each world.
        conformance_of: Checks the contract of controllers; asked once for each.
        skeleton_of: Knows the arms that the replay draws.

    Returns:
        What was written.

    Raises:
        InvalidInput: If the folder holds no run store, or one that cannot be read, or the report cannot be written.
    """
    with Store.read(Path(store_folder)) as store:
        stored, campaigns = store.runs(), store.campaigns()
        findings = find_all(worlds_of(stored, campaigns))
        panels = [panels_of(found, store, costs_of, gravity_of) for found in findings]
        claims = claims_of(findings, panels, store)
        runs = all_runs([found.world for found in findings])
        conformance = conformance_table(runs, conformance_of)
        page, figures, tables = render(findings, panels, campaigns, claims, conformance, _robots(runs, skeleton_of))
        texts = {
            **{f"{FIGURES}/{name}": text for name, text in figures.items()},
            **{f"{TABLES}/{name}": text for name, text in table_files(tables).items()},
            "runs.csv": runs_csv(findings),
            "comparisons.csv": comparisons_csv(findings),
            "summary.json": summary_json(findings, panels, campaigns, claims),
            "index.html": page,
        }
        if probes := probes_csv(findings):
            texts["probes.csv"] = probes
        # Thousands of scripts are written one by one, before the page that asks for them: all at once they fill memory.
        scripts = ((f"{RUNS}/{file_name(run)}.js", run_script(run, store)) for run in runs)
        folder = Path(store_folder) / FOLDER if out is None else Path(out)
        _write(folder, chain(scripts, texts.items()))
    paths = (folder / name for name in ("index.html", "summary.json", "runs.csv", "comparisons.csv", FIGURES, TABLES))
    return ReportFiles(*paths)


def _write(folder: Path, texts: Iterable[tuple[str, str]]) -> None:
    """Write files, and take away figures, tables and scripts that are not among them: they would outlive their data."""
    try:
        for part in (FIGURES, TABLES, RUNS):
            (folder / part).mkdir(parents=True, exist_ok=True)
        written = set()
        for name, text in texts:
            _replace(folder / name, text)
            written.add(folder / name)
        ours = {file for part in (FIGURES, TABLES) for file in (folder / part).iterdir() if OURS.fullmatch(file.name)}
        for file in {*ours, *(folder / RUNS).glob("*.js")} - written:
            file.unlink()
    except OSError as cause:
        raise InvalidInput(
            f"cannot be written ({cause.strerror})", str(folder), "name another folder for the report"
        ) from cause


def _robots(runs: Iterable[Run], skeleton_of: SkeletonOf) -> dict[str, object]:
    """Return what is drawn of each arm, by the name that the runs have for it."""
    found = {robot_key(run): run.stored.specification for run in runs}
    drawn = {key: skeleton_of(run.robot, run.tool) for key, run in found.items()}
    return {key: skeleton for key, skeleton in drawn.items() if skeleton is not None}


def _replace(file: Path, text: str) -> None:
    """Write a file under a temporary name and put it in place; what is there already is left alone."""
    if file.is_file() and file.read_bytes() == text.encode():
        return
    descriptor, temporary = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.", suffix=".tmp")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
        # A temporary file is private to its owner; a report is made to be shared.
        os.chmod(temporary, 0o644)
        os.replace(temporary, file)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
