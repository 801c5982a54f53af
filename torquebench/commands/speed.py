"""``torquebench speed``: what harness, plants and controllers cost on this machine."""

import json
from dataclasses import asdict

import click


@click.command("speed")
@click.option("--plant", default="", help="Name of the plant; PyBullet where it is installed.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def command(plant: str, as_json: bool) -> None:
    """Measure on one core, each figure the best of five repeats."""
    import importlib.util

    from ..scenarios.machine import machine_label
    from ..scenarios.speed import measure_speed
    from ..scoring import score

    name = plant or ("pybullet" if importlib.util.find_spec("pybullet") is not None else "pinocchio")
    figures = measure_speed(name, evaluate=score)
    if as_json:
        rows = [{**asdict(figure), "met": figure.met} for figure in figures]
        click.echo(json.dumps({"machine": machine_label(), "plant": name, "figures": rows}, indent=2))
        return
    click.echo(f"{machine_label()}; plant {name}")
    for figure in figures:
        bar = "" if figure.bar is None else f"  {'at least' if figure.at_least else 'at most'} {figure.bar:g}"
        flag = "" if figure.met else "  MISSED"
        click.echo(f"  {figure.name:48s} {figure.value:8.2f} {figure.unit}{bar}{flag}")
