"""Writes the scripts of single runs, in other processes where there are thousands."""

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from ...scenarios.store import Store
from .atomic import replace_file
from .run_files import file_name, run_script
from .worlds import Run

MANY = 1000
"""Runs from which on other processes pay for their start."""
PART = 64
"""Runs that a process is given at once."""


@contextmanager
def scripts_of(
    store_folder: Path, folder: Path, runs: Sequence[Run], workers: int
) -> Iterator[Callable[[], set[Path]]]:
    """Begin to write the script of each run; where there are many, other processes write while this one goes on.

    Each is written as soon as it is made: all of them would fill memory.

    Args:
        store_folder: Folder of the store that the runs come from.
        folder: Where the scripts go.
        runs: The runs.
        workers: Most processes.

    Yields:
        What returns the files once all are written; it raises an OSError if one cannot be.
    """
    parts = [runs[start : start + PART] for start in range(0, len(runs), PART)]
    write = partial(_write_part, store_folder, folder)
    if workers < 2 or len(runs) < MANY:
        yield lambda: {file for part in parts for file in write(part)}
        return
    # Processes that are started afresh inherit no thread and no open database.
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        found = pool.map(write, parts)
        try:
            yield lambda: {file for files in found for file in files}
        finally:
            pool.shutdown(cancel_futures=True)


def _write_part(store_folder: Path, folder: Path, runs: Sequence[Run]) -> list[Path]:
    with Store.read(store_folder) as store:
        files = {folder / f"{file_name(run)}.js": run for run in runs}
        for file, run in files.items():
            replace_file(file, run_script(run, store))
    return list(files)
