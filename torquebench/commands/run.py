"""``torquebench run``: a benchmark into a results folder, and its report."""

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..bounds import Checked
    from ..running import RunReport


@click.command("run")
@click.argument("benchmark", default="quick")
@click.option("--out", default="results", show_default=True, help="Results folder; finished runs in it are kept.")
@click.option("--controllers", default="", help="Comma-separated names or doors (module:Class, ./file.py:Class).")
@click.option("--robot", default="", help="Name, or a .toml or .urdf file.")
@click.option("--plant", default="", help="Name of the plant.")
@click.option("--tier", default="", help="Name of the tier.")
@click.option("--latency", default="", help="Ticks by which commands are late; measured: by the time of their calls.")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help="Change a key of the benchmark.")
@click.option("--shard", default="1/1", metavar="I/N", help="Run part I of N; join the folders with merge.")
@click.option("--workers", type=click.IntRange(min=0), default=0, help="Processes; 0 for one per core.")
@click.option("--traces", default="plot", show_default=True, help="plot, full or none.")
@click.option("--retry-failed", is_flag=True, help="Try failed runs again.")
@click.option("--gate", type=click.Path(path_type=Path), help="TOML file of bounds; one that is broken is status 1.")
@click.option("--dry-run", is_flag=True, help="Say what would run and how long it would take.")
@click.option("--json", "as_json", is_flag=True, help="Print the outcome as JSON.")
def command(
    benchmark: str,
    out: str,
    controllers: str,
    robot: str,
    plant: str,
    tier: str,
    latency: str,
    changes: tuple[str, ...],
    shard: str,
    workers: int,
    traces: str,
    retry_failed: bool,
    gate: Path | None,
    dry_run: bool,
    as_json: bool,
) -> int:
    """Run BENCHMARK (a name or a .toml file) and write its report."""
    from ..bounds import check_bounds, read_bounds
    from ..running import run
    from ..scenarios.campaign import parse_shard
    from ..scenarios.latency import parse_latency
    from .progress import Progress

    # A gate that cannot be read is found before hours of runs.
    bounds = read_bounds(gate) if gate is not None else ()
    with Progress(quiet=as_json) as progress:
        outcome = run(
            benchmark,
            out=out,
            controllers=[name.strip() for name in controllers.split(",") if name.strip()],
            robot=robot,
            plant=plant,
            tier=tier,
            latency=parse_latency(latency) if latency else None,
            changes=changes,
            shard=parse_shard(shard),
            workers=workers,
            traces=traces,
            retry_failed=retry_failed,
            dry_run=dry_run,
            watch=progress.watch,
        )
    checked = check_bounds(bounds, outcome.folder) if bounds and not dry_run else ()
    if as_json:
        held = {"gate": [asdict(check) for check in checked]} if checked else {}
        click.echo(json.dumps(asdict(outcome) | held, default=str, indent=2))
    else:
        _say(outcome, dry_run=dry_run)
        _say_gate(checked)
    broken = not all(check.passed for check in checked)
    return 1 if broken or (outcome.failed and not dry_run) else 0


def _say_gate(checked: "Sequence[Checked]") -> None:
    """Print every bound, what was found, and whether it holds."""
    for check in checked:
        found = check.reason if check.value is None else f"{check.value:.4g} {check.unit}".strip()
        click.echo(f"{'pass' if check.passed else 'FAIL'}: {check.bound}; found: {found}")


def _say(outcome: "RunReport", *, dry_run: bool) -> None:
    """Print the outcome for a person."""
    for note in outcome.notes:
        click.echo(f"note: {note}", err=True)
    if dry_run:
        click.echo(
            f"{outcome.total} runs asked for; {outcome.simulated:.0f} s of simulated time are missing in"
            f" {outcome.folder}, about {_duration(outcome.predicted)} of wall time"
        )
        return
    if not outcome.done:
        click.echo(f"nothing to do: all {outcome.total} runs are in {outcome.folder}")
    else:
        click.echo(f"{outcome.done} runs done ({outcome.simulated:.0f} s simulated), {outcome.total} in all")
    if outcome.failed:
        click.echo(f"{outcome.failed} failed; the report says why, --retry-failed tries them again")
    if outcome.refused:
        click.echo(f"{outcome.refused} refused; the report says why")
    if outcome.page is not None:
        click.echo(f"report: {outcome.page}")
    sys.stdout.flush()


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"
