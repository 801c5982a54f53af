"""``torquebench explain``: a cell of the report down to its runs."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..explaining import ExplainedRun, Explanation

SHOWN = 40
"""Most runs that a person is shown; JSON has them all."""


@click.command("explain")
@click.argument("folder", default="results", type=click.Path(path_type=Path))
@click.option("--controller", required=True, help="Label of the page ('pid / none'), or a controller's name.")
@click.option("--knowledge", default="", help="Its knowledge level, where it ran with several.")
@click.option("--trajectory", "trajectories", multiple=True, help="A motion; may be given several times.")
@click.option("--mass", type=float, default=None, help="Mass beyond the flange [kg].")
@click.option("--material", default="", help="Content of the container; none for an empty one.")
@click.option("--metric", default="tcp_position_error_mean", show_default=True, help="Says which run is worst.")
@click.option("--world", default="", help="Part of the page (w1, w2, ...), where several have such runs.")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON, without the curve.")
def command(
    folder: Path,
    controller: str,
    knowledge: str,
    trajectories: tuple[str, ...],
    mass: float | None,
    material: str,
    metric: str,
    world: str,
    as_json: bool,
) -> None:
    """Print the runs behind a cell of FOLDER's report: addresses, seeds, values, the worst one and how to repeat it."""
    from ..explaining import explain
    from ..selection import Selection

    selection = Selection(
        controller=controller, knowledge=knowledge, trajectories=trajectories, mass=mass, material=material
    )
    found = explain(folder, selection, metric=metric, world=world)
    if as_json:
        table = asdict(found)
        del table["curve"]
        click.echo(json.dumps(table, indent=2, ensure_ascii=False))
        return
    _say(found)


def _say(found: "Explanation") -> None:
    """Print an explanation for a person."""
    from ..evaluation.report.numbers import significant, unit_on_page
    from ..terminal_plot import plot

    shown = unit_on_page(found.unit)
    click.echo(f"{found.controller} in {found.world}: {len(found.runs)} run{'s' if len(found.runs) > 1 else ''}")
    for line in _lines(found.runs[:SHOWN]):
        click.echo(f"  {line}")
    if len(found.runs) > SHOWN:
        click.echo(f"  and {len(found.runs) - SHOWN} more: --json lists all")
    mean = "no value" if found.mean is None else f"{significant(shown.of(found.mean))} {shown.text}"
    counted = sum(run.values[found.metric] is not None for run in found.runs)
    click.echo(f"mean {found.metric}: {mean} (runs with a value: {counted} of {len(found.runs)})")
    worst = found.worst
    click.echo(f"worst: {worst.address[:12]} ({worst.trajectory}, {worst.load}, repetition {worst.repetition})")
    if worst.reason:
        click.echo(f"  {worst.status}: {worst.reason}")
    click.echo(f"  again: {found.command}" if found.command else f"  cannot be repeated here: {found.obstacle}")
    if found.curve is None:
        click.echo("  no trace was kept to draw its error from")
        return
    t, error = found.curve
    click.echo(plot(t, error * 1e3, title="distance of the tool from its plan [mm], worst run"))


def _lines(runs: "tuple[ExplainedRun, ...]") -> list[str]:
    """Return the runs as lines of a table with a header, in the page's units."""
    from ..evaluation.report.numbers import significant, unit_on_page
    from ..plug_in_metrics import all_metrics

    metrics = list(runs[0].values)
    units = [unit_on_page(all_metrics()[name].unit) for name in metrics]
    rows = [
        ["address", "trajectory", "load", "seed", "repetition", "status",
         *(f"{name} [{unit.text}]" for name, unit in zip(metrics, units, strict=True))]
    ]  # fmt: skip
    for run in runs:
        values = [
            "-" if (value := run.values[name]) is None else significant(unit.of(value))
            for name, unit in zip(metrics, units, strict=True)
        ]
        rows.append([run.address[:12], run.trajectory, run.load, str(run.seed), str(run.repetition), run.status])
        rows[-1] += values
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    return ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]
