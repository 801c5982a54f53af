"""Runs a benchmark into a store and writes its report: the one function behind ``torquebench run``."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .controllers import InvalidInput
from .judging import JUDGES
from .reporting import report
from .scenarios.benchmark import load_benchmark
from .scenarios.campaign import Campaign, Finished, plan_campaign, predicted_time, run_campaign
from .scenarios.execution import TRACE_KINDS
from .scenarios.latency import Latency
from .scenarios.result import FAILED, REFUSED
from .scenarios.store import DATABASE, Store
from .scoring import score, score_events

Watch = Callable[[Campaign, Finished | None], None]
"""Is told of the campaign before its first run, and of every run after it was written."""


@dataclass(frozen=True, kw_only=True)
class RunReport:
    """What a call of :func:`run` did.

    Attributes:
        folder: The store.
        total: Runs that the benchmark, or its shard, asks for.
        done: Runs done by this call.
        failed: Runs of the benchmark that have failed, now or before.
        refused: Runs of the benchmark that were refused.
        simulated: Simulated time of what this call did, or would do [s].
        predicted: Predicted wall time of a dry run, 0 otherwise [s].
        page: The report, None if none was written.
        notes: What to know about how it came to these runs.
    """

    folder: Path
    total: int
    done: int
    failed: int
    refused: int
    simulated: float
    predicted: float
    page: Path | None
    notes: tuple[str, ...]


def run(
    benchmark: str = "quick",
    *,
    out: str | Path = "results",
    controllers: Sequence[object] = (),
    robot: str = "",
    plant: str = "",
    tier: str = "",
    latency: Latency | None = None,
    changes: Sequence[str] = (),
    shard: tuple[int, int] = (1, 1),
    workers: int = 0,
    traces: str = "plot",
    retry_failed: bool = False,
    dry_run: bool = False,
    watch: Watch | None = None,
) -> RunReport:
    """Run a benchmark side by side and write the report.

    Args:
        benchmark: Name of one that ships, or a ``.toml`` file.
        out: Folder of the store; what it holds already is not run again.
        controllers: Names, doors or Python objects in place of the benchmark's own, see :func:`load_benchmark`.
        robot: Name or file in place of the benchmark's own.
        plant: Name in place of the benchmark's own.
        tier: Name in place of the benchmark's own.
        latency: Ticks by which every command is late, or ``"measured"``, in place of the benchmark's own.
        changes: ``key=value`` changes of the benchmark.
        shard: Part i of n, counted from 1.
        workers: Number of processes, 0 for one per core.
        traces: ``plot``, ``full`` or ``none``.
        retry_failed: Whether failed runs are tried again.
        dry_run: Whether to plan only.
        watch: Is told of progress.

    Returns:
        What was done and where the report is.

    Raises:
        TorquebenchError: If anything that came is wrong; finished runs are kept.
        GateFailure: If the plant does not compute the arm's equations; nothing runs then.
    """
    if traces not in TRACE_KINDS:
        raise InvalidInput(repr(traces), "traces", f"one of {', '.join(TRACE_KINDS)}")
    names, plug_ins = _named(controllers)
    replaced = {"controllers": names, "robot": robot, "plant": plant, "tier": tier}
    overrides: dict[str, object] = {key: value for key, value in replaced.items() if value}
    if latency is not None:
        overrides["latency"] = latency
    loaded = load_benchmark(benchmark, overrides=overrides, changes=changes)
    processes, folder = workers or len(os.sched_getaffinity(0)), Path(out)
    # Wrong input is found before the folder is made.
    everything = plan_campaign(loaded, {}, shard=shard, plug_ins=plug_ins)
    if dry_run:
        return _planned(folder, everything, retry_failed=retry_failed, workers=processes)
    with Store.write(folder) as store:
        campaign = everything.against(store.statuses(), retry_failed=retry_failed)
        if watch is not None:
            watch(campaign, None)
        simulated = 0.0
        for finished in run_campaign(
            campaign,
            store,
            evaluate=score,
            evaluate_events=score_events,
            judges=JUDGES,
            workers=processes,
            traces=traces,
        ):
            simulated += finished.simulated
            if watch is not None:
                watch(campaign, finished)
        statuses = store.statuses()
    page = report(folder)
    return _summary(folder, campaign, statuses, done=len(campaign.pending), simulated=simulated, page=page)


def _named(controllers: Sequence[object]) -> tuple[list[str], dict[str, object]]:
    """Return the controllers by name, and the objects behind names that are no text."""
    names: list[str] = []
    plug_ins: dict[str, object] = {}
    for controller in controllers:
        if isinstance(controller, str):
            names.append(controller)
            continue
        name = getattr(controller, "__name__", type(controller).__name__)
        if plug_ins.setdefault(name, controller) is not controller:
            raise InvalidInput(f"two controllers are called {name!r}", "controllers", "give their classes other names")
        names.append(name)
    return names, plug_ins


def _planned(folder: Path, campaign: Campaign, *, retry_failed: bool, workers: int) -> RunReport:
    """Return what a campaign would do."""
    statuses: Mapping[str, str] = {}
    if (folder / DATABASE).is_file():
        with Store.read(folder) as store:
            statuses = store.statuses()
            missing = campaign.against(statuses, retry_failed=retry_failed)
            simulated, wall = predicted_time(missing, store, workers=workers)
    else:
        simulated, wall = predicted_time(campaign, None, workers=workers)
    return _summary(folder, campaign, statuses, done=0, simulated=simulated, page=None, predicted=wall)


def _summary(
    folder: Path,
    campaign: Campaign,
    statuses: Mapping[str, str],
    *,
    done: int,
    simulated: float,
    page: Path | None,
    predicted: float = 0.0,
) -> RunReport:
    found = [statuses.get(campaign.addresses[position], "") for position in campaign.mine]
    return RunReport(
        folder=folder,
        total=len(found),
        done=done,
        failed=found.count(FAILED),
        refused=found.count(REFUSED),
        simulated=simulated,
        predicted=predicted,
        page=page,
        notes=campaign.expansion.notes,
    )
