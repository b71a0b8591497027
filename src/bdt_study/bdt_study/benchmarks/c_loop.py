"""The loop of ``closed_loop.c``: built, loaded and called like the kernel."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.plant import DiscretePlant
from bdt_study.simulation.loop_model import DiscreteLoop, LoopInputs, LoopState

FloatArray = NDArray[np.float64]

SOURCE = Path(__file__).with_name("closed_loop.c")
FLAGS = ("-O3", "-march=native", "-ffast-math")
KEPT = ("u", "theta_m", "theta_d", "q3")
"""Signals that the C loop writes, in its order."""


class NoCompilerError(Exception):
    """The C loop cannot be built here; the message says why."""


def build_c_loop(source: Path = SOURCE) -> ctypes.CDLL:
    """Compile and load the C loop.

    Raises
    ------
    NoCompilerError
        If there is no compiler, no source or it does not compile.
    """
    named = (os.environ.get("CC"), "cc", "gcc", "clang")
    compiler = next((path for name in named if name and (path := shutil.which(name))), None)
    if compiler is None:
        raise NoCompilerError("no C compiler")
    if not source.is_file():
        raise NoCompilerError(f"no {source}")
    with tempfile.TemporaryDirectory() as folder:
        compiled, library = Path(folder) / "closed_loop.o", Path(folder) / "closed_loop.so"
        _run(compiler, *FLAGS, "-fPIC", "-c", str(source), "-o", str(compiled))
        # Linked without -ffast-math: with it, gcc before 13 lets the library switch subnormal
        # floats off for the whole process that loads it.
        _run(compiler, "-shared", str(compiled), "-o", str(library), "-lm")
        return ctypes.CDLL(str(library))


def c_loop_call(
    library: ctypes.CDLL,
    state: LoopState,
    step: DiscreteLoop,
    inputs: LoopInputs,
    signals: tuple[FloatArray, ...],
) -> Callable[[], None]:
    """Return a function without arguments that runs the C loop from rest.

    Parameters
    ----------
    library : ctypes.CDLL
        From :func:`build_c_loop`.
    state : LoopState
        State at rest; it says on which side of the gap the motor is.
    step : DiscreteLoop
        Discrete models.
    inputs : LoopInputs
        Inputs.
    signals : tuple of ndarray, each of shape (samples,)
        Written: the signals ``KEPT``.
    """
    if not isinstance(step.plant, DiscretePlant):
        raise TypeError("the C loop is that of the paper's mechanism")
    motor, structure, contact, pitch, _friction = step.plant  # the C loop has no friction
    coefficients = np.array(_flat((motor, structure, contact, pitch, step.control.pid)))
    arrays = (*inputs[:2], inputs.gaps[1:], *signals)
    steps = inputs.references.size
    numbers = (state.plant.contact, steps, signals[0].size // steps)
    arguments = (
        _pointer(coefficients),
        *(ctypes.c_long(number) for number in numbers),
        *(_pointer(array) for array in arrays),
    )

    def call(_alive: Any = (coefficients, arrays)) -> None:
        # The default argument keeps the arrays behind the pointers alive.
        library.closed_loop(*arguments)

    return call


def _run(*command: str) -> None:
    result = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if result.returncode:
        raise NoCompilerError(f"{command[0]} failed: {result.stderr.strip()[:200]}")


def _flat(nested: Any) -> list[float]:
    """Return the numbers of nested tuples in order, which is the layout of the C structures."""
    if isinstance(nested, tuple):
        return [number for part in nested for number in _flat(part)]
    return [float(nested)]


def _pointer(array: FloatArray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)
