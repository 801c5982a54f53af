"""``torquebench doctor``: what is installed, where it comes from, what is missing and what that costs."""

import json
from dataclasses import asdict

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..doctor import Diagnosis, LibraryState, diagnose

COLOURS = {"ok": "green", "missing": "yellow", "broken": "red"}
PIPED_WIDTH = 240
"""Width of the tables where no terminal gives one [characters]."""


@click.command("doctor")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of tables.")
@click.pass_context
def command(context: click.Context, as_json: bool) -> None:
    """Show every library's version and origin, what is missing and what that costs.

    Exit status 0 if all required parts work, 1 otherwise.
    """
    diagnosis = diagnose()
    if as_json:
        click.echo(json.dumps(as_table(diagnosis), indent=2))
    else:
        console = Console()
        show(diagnosis, console if console.is_terminal else Console(width=PIPED_WIDTH))
    context.exit(0 if diagnosis.healthy else 1)


def as_table(diagnosis: Diagnosis) -> dict[str, object]:
    """Return a diagnosis as plain values, verdicts included."""
    table = asdict(diagnosis)
    table["libraries"] = [{**asdict(found.library), **_found(found)} for found in diagnosis.libraries]
    return {**table, "healthy": diagnosis.healthy}


def show(diagnosis: Diagnosis, console: Console) -> None:
    """Print a diagnosis for a person."""
    console.print(Text(f"torquebench {diagnosis.version}", style="bold"), Text(f"in {diagnosis.origin}"))
    console.print(_machine(diagnosis))
    console.print(_libraries(diagnosis))
    console.print(_plug_ins(diagnosis))
    for kind in diagnosis.plug_ins:
        for line in kind.broken:
            console.print(Text(f"{kind.kind}: {line}", style="red"))
    for warning in diagnosis.warnings:
        console.print(Text(f"note: {warning}", style="yellow"))
    verdict = "all required parts work" if diagnosis.healthy else "a required part does not work, see above"
    console.print(Text(verdict, style="bold green" if diagnosis.healthy else "bold red"))


def _found(found: LibraryState) -> dict[str, str]:
    return {"version": found.version, "origin": found.origin, "state": found.state, "problem": found.problem}


def _machine(diagnosis: Diagnosis) -> Table:
    """Return the rows about the machine."""
    machine = diagnosis.machine
    threads = ", ".join(f"{name}={value}" for name, value in machine.threads.items() if value)
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(style="bold")
    table.add_column(overflow="fold")
    table.add_row("Python", f"{machine.python}, {machine.executable}")
    table.add_row("platform", machine.platform)
    table.add_row("cores", str(machine.cores))
    table.add_row("threads", threads or "not limited here; every worker limits its own to one")
    table.add_row("kernel cache", machine.kernel_cache)
    table.add_row("C compiler", machine.compiler or "none (none is needed)")
    return table


def _libraries(diagnosis: Diagnosis) -> Table:
    """Return a row for each library; what its absence costs only where it is absent."""
    table = Table(box=None, pad_edge=False)
    for title in ("library", "distribution", "version", "state", "origin"):
        table.add_column(title, overflow="fold")
    for found in diagnosis.libraries:
        state = Text(found.state, style=COLOURS[found.state])
        where = found.origin
        if found.state == "missing":
            where = f"costs: {found.library.cost}"
        elif found.state == "broken":
            where = f"{found.origin}\n{found.problem}\ncosts: {found.library.cost}"
        table.add_row(found.library.module, found.library.distribution, found.version or "-", state, Text(where))
    return table


def _plug_ins(diagnosis: Diagnosis) -> Table:
    """Return a row for each kind of plug-in."""
    table = Table(box=None, pad_edge=False)
    for title in ("plug-ins", "registered", "broken"):
        table.add_column(title)
    for kind in diagnosis.plug_ins:
        broken = Text(str(len(kind.broken)), style="red" if kind.broken else "green")
        table.add_row(kind.kind, str(kind.count), broken)
    return table
