"""From a run store to the files of a report."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ...controllers import InvalidInput
from ...scenarios.store import Store
from .atomic import replace_file
from .claims import ClaimsPanel, claims_of
from .conformance import ConformanceOf, conformance_table, no_conformance
from .efficiency import CostsOf, no_costs
from .exports import comparisons_csv, probes_csv, runs_csv, summary_json
from .findings import Findings, find_all
from .gravity import GravityOf, no_gravity
from .page import render
from .panels import Panels, panels_of
from .run_files import all_runs, robot_key
from .script_files import scripts_of
from .table import Table
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
    workers: int = 1,
) -> ReportFiles:
    """Write the report of a run store; the same store gives the same bytes.

    Scripts of single runs apart, all texts are made before the first file is touched, and each file is replaced as a
    whole, so a report that cannot be made leaves the old page as it was.

    Args:
        store_folder: Folder of the store.
        out: Folder of the report; ``report`` within the store if None.
        costs_of: Knows what controllers compute; asked once for each.
        gravity_of: Knows how well the patterns of spiking controllers know gravity; asked once for each world.
        conformance_of: Checks the contract of controllers; asked once for each.
        skeleton_of: Knows the arms that the replay draws.
        workers: Processes that write the scripts of single runs, where there are many; more than one must not be asked
            for by a program that starts itself again when it is imported.

    Returns:
        What was written.

    Raises:
        InvalidInput: If the folder holds no run store, or one that cannot be read, or the report cannot be written.
    """
    folder = Path(store_folder) / FOLDER if out is None else Path(out)
    with Store.read(Path(store_folder)) as store, _told_in_one_line(folder):
        findings = find_all(worlds_of(store.runs(), store.campaigns()))
        runs = all_runs([found.world for found in findings])
        _make_folders(folder)
        with scripts_of(Path(store_folder), folder / RUNS, runs, workers) as scripts:
            panels = [panels_of(found, store, costs_of, gravity_of) for found in findings]
            claims = claims_of(findings, panels, store)
            checked = conformance_table(runs, conformance_of)
            texts = _texts(findings, panels, store.campaigns(), claims, checked, _robots(runs, skeleton_of))
            # Scripts come before the page that asks for them.
            written = scripts()
        _write(folder, texts, written)
    paths = (folder / name for name in ("index.html", "summary.json", "runs.csv", "comparisons.csv", FIGURES, TABLES))
    return ReportFiles(*paths)


def _texts(
    findings: Sequence[Findings],
    panels: Sequence[Panels],
    campaigns: Sequence[Mapping[str, object]],
    claims: ClaimsPanel | None,
    conformance: Table,
    robots: Mapping[str, object],
) -> dict[str, str]:
    """Return all files but the scripts of single runs, by name."""
    page, figures, tables = render(findings, panels, campaigns, claims, conformance, robots)
    probes = probes_csv(findings)
    return {
        **{f"{FIGURES}/{name}": text for name, text in figures.items()},
        **{f"{TABLES}/{name}": text for name, text in table_files(tables).items()},
        "runs.csv": runs_csv(findings),
        "comparisons.csv": comparisons_csv(findings),
        "summary.json": summary_json(findings, panels, campaigns, claims),
        "index.html": page,
        **({"probes.csv": probes} if probes else {}),
    }


def _make_folders(folder: Path) -> None:
    for part in (FIGURES, TABLES, RUNS):
        (folder / part).mkdir(parents=True, exist_ok=True)


def _write(folder: Path, texts: Mapping[str, str], scripts: set[Path]) -> None:
    """Write files, and take away figures, tables and scripts that are not among them: they would outlive their data."""
    for name, text in texts.items():
        replace_file(folder / name, text)
    written = scripts | {folder / name for name in texts}
    ours = {file for part in (FIGURES, TABLES) for file in (folder / part).iterdir() if OURS.fullmatch(file.name)}
    for file in {*ours, *(folder / RUNS).glob("*.js")} - written:
        file.unlink()


@contextmanager
def _told_in_one_line(folder: Path) -> Iterator[None]:
    """Turn what keeps a file from being written into one line."""
    try:
        yield
    except OSError as cause:
        raise InvalidInput(
            f"cannot be written ({cause.strerror})", str(folder), "name another folder for the report"
        ) from cause


def _robots(runs: Iterable[Run], skeleton_of: SkeletonOf) -> dict[str, object]:
    """Return what is drawn of each arm, by the name that the runs have for it."""
    found = {robot_key(run): run.stored.specification for run in runs}
    drawn = {key: skeleton_of(run.robot, run.tool) for key, run in found.items()}
    return {key: skeleton for key, skeleton in drawn.items() if skeleton is not None}
