"""Calls compiled kernels without numba's look-up of argument types, which costs more than a small kernel does."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numba


def bind(kernel: Any, *arguments: object, tick: bool = False) -> Callable[..., Any]:
    """Return a kernel with its arguments fixed, compiled for their types.

    In a loop that leaves the processor's cache between two calls, the dispatcher takes 2 to 3 us to find the code for
    its arguments' types; a bound kernel goes there at once. The arrays are fixed, their content is not.

    Args:
        kernel: A function compiled by ``numba.njit``.
        *arguments: Its arguments, arrays and tuples of arrays.
        tick: Whether the kernel's last argument, an integer, is left to the caller.

    Returns:
        A callable without arguments, or with the tick as its only one.
    """
    every = (*arguments, 0) if tick else arguments
    signature = tuple(numba.typeof(argument) for argument in every)  # type: ignore[no-untyped-call]
    if signature not in kernel.overloads:
        kernel.compile(signature)
    return partial(kernel.overloads[signature].entry_point, *arguments)
