"""Reads TOML files into validated records and says in one line what is wrong with them."""

import difflib
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from ..controllers import InvalidInput


class Record(BaseModel):
    """A table of a file: frozen, and no key that nobody reads."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


AnyRecord = TypeVar("AnyRecord", bound=Record)


def as_tuple(value: object) -> object:
    """Return a TOML list as a tuple and anything else as it came."""
    return tuple(value) if isinstance(value, list) else value


def _float(value: object) -> object:
    return float(value) if type(value) is int else value


Number = Annotated[float, BeforeValidator(_float), Field(allow_inf_nan=False)]
Numbers = Annotated[tuple[Number, ...], BeforeValidator(as_tuple)]
Point3 = Annotated[tuple[Number, Number, Number], BeforeValidator(as_tuple)]
Names = Annotated[tuple[str, ...], BeforeValidator(as_tuple)]


def read_toml(file: Path) -> dict[str, object]:
    """Read a TOML file.

    Args:
        file: The file.

    Raises:
        InvalidInput: If it cannot be read or is malformed.
    """
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as cause:
        reason = getattr(cause, "strerror", None) or "not UTF-8 text"
        raise InvalidInput(f"cannot be read ({reason})", str(file), "expected a TOML file") from cause
    except tomllib.TOMLDecodeError as cause:
        raise InvalidInput(f"malformed TOML: {cause}", str(file)) from cause


def validate(record: type[AnyRecord], table: Mapping[str, object], *, where: str) -> AnyRecord:
    """Return the record of a table.

    Args:
        record: The expected shape.
        table: What came.
        where: Where it came from, for messages.

    Raises:
        InvalidInput: Names the first key that is wrong, what came, and what would be valid.
    """
    try:
        return record.model_validate(table)
    except ValidationError as problem:
        # A misspelt key is missing too; the misspelling is what helps.
        first = min(problem.errors(), key=lambda error: error["type"] != "extra_forbidden")
        path = tuple(first["loc"])
        key = ".".join(str(part) for part in path)
        if first["type"] == "extra_forbidden":
            known = _known_keys(record, path[:-1])
            nearest = difflib.get_close_matches(str(path[-1]), known, n=1)
            valid = f"did you mean {nearest[0]!r}?" if nearest else f"valid keys: {', '.join(known)}"
            raise InvalidInput(f"unknown key {key!r}", where, valid) from problem
        if first["type"] == "missing":
            raise InvalidInput(f"key {key!r} is missing", where) from problem
        raise InvalidInput(f"{key} = {_shorten(first['input'])}", where, first["msg"]) from problem


def _known_keys(record: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    """Return the field names of the record that a path of keys leads to."""
    current: type[BaseModel] = record
    for part in path:
        field = current.model_fields.get(str(part))
        nested = _records_in(field.annotation) if field is not None else []
        current = nested[0] if nested else current
    return list(current.model_fields)


def _records_in(annotation: object) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [found for inner in getattr(annotation, "__args__", ()) for found in _records_in(inner)]


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
