"""From a run store to the files of a report."""

import os
import re
import tempfile
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from ...controllers import InvalidInput
from ...scenarios.store import Store
from .exports import comparisons_csv, probes_csv, runs_csv, summary_json
from .findings import find_all
from .page import render
from .panels import panels_of
from .table_files import table_files
from .worlds import worlds_of

FOLDER = "report"
"""Where a report goes within its store."""
FIGURES, TABLES = "figures", "tables"
"""Where its figures and its tables go within it."""
OURS = re.compile(r"w\d[\w-]*\.(svg|csv|md|tex)|(definitions-table|gate-\d+)\.(csv|md|tex)")
"""Names of the files that a report puts there."""


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


def write_report(store_folder: Path, out: Path | None = None) -> ReportFiles:
    """Write the report of a run store; the same store gives the same bytes.

    All texts are made before the first file is touched, and each file is replaced as a whole, so a report that cannot
    be written leaves the old one as it was.

    Args:
        store_folder: Folder of the store.
        out: Folder of the report; ``report`` within the store if None.

    Returns:
        What was written.

    Raises:
        InvalidInput: If the folder holds no run store, or one that cannot be read, or the report cannot be written.
    """
    with Store.read(Path(store_folder)) as store:
        stored, campaigns = store.runs(), store.campaigns()
        findings = find_all(worlds_of(stored, campaigns))
        panels = [panels_of(found, store) for found in findings]
    page, figures, tables = render(findings, panels, campaigns)
    texts = {
        **{f"{FIGURES}/{name}": text for name, text in figures.items()},
        **{f"{TABLES}/{name}": text for name, text in table_files(tables).items()},
        "runs.csv": runs_csv(findings),
        "comparisons.csv": comparisons_csv(findings),
        "summary.json": summary_json(findings, panels, campaigns),
        "index.html": page,
    }
    if probes := probes_csv(findings):
        texts["probes.csv"] = probes
    folder = Path(store_folder) / FOLDER if out is None else Path(out)
    try:
        for part in (FIGURES, TABLES):
            (folder / part).mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            _replace(folder / name, text)
        for part in (FIGURES, TABLES):
            _clear(folder / part, {name.partition("/")[2] for name in texts if name.startswith(f"{part}/")})
    except OSError as cause:
        raise InvalidInput(
            f"cannot be written ({cause.strerror})", str(folder), "name another folder for the report"
        ) from cause
    paths = (folder / name for name in ("index.html", "summary.json", "runs.csv", "comparisons.csv", FIGURES, TABLES))
    return ReportFiles(*paths)


def _clear(folder: Path, kept: Collection[str]) -> None:
    """Remove what the page no longer has: it would outlive its data."""
    for file in folder.iterdir():
        if OURS.fullmatch(file.name) and file.name not in kept:
            file.unlink()


def _replace(file: Path, text: str) -> None:
    """Write a file under a temporary name and put it in place."""
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
