"""``torquebench merge``: results folders joined into one."""

from pathlib import Path

import click


@click.command("merge")
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder that takes all of them.")
def command(folders: tuple[Path, ...], out: Path) -> None:
    """Join FOLDERS (of shards, or of other machines) into --out and write its report."""
    from ..reporting import report
    from ..scenarios.store import Store

    # Every source is looked at before anything is written.
    for folder in folders:
        Store.read(folder).close()
    with Store.write(out) as store:
        for folder in folders:
            with Store.read(folder) as source:
                click.echo(f"{folder}: {store.merge(source)} runs taken")
    click.echo(f"report: {report(out)}")
