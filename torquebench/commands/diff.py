"""``torquebench diff``: in what two results folders, or two runs, differ."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..differing import Difference, Shift
    from ..run_difference import RunDifference

SHOWN = 20
"""Most lines of one kind that a person is shown; JSON has them all."""


@click.command("diff")
@click.argument("first", metavar="A")
@click.argument("second", metavar="B")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
def command(first: str, second: str, as_json: bool) -> int:
    """Print in what B differs from A: two results folders, or two runs as FOLDER:ADDRESS.

    Status 1 if both hold a row under one address that is not the same to the bit.
    """
    from ..controllers import InvalidInput
    from ..differing import difference
    from ..replaying import stored_rows
    from ..run_difference import run_difference

    (folder, address), (other_folder, other_address) = _parts(first), _parts(second)
    if bool(address) != bool(other_address):
        raise InvalidInput("a folder and a run", "diff", "name two folders, or two runs as FOLDER:ADDRESS")
    if address:
        runs = run_difference(stored_rows(folder, address)[0], stored_rows(other_folder, other_address)[0])
        click.echo(json.dumps(asdict(runs), indent=2) if as_json else _runs_in_words(runs))
        return 1 if runs.broken else 0
    found = difference(folder, other_folder)
    click.echo(json.dumps(_table(found), indent=2, default=str) if as_json else _in_words(found))
    return 1 if found.unequal else 0


def _parts(text: str) -> tuple[Path, str]:
    """Return folder and address of what was named; a folder may have a colon in its name."""
    folder, colon, address = text.rpartition(":")
    return (Path(folder), address) if colon and not Path(text).exists() else (Path(text), "")


def _table(found: "Difference") -> dict[str, object]:
    table = asdict(found)
    for shift, entry in zip(found.shifts, table["shifts"], strict=True):
        entry["verdict"], entry["beyond_noise"] = shift.comparison.verdict, shift.beyond_noise
    return table


def _in_words(found: "Difference") -> str:
    """Return a difference of folders for a person."""
    equality = f"{len(found.unequal)} not the same" if found.unequal else "all the same to the bit"
    lines = [f"{found.same} rows under the same address: {equality}" if found.same else "no row under the same address"]
    lines += _listed(f"{row.address[:12]} ({row.run}): {', '.join(row.fields)}" for row in found.unequal)
    for name, runs in zip("AB", found.only, strict=True):
        lines += [f"{len(runs)} runs only in {name}", *_listed(runs)] if runs else []
    if found.other_code:
        lines.append(f"{found.other_code} runs of the same specification by other code, data or libraries")
    if found.set_up:
        lines.append("set-up, A and B:")
        lines += _listed(f"{name}: {one} | {other}" for name, one, other in found.set_up)
    moved = [shift for shift in found.shifts if shift.beyond_noise]
    if moved:
        lines.append("beyond the noise, B over A with its 95 % interval over motions:")
        lines += _listed(_shift(shift) for shift in moved)
    if len(found.shifts) > len(moved):
        lines.append(f"{len(found.shifts) - len(moved)} means moved, but not enough to decide")
    for order in found.orders:
        where = f" ({order.world})" if order.world else ""
        lines.append(f"order by {order.metric} changed{where}: {', '.join(order.first)} | {', '.join(order.second)}")
    if not (found.shifts or found.orders):
        lines.append("no mean and no order changed")
    return "\n".join(lines)


def _shift(shift: "Shift") -> str:
    from ..evaluation.report.numbers import ratio_text

    found, interval = shift.comparison, shift.comparison.interval_new_motions
    span = f" ({ratio_text(interval.low)} to {ratio_text(interval.high)})" if interval else ""
    remarks = "; ".join((found.verdict, *found.remarks, *([shift.world] if shift.world else [])))
    return f"{found.controller}, {found.metric}: {ratio_text(found.gmr)}{span}, {remarks}"


def _runs_in_words(found: "RunDifference") -> str:
    """Return a difference of runs for a person."""
    one, other = (address[:12] for address in found.addresses)
    lines = [f"{one} and {other}: {'' if found.fields else 'the same to the bit'}".rstrip(": ")]
    lines += [f"  {name}: {first} | {second}" for name, first, second in found.specification]
    if found.fields:
        lines.append(f"not the same to the bit: {', '.join(found.fields)}")
    shown = [moved for moved in found.metrics if moved.window == "run"] or list(found.metrics)
    lines += _listed(
        f"{moved.window}.{moved.metric} [{moved.unit}]: {_number(moved.first)} | {_number(moved.second)}"
        for moved in shown
    )
    if len(found.metrics) > len(shown):
        lines.append(f"{len(found.metrics) - len(shown)} more in other windows: --json lists all")
    return "\n".join(lines)


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.6g}"


def _listed(texts: Iterable[str]) -> list[str]:
    """Return lines, indented, and how many were left out."""
    lines = [f"  {text}" for text in texts]
    return lines if len(lines) <= SHOWN else [*lines[:SHOWN], f"  and {len(lines) - SHOWN} more: --json lists all"]
