"""Checks of settings: one sentence to the user, with what came and what would have been valid."""

import difflib
import math
from collections.abc import Iterable

from ..controllers import InvalidInput


def require_positive(name: str, value: object) -> None:
    """Refuse a setting that is not a finite number above 0.

    Args:
        name: Name of the setting.
        value: What the user gave.

    Raises:
        InvalidInput: If it is anything else.
    """
    if not _is_number(value) or value <= 0.0:  # type: ignore[operator]
        raise InvalidInput(f"{value!r} is not a positive number", f"setting {name!r}", "expected a value above 0")


def require_not_negative(name: str, value: object) -> None:
    """Refuse a setting that is not a finite number of at least 0.

    Args:
        name: Name of the setting.
        value: What the user gave.

    Raises:
        InvalidInput: If it is anything else.
    """
    if not _is_number(value) or value < 0.0:  # type: ignore[operator]
        raise InvalidInput(f"{value!r} is not a number of at least 0", f"setting {name!r}", "expected 0 or above")


def require_whole(name: str, value: object, *, least: int) -> None:
    """Refuse a setting that is not a whole number of at least some value.

    Args:
        name: Name of the setting.
        value: What the user gave.
        least: The smallest valid value.

    Raises:
        InvalidInput: If it is anything else.
    """
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        valid = f"expected {least}, {least + 1}, ..."
        raise InvalidInput(f"{value!r} is no whole number", f"setting {name!r}", valid)


def require_bool(name: str, value: object) -> None:
    """Refuse a setting that is neither True nor False: the text ``"false"`` would count as true.

    Args:
        name: Name of the setting.
        value: What the user gave.

    Raises:
        InvalidInput: If it is anything else.
    """
    if not isinstance(value, bool):
        raise InvalidInput(f"{value!r} is not a truth value", f"setting {name!r}", "expected true or false")


def require_one_of(name: str, value: object, known: Iterable[str]) -> None:
    """Refuse a setting that is not one of the known words.

    Args:
        name: Name of the setting.
        value: What the user gave.
        known: The valid words.

    Raises:
        InvalidInput: If it is none of them; names the nearest.
    """
    words = tuple(known)
    if value in words:
        return
    nearest = difflib.get_close_matches(str(value), words, n=1)
    hint = f"did you mean {nearest[0]!r}?" if nearest else f"known: {', '.join(words)}"
    raise InvalidInput(f"unknown word {value!r}", f"setting {name!r}", hint)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
