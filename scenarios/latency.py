"""Latency: by how many ticks a command acts late, a number for all calls or the wall time of each."""

import difflib
from typing import Final, Literal

from ..controllers import InvalidInput

MEASURED: Final = "measured"
"""Every command is late by the whole ticks that its own call took: a property of the machine, and of its mood."""

Latency = int | Literal["measured"]
VALID = f"whole ticks from 0, or {MEASURED!r}"


def parse_latency(text: str) -> Latency:
    """Return the latency that a text names.

    Raises:
        InvalidInput: If it is neither a number of ticks nor ``measured``.
    """
    return check_latency(int(text) if text.removeprefix("-").isdecimal() else text, where="--latency")


def check_latency(value: object, *, where: str) -> Latency:
    """Return a latency as it came.

    Args:
        value: What came.
        where: Where it came from, for the message.

    Raises:
        InvalidInput: If it is no latency.
    """
    if value == MEASURED:
        return MEASURED
    if type(value) is int and value >= 0:
        return value
    is_near = isinstance(value, str) and difflib.get_close_matches(value, [MEASURED])
    raise InvalidInput(f"latency = {value!r}", where, f"did you mean {MEASURED!r}?" if is_near else VALID)
