"""``torquebench list``: everything that has a name."""

import json

import click

BENCHMARKS = "benchmarks"


@click.command("list")
@click.argument("kind", default="")
@click.option("--json", "as_json", is_flag=True, help="Print names and origins as JSON.")
def command(kind: str, as_json: bool) -> None:
    """List the names of KIND (controllers, knowledge, trajectories, ...), or of all kinds; imports no plug-in."""
    from ..controllers import UnknownName, discovery

    kinds = (BENCHMARKS, *discovery.KINDS)
    if kind and kind not in kinds:
        raise UnknownName("kind", kind, kinds)
    found = {name: _names(name) for name in ([kind] if kind else kinds)}
    if as_json:
        click.echo(json.dumps(found, indent=2))
        return
    for name, entries in found.items():
        click.echo(f"{name}:")
        for entry, about in entries.items():
            click.echo(f"  {entry:34s} {about['meaning'] or about['origin']}")


def _names(kind: str) -> dict[str, dict[str, str]]:
    """Return name to origin and meaning."""
    from ..controllers import discovery

    if kind != BENCHMARKS:
        return {
            name: {"origin": point.value, "meaning": discovery.meaning(point)}
            for name, point in discovery.registered(kind).items()
        }
    from ..scenarios.benchmark import benchmark_names, load_benchmark

    return {name: {"origin": "bundled", "meaning": load_benchmark(name).title} for name in benchmark_names()}
