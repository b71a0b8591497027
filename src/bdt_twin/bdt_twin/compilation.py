"""Compilation of the loops over samples, from which a node gets the floats of plain Python."""

from collections.abc import Callable
from typing import Any

from numba import njit, types

GIVEN = types.Array(types.float64, 1, "C", readonly=True)
"""Numba's type of an array of shape (n,) that a loop reads."""

WRITTEN = types.Array(types.float64, 1, "C")
"""Numba's type of an array of shape (n,) that a loop writes."""


def numbers(count: int) -> Any:
    """Return numba's type of a tuple of `count` floats."""
    return types.UniTuple(types.float64, count)  # type: ignore[no-untyped-call]


def compile_loop(function: Callable[..., Any], signature: Any) -> Any:
    """Return a function compiled for one signature, at once rather than at its first call.

    Parameters
    ----------
    function : callable
        A function that calls no other one of ours: numba's cache only sees its own file change.
    signature : numba signature
        Types of result and arguments.
    """
    try:
        return njit([signature], cache=True, nogil=True)(function)
    except RuntimeError:
        # Neither beside the file nor in the home folder can a cache be written. Compiling anew
        # takes a second at each start, which is better than no start.
        return njit([signature], nogil=True)(function)
