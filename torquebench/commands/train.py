"""``torquebench train``: patterns of the cerebellum for an arm."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..nearest import NearestGroup

if TYPE_CHECKING:
    from ..cbmc.patterns import Patterns
    from ..cbmc.training.watch import Watch

TIERS = "ideal,actuated,tight_rate,elastic,paper_bullet"


@click.group("train", cls=NearestGroup)
def command() -> None:
    """Train what controllers learn before they run."""


@command.command("cerebellum")
@click.option("--robot", default="rizon4s", show_default=True, help="A robot's name, or a .toml or .urdf file.")
@click.option("--loads", default="0,3", show_default=True, help="Masses beyond the gripper, one pattern each [kg].")
@click.option("--set", "set_name", default="", help="workspace (the default), tube, or paper (two circles).")
@click.option("--preset", default="default", show_default=True, help="smoke, default, best, or paper.")
@click.option("--seed", default=1, show_default=True, help="Seed of everything that is drawn.")
@click.option("--out", default="", help="File to write, in .safetensors; the user's folder of patterns if not given.")
@click.option("--json", "as_json", is_flag=True, help="Print notes and evaluation as JSON.")
def cerebellum(robot: str, loads: str, set_name: str, preset: str, seed: int, out: str, as_json: bool) -> None:
    """Train CBMC's cerebellum for an arm, print its error on paths that training did not see, and save it."""
    from ..cbmc.patterns import save_patterns, user_folder
    from ..cbmc.training import train_cerebellum
    from ..scenarios.robots import load_robot
    from ..training import lesson_for, workspace_of

    arm = load_robot(robot)
    lesson = lesson_for(arm, loads=_masses(loads), training_set=set_name, preset=preset, seed=seed)
    file = Path(out) if out else user_folder() / f"{arm.name}.safetensors"
    _check_name(file)
    with _progress(f"{arm.name}, {preset}", quiet=as_json) as watch:
        patterns = train_cerebellum(workspace_of(arm), lesson, watch)
    save_patterns(file, patterns)
    if as_json:
        click.echo(json.dumps({"file": str(file), **patterns.notes}, indent=2))
        return
    _show(patterns)
    click.echo(f"saved {file} and its .json; a controller takes them by its setting patterns = {str(file)!r}")
    if not out:
        click.echo("without the setting it takes them from here for an arm that has none shipped")


@command.command("gains")
@click.option("--tier", "tiers", default=TIERS, show_default=True, help="Their names, between commas.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="JSON file to write.")
def gains(tiers: str, out: Path) -> None:
    """Measure CBMC-V3's mean gains, which its null controls are given (cbmc/data/mean_gains.json)."""
    from ..gains import write_mean_gains

    write_mean_gains(out, [tier.strip() for tier in tiers.split(",") if tier.strip()])
    click.echo(f"wrote {out}")


def _masses(text: str) -> tuple[float, ...]:
    """Read masses between commas."""
    from ..controllers import InvalidInput

    try:
        return tuple(float(mass) for mass in text.split(","))
    except ValueError:
        raise InvalidInput(f"{text!r} is no list of masses", "--loads", "give kilograms between commas: 0,3") from None


def _check_name(file: Path) -> None:
    """Refuse a name that saving would refuse, before the training and not after it."""
    from ..controllers import InvalidInput

    if file.suffix != ".safetensors":
        raise InvalidInput(f"patterns cannot be written to {file.name!r}", "--out", "give a name in .safetensors")


@contextmanager
def _progress(title: str, *, quiet: bool) -> "Iterator[Watch]":
    """Show a bar on a terminal and nothing elsewhere."""
    import sys

    from rich.console import Console
    from rich.progress import Progress

    shown = sys.stderr.isatty() and not quiet
    with Progress(console=Console(stderr=True), disable=not shown) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def _show(patterns: "Patterns") -> None:
    """Print the error of each pattern on each group of postures."""
    from rich.console import Console
    from rich.table import Table

    evaluation = patterns.notes["evaluation"]
    rows: Sequence[dict[str, object]] = evaluation["rows"] if isinstance(evaluation, dict) else ()
    table = Table(title="gravity torque: rmse over joints (worst joint) [N m]")
    table.add_column("postures")
    for load in patterns.loads:
        table.add_column(f"{load:g} kg beyond the gripper", justify="right")
    for group in dict.fromkeys(str(row["group"]) for row in rows):
        cells = [
            f"{row['rmse']:.2f} (joint {row['worst_joint']}: {row['worst_rmse']:.2f})"
            for row in rows
            if row["group"] == group
        ]
        table.add_row(group, *cells)
    Console().print(table)
