"""Reads a log of one's own, a CSV file, by a few lines that say which column is what."""

import csv
import difflib
import math
import tomllib
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .controllers.errors import InvalidInput
from .evaluation.metrics import Log
from .evaluation.metrics.log import JOINTS, LIMITS, WIDTHS

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
ANGLE = {"rad": 1.0, "deg": math.pi / 180.0}
ANGULAR_VELOCITY = {"rad/s": 1.0, "deg/s": math.pi / 180.0}
LENGTH = {"m": 1.0, "mm": 1e-3}
TORQUE = {"N m": 1.0, "N mm": 1e-3}
UNITS = (
    {"t": TIME}
    | dict.fromkeys(("q", "q_ref"), ANGLE)
    | dict.fromkeys(("dq", "dq_ref"), ANGULAR_VELOCITY)
    | dict.fromkeys(("p", "p_ref"), LENGTH)
    | dict.fromkeys(("tau", "tau_cmd", "tau_lim"), TORQUE)
)
"""Units that the columns of a field may have, and what one of it is in the library's; other fields have no choice."""

COLUMNS = ("t", *JOINTS, *WIDTHS)
NUMBERS = ("lap", "mass", "start", "period", *LIMITS)
WORDS = ("delimiter", "quat_order")
TABLES = {"columns": COLUMNS, "units": tuple(UNITS)}


def read_log(file: Path, mapping: Path) -> Log:
    """Read a CSV file with a line of column names.

    Args:
        file: The CSV file.
        mapping: A TOML file: the table ``columns`` names the columns of each field, the table ``units`` their units
            where they are not s, rad, m, N m; ``lap``, ``mass``, ``start`` (the time of phase 0), ``period`` (resample
            to it), joint limits, ``delimiter`` and ``quat_order`` stand before them.

    Returns:
        The log, checked.

    Raises:
        InvalidInput: If a file cannot be read, a key or a column does not exist, or a cell is no number.
        InvalidLog: If the columns cannot be what the mapping says.
    """
    described = _described(mapping)
    names, order = _header(file, str(described.get("delimiter", ","))), described.get("quat_order", "xyzw")
    columns = {field: _places(field, named, names, mapping) for field, named in described["columns"].items()}
    table = _numbers(file, str(described.get("delimiter", ",")), len(names))
    found = {field: table[:, places] * _factor(field, described, mapping) for field, places in columns.items()}
    for field in {"quat", "quat_ref"} & set(found) if order == "wxyz" else ():
        found[field] = np.roll(found[field], -1, axis=1)
    found["t"] = found["t"][:, 0] - _number("start", described, mapping)
    limits = {name: described[name] for name in LIMITS if name in described}
    scalars = {name: _number(name, described, mapping) for name in ("lap", "mass") if name in described}
    log = Log(**found, **limits, **scalars)  # type: ignore[arg-type]
    return log.resampled(_number("period", described, mapping)) if "period" in described else log


def _described(mapping: Path) -> dict[str, dict[str, object]]:
    """Return the mapping with keys that exist."""
    try:
        described = tomllib.loads(mapping.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InvalidInput(" ".join(str(error).split()), str(mapping), "valid is a TOML file") from error
    _known("key", described, (*TABLES, *NUMBERS, *WORDS), mapping)
    for table, keys in TABLES.items():
        if not isinstance(described.setdefault(table, {}), Mapping):
            raise InvalidInput(f"{table} is no table", str(mapping), f"valid is a table [{table}]")
        _known(f"field in [{table}]", described[table], keys, mapping)
    if "t" not in described["columns"]:
        raise InvalidInput("no column for t", str(mapping), 'valid is a table [columns] with t = "NAME"')
    if described.get("quat_order", "xyzw") not in ("xyzw", "wxyz"):
        raise InvalidInput(f"quat_order {described['quat_order']!r}", str(mapping), "valid are xyzw and wxyz")
    if len(str(described.get("delimiter", ","))) != 1:
        raise InvalidInput(f"delimiter {described['delimiter']!r}", str(mapping), "valid is one character")
    return described


def _known(kind: str, given: Mapping[str, object], valid: Sequence[str], where: Path) -> None:
    for name in given:
        if name not in valid:
            raise InvalidInput(f"unknown {kind}: {name!r}", str(where), _nearest(name, valid))


def _nearest(name: str, valid: Sequence[str]) -> str:
    near = difflib.get_close_matches(name, valid, n=1)
    return f"did you mean {near[0]!r}?" if near else f"valid are {', '.join(valid)}"


def _number(name: str, described: Mapping[str, object], mapping: Path) -> float:
    value = described.get(name, 0.0)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidInput(f"{name} is {value!r}", str(mapping), "valid is a number")
    return float(value)


def _factor(field: str, described: Mapping[str, Mapping[str, object]], mapping: Path) -> float:
    if field not in described["units"]:
        return 1.0
    unit, valid = str(described["units"][field]), UNITS[field]
    if unit not in valid:
        raise InvalidInput(f"unknown unit of {field}: {unit!r}", str(mapping), _nearest(unit, tuple(valid)))
    return valid[unit]


def _header(file: Path, delimiter: str) -> list[str]:
    try:
        with file.open(newline="", encoding="utf-8-sig") as lines:
            names = [name.strip() for name in next(csv.reader(lines, delimiter=delimiter), [])]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InvalidInput(" ".join(str(error).split()), str(file), "valid is a CSV file") from error
    if not names:
        raise InvalidInput("the file is empty", str(file), "valid is a line of column names, then rows")
    return names


def _places(field: str, named: object, names: Sequence[str], mapping: Path) -> list[int]:
    """Return the places of a field's columns; ``"q{}"`` stands for q1, q2 and so on, as many as there are."""
    asked = named if isinstance(named, list) else [named]
    if isinstance(named, str) and "{}" in named:
        count = next(i for i in range(len(names) + 1) if named.replace("{}", str(i + 1)) not in names)
        asked = [named.replace("{}", str(i + 1)) for i in range(max(count, 1))]
    if not asked or (field == "t" and len(asked) != 1):
        valid = "valid is one for t, one or more for others"
        raise InvalidInput(f"{field} names {len(asked)} columns", str(mapping), valid)
    for name in asked:
        if name not in names:
            came = f"{field} names the column {name!r}, which is not there"
            raise InvalidInput(came, str(mapping), _nearest(str(name), names))
        if names.count(name) > 1:
            raise InvalidInput(f"{field} names the column {name!r}, which is there twice", str(mapping), "rename one")
    return [names.index(str(name)) for name in asked]


def _numbers(file: Path, delimiter: str, columns: int) -> np.ndarray:
    try:
        with warnings.catch_warnings(action="ignore"):  # a file without rows: said below, in one line
            table = np.loadtxt(file, delimiter=delimiter, skiprows=1, ndmin=2, encoding="utf-8-sig", comments=None)
    except ValueError as error:
        came = str(error).partition(";")[0].rstrip(".")
        raise InvalidInput(came, str(file), "valid are numbers in every cell, nan for none") from error
    if table.size == 0 or table.shape[1] != columns:
        came = "no rows" if table.size == 0 else f"rows of {table.shape[1]} cells"
        raise InvalidInput(came, str(file), f"valid are rows of {columns}, one for each column name")
    return np.asarray(table)
