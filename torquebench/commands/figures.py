"""``torquebench figures``: the figures for print."""

import importlib.util
from pathlib import Path

import click


@click.command("figures")
@click.argument("folder", default="results", type=click.Path(path_type=Path))
@click.option("--out", default=None, type=click.Path(path_type=Path), help="Their folder; print in FOLDER if left out.")
@click.option("--controllers", default="", help="Comma-separated labels of those shown by mass and over time.")
@click.option("--motions", default="paper", show_default=True, help="Of those by mass: paper, further or extended.")
def command(folder: Path, out: Path | None, controllers: str, motions: str) -> None:
    """Draw the figures of FOLDER as SVG and PDF: intervals, errors, modules, gains, resilience, as far as there are."""
    from ..controllers import InvalidInput

    if importlib.util.find_spec("matplotlib") is None:
        raise InvalidInput("matplotlib is not installed", "figures", "pip install 'torquebench[figures]'")
    from ..evaluation.report.print_figures import print_figures

    labels = [label.strip() for label in controllers.split(",") if label.strip()]
    for file in print_figures(folder, out if out is not None else folder / "print", labels, motions):
        click.echo(str(file))
