"""Compilation of the loops over samples, from which a node gets the floats of plain Python."""

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

GIVEN = "Array(float64, 1, 'C', readonly=True)"
"""Numba's type of an array of shape (n,) that a loop reads."""

WRITTEN = "Array(float64, 1, 'C')"
"""Numba's type of an array of shape (n,) that a loop writes."""


def compile_loop(function: Callable[..., Any], signature: str) -> Any:
    """Return a function compiled for one signature, at once rather than at its first call.

    Parameters
    ----------
    function : callable
        A function that calls no other one of ours: numba's cache only sees its own file change.
    signature : str
        Types of result and arguments in numba's words.

    Returns
    -------
    callable
        The function itself where numba is not installed, as on many a small computer: the same
        floats, and still many times faster than a sensor samples.
    """
    if find_spec("numba") is None:
        return function
    njit = import_module("numba").njit
    try:
        return njit([signature], cache=True, nogil=True)(function)
    except RuntimeError:
        # Neither beside the file nor in the home folder can a cache be written. Compiling anew
        # takes a second at each start, which is better than no start.
        return njit([signature], nogil=True)(function)
