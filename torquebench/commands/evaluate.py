"""``torquebench evaluate``: the metrics of a log of one's own."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..evaluation.metrics import Value


@click.command("evaluate")
@click.argument("log", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--map", "mapping", required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path),
              help="TOML file that says which column is what.")  # fmt: skip
@click.option("--metrics", "chosen", default="", help="Ids, separated by commas; all that the log allows if empty.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(log: Path, mapping: Path, chosen: str, as_json: bool) -> None:
    """Compute the metrics of LOG, a CSV file with a line of column names."""
    from ..controllers import InvalidInput
    from ..evaluation.errors import MissingFields
    from ..evaluation.metrics import evaluate, missing_fields
    from ..evaluation.metrics.catalogue import KINDS
    from ..own_log import read_log
    from ..plug_in_metrics import all_metrics

    metrics = all_metrics()
    ids = [name.strip() for name in chosen.split(",") if name.strip()] or None
    read = read_log(log, mapping)
    missing = missing_fields(read, ids, metrics)
    if ids is not None:
        for name, fields in missing.items():
            raise MissingFields(name, fields)
        for name in ids:
            if metrics[name].kind != "log":
                raise InvalidInput(f"{name} is computed from {KINDS[metrics[name].kind]}", "--metrics", "leave it out")
    windows = evaluate(read, ids, metrics=metrics)
    if not windows:
        span = f"times from {read.t[0]:.6g} s to {read.t[-1]:.6g} s hold no whole lap from 0 on"
        raise InvalidInput(span, str(log), f"check start and lap in {mapping}")
    if as_json:
        values = {
            window: {name: _finite(value.as_dict()) for name, value in found.items()}
            for window, found in windows.items()
        }
        left_out = {name: list(fields) for name, fields in missing.items()}
        click.echo(json.dumps({"windows": values, "left_out": left_out, "notes": read.doubts()}, indent=2))
        return
    for line in _table(windows):
        click.echo(line)
    for fields in dict.fromkeys(missing.values()):
        without = [name for name, lacking in missing.items() if lacking == fields]
        click.echo(f"without {', '.join(fields)}: no {', '.join(without)}")
    for doubt in read.doubts():
        click.echo(f"note: {doubt}", err=True)


def _table(windows: Mapping[str, Mapping[str, "Value"]]) -> list[str]:
    """Return a line for each metric: its value in each window, and its unit."""
    lines = [f"{'':38s}" + "".join(f"{window:>20s}" for window in windows) + "  unit"]
    first = next(iter(windows.values()), {})
    for name, value in first.items():
        cells = "".join(f"{_words(found[name]):>20s}" for found in windows.values())
        lines.append(f"{name:38s}{cells}  {value.unit}")
    return lines


def _words(value: "Value") -> str:
    """Return a value, or the word for why there is none; a bound is marked."""
    if not math.isfinite(value.value):
        return value.status
    return f"{value.value:.5g}{' (bound)' if value.status == 'censored' else ''}"


def _finite(entry: dict[str, float | str | int]) -> dict[str, float | str | int | None]:
    """Return an entry with nothing where there is no number: JSON knows no NaN."""
    return {key: None if isinstance(v, float) and not math.isfinite(v) else v for key, v in entry.items()}
