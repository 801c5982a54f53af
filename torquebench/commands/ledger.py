"""``torquebench ledger``: where every setting comes from."""

import json
from dataclasses import asdict

import click


@click.command("ledger")
@click.option("--json", "as_json", is_flag=True, help="Print names, settings and sources as JSON.")
def command(as_json: bool) -> None:
    """Print a page (Markdown) of every controller's settings, their values and sources."""
    from ..ledger_page import controller_sections, knowledge_sections, page

    controllers, knowledge = controller_sections(), knowledge_sections()
    if as_json:
        found = {"controllers": controllers, "knowledge": knowledge}
        rows = {kind: [asdict(section) for section in sections] for kind, sections in found.items()}
        click.echo(json.dumps(rows, indent=2))
        return
    click.echo(page(controllers, knowledge), nl=False)
