"""Errors that a user can cause: a sentence for a person, data for a program."""

import difflib
from collections.abc import Sequence


class TorquebenchError(Exception):
    """Root of every error that names a wrong input; the command line prints it in one line."""


class UnknownName(TorquebenchError):
    """A controller, trajectory, robot or benchmark that nobody registered.

    Attributes:
        kind: What was looked up, for example ``"controller"``.
        name: The name that came.
        known: The names that would have been valid.
    """

    def __init__(self, kind: str, name: str, known: Sequence[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        nearest = difflib.get_close_matches(name, known, n=1)
        hint = f"; did you mean {nearest[0]!r}?" if nearest else f"; known: {', '.join(sorted(known))}"
        super().__init__(f"unknown {kind} {name!r}{hint}")


class InvalidInput(TorquebenchError):
    """An input of any kind that cannot be used.

    Attributes:
        what: What came.
        where: Where it came from: a file, a flag, a field.
        valid: What would have been valid.
    """

    def __init__(self, what: str, where: str = "", valid: str = "") -> None:
        self.what, self.where, self.valid = what, where, valid
        super().__init__("".join((f"{where}: " if where else "", what, f"; {valid}" if valid else "")))


class PlugInFailure(TorquebenchError):
    """A plug-in that could not be imported; carries where it was registered and the cause."""

    def __init__(self, kind: str, name: str, origin: str, cause: BaseException) -> None:
        self.kind, self.name, self.origin, self.cause = kind, name, origin, cause
        reason = " ".join(f"{type(cause).__name__}: {cause}".split())
        super().__init__(f"{kind} {name!r} ({origin}) could not be loaded: {reason}")


class Refusal(TorquebenchError):
    """A combination that would run but could not work; the reason carries the figure that shows it."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)
