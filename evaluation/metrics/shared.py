"""Intermediate series that several metrics of one window share, computed once."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

_memory: ContextVar[dict[object, tuple[object, object]] | None] = ContextVar("_memory", default=None)


@contextmanager
def sharing() -> Iterator[None]:
    """Remember the results of :func:`shared` functions until the block ends; the arrays must not change in it."""
    token = _memory.set({})
    try:
        yield
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
        if key not in memory:
            result = function(*args, **kwargs)
            if isinstance(result, np.ndarray):
                result.setflags(write=False)
            # The arguments are kept alive with the result: an id is unique only as long as its object lives.
            memory[key] = ((args, kwargs), result)
        return memory[key][1]  # type: ignore[return-value]

    return call


@shared
def is_finite(samples: np.ndarray) -> bool:
    """Return whether every sample is finite.

    Args:
        samples: Any shape.
    """
    return bool(np.isfinite(samples).all())
