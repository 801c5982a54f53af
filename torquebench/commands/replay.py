"""``torquebench replay``: back to a stored run."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..repeating import Repeated
    from ..replaying import Answers


@click.command("replay")
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("address")
@click.option("--open", "open_page", is_flag=True, help="Open the page in a browser.")
@click.option("--again", is_flag=True, help="Run it again and compare every figure to the bit.")
@click.option("--into", "controller", default="", help="Feed what the run saw to this controller, tick by tick.")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help="A setting of the controller that is fed.")
@click.option("--json", "as_json", is_flag=True, help="Print the outcome as JSON.")
def command(
    folder: Path, address: str, open_page: bool, again: bool, controller: str, changes: tuple[str, ...], as_json: bool
) -> int:
    """Print where the run ADDRESS (its first digits are enough) stands on FOLDER's page."""
    from ..controllers import InvalidInput
    from ..replaying import feed_into, place_on_page, stored_rows

    if again and controller:
        raise InvalidInput("--again and --into", "replay", "ask for one of them at a time")
    if changes and not controller:
        raise InvalidInput("--set without --into", "replay", "name the controller that takes the settings")
    if again:
        return _repeat(folder, address, as_json=as_json)
    if controller:
        (row, *_) = stored_rows(folder, address)
        answers = feed_into(row, controller, dict(_setting(change) for change in changes))
        click.echo(json.dumps(asdict(answers), indent=2) if as_json else _in_words(answers))
        return 1 if answers.failure else 0
    url = place_on_page(folder, address)
    click.echo(json.dumps({"url": url}) if as_json else url)
    if open_page:
        click.launch(url)
    return 0


def _repeat(folder: Path, address: str, *, as_json: bool) -> int:
    """Run an address again; a difference is status 1."""
    from ..controllers import InvalidInput
    from ..repeating import obstacle, repeat
    from ..replaying import stored_rows

    rows = stored_rows(folder, address)
    if reason := obstacle(rows[0]):
        raise InvalidInput(f"run {rows[0].address[:12]} cannot be repeated here: {reason}", "--again")
    repeated = repeat(rows)
    click.echo(json.dumps(asdict(repeated), indent=2) if as_json else _outcome(repeated))
    return 1 if repeated.differences else 0


def _outcome(repeated: "Repeated") -> str:
    rows = f"{repeated.rows} row{'s' if repeated.rows > 1 else ''}"
    if not repeated.differences:
        return f"{repeated.address[:12]}: {rows}, every figure the same to the bit"
    return "\n".join([f"{repeated.address[:12]}: {rows}, not the same:", *(f"  {d}" for d in repeated.differences)])


def _in_words(answers: "Answers") -> str:
    """Return the difference of the torques for a person."""
    lines = [f"{answers.controller} answered {answers.ticks} of {answers.of} ticks"]
    if answers.failure:
        lines.append(f"  then failed: {answers.failure}")
    if answers.first is None:
        return "\n".join([*lines, "  every torque is the same to the bit"])
    tick, time = answers.first
    lines.append(f"  first tick that differs: {tick}, at {time:.3f} s")
    for name, values in (("rms", answers.rms), ("peak", answers.peak)):
        lines.append(f"  {name:4s} difference by joint [N m]: {'  '.join(f'{value:.4g}' for value in values)}")
    return "\n".join(lines)


def _setting(change: str) -> tuple[str, object]:
    """Return name and value of ``key=value``; the value is TOML, or else a word."""
    import tomllib

    from ..controllers import InvalidInput

    key, separator, text = change.partition("=")
    if not separator or not key.strip():
        raise InvalidInput(f"{change!r}", "--set", "expected key=value, for example gain=50")
    try:
        return key.strip(), tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), text
