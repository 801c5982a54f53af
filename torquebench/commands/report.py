"""``torquebench report``: the report of a results folder, written again."""

from pathlib import Path

import click


@click.command("report")
@click.argument("folder", default="results", type=click.Path(path_type=Path))
def command(folder: Path) -> None:
    """Write the report of FOLDER again, from what its store holds."""
    from ..reporting import report

    click.echo(f"report: {report(folder)}")
