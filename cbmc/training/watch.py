"""How training reports its progress."""

from collections.abc import Callable

Watch = Callable[[float], None]
"""Is told the share of the work that is done, 0 to 1."""


def unwatched(share: float) -> None:
    """Take note of nothing.

    Args:
        share: Share of the work that is done.
    """
