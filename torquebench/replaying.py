"""Goes back to a stored run: its place on the page, and what another controller would have answered in it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .controllers import InvalidInput
from .evaluation.report.worlds import worlds_of
from .evaluation.report.write import FOLDER
from .repeating import rows_at
from .reporting import report
from .scenarios.execution import record
from .scenarios.feeding import feed
from .scenarios.latency import MEASURED
from .scenarios.store import Store, StoredRun
from .scenarios.trial import Trial
from .scoring import score


@dataclass(frozen=True, kw_only=True)
class Answers:
    """How the answers of one controller differ from the torques of a run.

    Attributes:
        controller: Who was fed.
        ticks: Ticks that it answered.
        of: Ticks of the run.
        rms: Root mean square of the difference of the commands, joint by joint, shape (n,) [N m].
        peak: Its largest magnitude, joint by joint, shape (n,) [N m].
        first: Number and time [s] of the first tick that is not the same to the bit; None if all are.
        failure: What ended it early, empty if it answered to the end.
    """

    controller: str
    ticks: int
    of: int
    rms: tuple[float, ...]
    peak: tuple[float, ...]
    first: tuple[int, float] | None
    failure: str


def stored_rows(folder: Path, address: str) -> list[StoredRun]:
    """Return the rows of an address in a results folder, the run itself first; see :func:`~.repeating.rows_at`."""
    with Store.read(folder) as store:
        return rows_at(store.runs(), address)


def place_on_page(folder: Path, address: str) -> str:
    """Return the URL of a run in the report of a results folder; a report that is not there yet is written.

    Args:
        folder: The folder.
        address: The run's address, or as many of its first digits as tell it apart.

    Raises:
        TorquebenchError: If there is no store, or no such run in the report.
    """
    with Store.read(folder) as store:
        rows = rows_at(store.runs(), address)
        worlds = worlds_of(store.runs(), store.campaigns())
    runs = [run for world in worlds for run in (*world.runs, *world.twins)]
    anchors = [run.anchor for run in runs if run.stored.address == rows[0].address]
    if not anchors:
        why = "is a study" if rows[0].specification.study else "has a newer row of the same specification"
        raise InvalidInput(f"run {rows[0].address[:12]} {why}: it has no place on the page", str(folder))
    page = folder / FOLDER / "index.html"
    if not page.is_file():
        page = report(folder)
    return f"{page.resolve().as_uri()}#{anchors[0]}"


def feed_into(row: StoredRun, controller: str, settings: Mapping[str, object]) -> Answers:
    """Run a row again, and feed what its controller saw to another one.

    A trace holds true states; what the sensors gave is had by running the row again, and that it is the same run is
    checked on every figure.

    Args:
        row: The run.
        controller: Name or door of the controller that is fed.
        settings: Its settings; the run's own controller starts from the run's.

    Raises:
        InvalidInput: If the run does not come out the same again, or is no single run.
        TorquebenchError: If a controller cannot be had, or refuses the task.
    """
    specification = row.specification
    trial = _again(row)
    frames = trial.frames
    if frames is None or not len(frames):
        raise InvalidInput(f"run {row.address[:12]} has no tick ({trial.result.reason})", "--into", "name another run")
    own = specification.settings if controller == specification.controller else {}
    fed = feed(specification, frames, controller=controller, settings={**own, **settings})
    returned = frames["command"][: len(fed.command)]
    # NaN in both is the same answer: a run may have ended with it.
    same = (fed.command == returned) | (np.isnan(fed.command) & np.isnan(returned))
    difference = np.where(same, 0.0, fed.command - returned)
    apart = np.flatnonzero(~same.all(axis=1))
    return Answers(
        controller=controller,
        ticks=len(fed.command),
        of=len(frames),
        rms=tuple(np.sqrt(np.mean(difference**2, axis=0)).tolist()) if len(difference) else (),
        peak=tuple(np.abs(difference).max(axis=0).tolist()) if len(difference) else (),
        first=(int(apart[0]), float(fed.times[apart[0]])) if apart.size else None,
        failure=fed.failure,
    )


def _again(row: StoredRun) -> Trial:
    """Run a row again, and insist that it is the same run."""
    if row.specification.latency == MEASURED:
        raise InvalidInput(f"run {row.address[:12]} has measured latency", "--into", "a wall time does not come again")
    trial = record(row.specification, evaluate=score)
    stored, now = row.result, trial.result
    # The windows of load events were judged with twins, which do not run here.
    windows = {name: stored.metrics.get(name) for name in now.metrics}
    before = (stored.status, stored.failed_at, windows, stored.laps, stored.counts)
    after = (now.status, now.failed_at, now.metrics, now.laps, now.counts)
    if _text(before) != _text(after):
        valid = "code, data or libraries are not those that it ran with; run its benchmark again"
        raise InvalidInput(f"run {row.address[:12]} does not come out the same again", "--into", valid)
    return trial


def _text(values: Sequence[object]) -> str:
    return json.dumps(values, sort_keys=True)
