"""Intermediate series that several metrics of one window share, computed once."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class Memory:
    """What the metrics of one log have computed so far."""

    def __init__(self) -> None:
        self.results: dict[object, tuple[object, object]] = {}
        self._wholes: dict[int, tuple[np.ndarray, np.ndarray, slice]] = {}

    def part(self, whole: np.ndarray, rows: slice) -> np.ndarray:
        """Return rows of an array, and remember whose they are.

        Args:
            whole: The array of the whole run, shape (N, ...).
            rows: Which of its rows.
        """
        view = whole[rows]
        # The view is kept: an id is unique only as long as its object lives.
        self._wholes[id(view)] = (view, whole, rows)
        return view

    def whole_of(self, arguments: Sequence[object]) -> tuple[list[object], slice] | None:
        """Return arguments with the whole arrays in place of their parts, and the rows; None if one is no part."""
        arrays = [a for a in arguments if isinstance(a, np.ndarray)]
        known = [self._wholes.get(id(a)) for a in arrays]
        if not known or any(entry is None for entry in known):
            return None
        wholes = {id(view): whole for view, whole, _ in filter(None, known)}
        return [wholes[id(a)] if isinstance(a, np.ndarray) else a for a in arguments], known[0][2]  # type: ignore[index]


_memory: ContextVar[Memory | None] = ContextVar("_memory", default=None)


@contextmanager
def sharing() -> Iterator[Memory]:
    """Remember the results of :func:`shared` functions until the block ends; the arrays must not change in it."""
    token = _memory.set(Memory())
    try:
        yield _memory.get()  # type: ignore[misc]
    finally:
        _memory.reset(token)


def shared(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Let metrics that reduce the same series compute it once inside a :func:`sharing` block.

    Outside such a block the function is called as it is, so a metric on bare arrays keeps no state.

    Args:
        function: A pure function of arrays and numbers; an array it returns becomes read-only.

    Returns:
        The same function, remembering by the identity of its arrays.
    """

    @wraps(function)
    def call(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        memory = _memory.get()
        if memory is None:
            return function(*args, **kwargs)
        key = (function, *(id(a) if isinstance(a, np.ndarray) else a for a in (*args, *kwargs.values())))
        if key not in memory.results:
            result = function(*args, **kwargs)
            if isinstance(result, np.ndarray):
                result.setflags(write=False)
            # The arguments are kept alive with the result: an id is unique only as long as its object lives.
            memory.results[key] = ((args, kwargs), result)
        return memory.results[key][1]  # type: ignore[return-value]

    return call


def shared_series(function: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """Let windows of one run share a series whose value at a tick belongs to the run, not to the window.

    Inside a :func:`sharing` block it is computed on the whole run, and a window takes its rows.

    Args:
        function: A pure function of arrays, positional, with a row of its result for each row of theirs.

    Returns:
        The same function, remembering.
    """
    remembered = shared(function)

    @wraps(function)
    def call(*args: object) -> np.ndarray:
        memory = _memory.get()
        found = memory.whole_of(args) if memory is not None else None
        if found is None:
            return remembered(*args)
        wholes, rows = found
        return remembered(*wholes)[rows]

    return call


@shared
def is_finite(samples: np.ndarray) -> bool:
    """Return whether every sample is finite.

    Args:
        samples: Any shape.
    """
    return bool(np.isfinite(samples).all())
