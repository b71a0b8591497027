"""Compilation of the loops over samples, from which a node gets the floats of plain Python."""

import hashlib
import inspect
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from threading import Lock
from typing import Any

GIVEN = "Array(float64, 1, 'C', readonly=True)"
"""Numba's type of an array of shape (n,) that a loop reads."""

WRITTEN = "Array(float64, 1, 'C')"
"""Numba's type of an array of shape (n,) that a loop writes."""

_COMPILING = Lock()
"""Held while the settings of numba, which are those of all threads, are those of our loops."""


def compile_loop(function: Callable[..., Any], signature: Any) -> Any:
    """Return a function compiled for one signature, at once rather than at its first call.

    Parameters
    ----------
    function : callable
        A function that calls no other one of ours: numba's cache only sees its own file change.
    signature : str or tuple of numba types
        Types of result and arguments in numba's words, or those of the arguments alone.

    Returns
    -------
    callable
        The function itself where numba is not installed, as on many a small computer: the same
        floats, and still many times faster than a sensor samples.

    Raises
    ------
    TypeError
        If the function returns named tuples, see :mod:`bdt_plant.unnamed_states`, or arrays.
    """
    if find_spec("numba") is None:
        return function
    njit = import_module("numba").njit
    with _rows_in_vectors():
        try:
            loop = njit([signature], cache=True, nogil=True)(function)
        except RuntimeError:
            # Neither beside the file nor in the home folder can a cache be written. Compiling anew
            # takes a second at each start, which is better than no start.
            loop = njit([signature], nogil=True)(function)
    [compiled] = loop.nopython_signatures
    if not _is_made_without_python(compiled.return_type):
        raise TypeError(
            f"{function.__qualname__} returns {compiled.return_type}: must be numbers and tuples "
            "without names, or Ctrl-C in it may crash Python"
        )
    return loop


def _is_made_without_python(result: Any) -> bool:
    """Tell whether numba makes a result of this type without running any code of Python."""
    types: Any = import_module("numba").types
    if isinstance(result, types.BaseTuple) and not isinstance(result, types.BaseNamedTuple):
        return all(map(_is_made_without_python, result))
    return isinstance(result, types.Number | types.Boolean | types.NoneType)


@contextmanager
def _rows_in_vectors() -> Iterator[None]:
    """Let LLVM work on the rows of a step side by side: half of the time, the same floats.

    Loops share their steps, and a step stays as it came out of the first loop that was compiled
    with it, so this holds for all loops or for none.
    """
    settings: Any = import_module("numba").config
    with _COMPILING:
        # Numba reads the environment anew when it compiles, if that has changed since it was
        # imported, and would forget this setting; and what it compiles then is kept for ever.
        settings.reload_config()
        before = settings.SLP_VECTORIZE
        settings.SLP_VECTORIZE = 1
        try:
            yield
        finally:
            settings.SLP_VECTORIZE = before


def compile_with_steps(
    build: Callable[[str], Callable[..., Any]],
    steps: Iterable[Callable[..., Any]],
    signature: Callable[[], Any],
) -> Any:
    """Return a loop compiled together with the step functions of a model that it calls.

    The steps stay what the nodes run; they and all that they call are made known to numba from
    here. Numba's cache watches the file of the loop only and would go on with the equations of
    yesterday when a step changes. What a closure holds is part of the key, so the loop is a
    closure that holds a hash of the sources, this one among them. The hash is part of its name,
    too, which names the cache's index: numba would read the classes that an earlier index names
    before its age.

    Parameters
    ----------
    build : callable
        Takes the hash and returns the loop, in which the name of the hash occurs.
    steps : iterable of callable
        Step functions that the loop calls.
    signature : callable
        Returns numba's types of the arguments; asked only where numba is installed.

    Returns
    -------
    callable
        The loop itself where numba is not installed.
    """
    if find_spec("numba") is None:
        return build("")
    sources = source_hash(source_files(steps) | {inspect.getfile(build), __file__})
    loop = build(sources)
    loop.__qualname__ = f"{loop.__qualname__}_{sources[:16]}"
    return compile_loop(loop, signature())


def source_files(steps: Iterable[Callable[..., Any]]) -> frozenset[str]:
    """Let numba compile step functions and all they call, and return the files they are in."""
    return frozenset[str]().union(*map(_compilable, steps))


def source_hash(files: Iterable[str]) -> str:
    """Return the hash that changes with any of the files."""
    return hashlib.sha256(b"".join(Path(name).read_bytes() for name in sorted(files))).hexdigest()


@cache
def _compilable(function: Callable[..., Any]) -> frozenset[str]:
    """Let numba compile a step function and all it calls, and return the files they are in.

    Steps become part of the loop: called, each would be given copies of a model's constants with
    every sample, which takes as long as the equations.
    """
    import_module("numba.extending").register_jitable(forceinline=True)(function)
    names = inspect.getclosurevars(function).globals.values()
    files = frozenset([inspect.getfile(function)])
    return files.union(*(_compilable(called) for called in names if inspect.isfunction(called)))
