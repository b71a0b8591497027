"""The control loop as one numba kernel, made of the very step functions that the nodes call.

Nothing of the paper is written here a second time. The steps of plant (eqs 1, 2, 3, 6) and
controller (eqs 4, 5, 7, 8) are compiled from outside, so the cores know nothing of numba, and
the kernel gives the floats of the plain Python loop, bit for bit.
"""

import hashlib
import inspect
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import config, njit, typeof, types
from numba.extending import register_jitable
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from bdt_controller.dead_zone import dead_zone_pid_step
from bdt_controller.pid import INITIAL_PID, PidGains, PidState, PidStep, discretize_pid
from bdt_plant.lead_screw import contact_side
from bdt_plant.plant import (
    AT_REST,
    PlantModel,
    PlantState,
    PlantStep,
    Sampling,
    discretize_plant,
    plant_step,
)

FloatArray = NDArray[np.float64]

SIMULATED = ("u", "current", "omega_m", "theta_m", "theta_d", "q2", "q3")
"""Signals that the kernel writes, in its order."""


class LoopState(NamedTuple):
    """State of plant and controller between two control periods."""

    plant: PlantState
    pid: PidState


class LoopStep(NamedTuple):
    """Discrete models of plant and controller."""

    plant: PlantStep
    pid: PidStep


class LoopInputs(NamedTuple):
    """What acts on the loop, sample by sample.

    Attributes
    ----------
    references, tolerances : ndarray, shape (control steps,)
        Reference r and dead-zone tolerance epsilon_dz at each measurement [m].
    gaps : ndarray, shape (samples + 1,)
        Gap theta_b at each sample and at the end of the last one [rad].
    """

    references: FloatArray
    tolerances: FloatArray
    gaps: FloatArray


# The matrix exponentials take as long as ten seconds of the loop, and sweeps share them.
@lru_cache(maxsize=64)
def discretize_loop(model: PlantModel, gains: PidGains, sampling: Sampling) -> LoopStep:
    """Return the discrete models of plant and controller."""
    plant = discretize_plant(model, 1.0 / sampling.sampling_rate)
    pid = discretize_pid(gains, 1.0 / sampling.control_rate)
    # A gain written as 3000 is an int, for which nothing is compiled.
    return LoopStep(plant._replace(pitch=float(plant.pitch)), PidStep(*map(float, pid)))


def loop_at_rest(gap: float) -> LoopState:
    """Return the state in which a new plant and a new controller begin, for a first gap [rad]."""
    contact = contact_side(0.0, 0.0, gap)
    return LoopState(AT_REST._replace(contact=contact), INITIAL_PID)


def allocate(samples: int, keep: Collection[str] = SIMULATED) -> tuple[FloatArray, ...]:
    """Return the arrays that the kernel writes, those not kept with a single place in memory.

    The kernel always writes all signals: a store costs nothing beside the arithmetic, but memory
    does. A stride of zero saves the memory without a second kernel to compile.

    Parameters
    ----------
    samples : int
        Number of samples.
    keep : collection of str
        Signals to keep, out of ``SIMULATED``.

    Returns
    -------
    tuple of ndarray, each of shape (samples,)
        In the order of ``SIMULATED``.
    """
    return tuple(
        # Eight floats, so that each has a cache line of its own.
        np.empty(samples) if name in keep else as_strided(np.empty(8), (samples,), (0,))
        for name in SIMULATED
    )


def run_kernel(
    state: LoopState, step: LoopStep, inputs: LoopInputs, signals: tuple[FloatArray, ...]
) -> LoopState:
    """Run the compiled loop over the inputs and return the state after them.

    Parameters
    ----------
    state : LoopState
        State at the first measurement.
    step : LoopStep
        Discrete models.
    inputs : LoopInputs
        Inputs of the whole stretch.
    signals : tuple of ndarray, each of shape (samples,)
        Written: the signals ``SIMULATED``.
    """
    result: LoopState = compiled_loop()(state, step, *inputs, *signals)
    return result


@cache
def compiled_loop() -> Any:
    """Return the compiled loop, from numba's cache if there is one of these very sources."""
    return _compile_loop(_source_hash(_compilable(plant_step) | _compilable(dead_zone_pid_step)))


@cache
def _compilable(function: Callable[..., Any]) -> frozenset[str]:
    """Let numba compile a step function and all it calls, and return the files they are in."""
    register_jitable(function)
    names = inspect.getclosurevars(function).globals.values()
    files = frozenset([inspect.getfile(function)])
    return files.union(*(_compilable(called) for called in names if inspect.isfunction(called)))


def _source_hash(files: Iterable[str]) -> str:
    return hashlib.sha256(b"".join(Path(name).read_bytes() for name in sorted(files))).hexdigest()


def _compile_loop(sources: str) -> Any:
    # Numba's cache watches the file of the kernel only and would go on with the equations of
    # yesterday when a core changes. What a closure holds is part of the key, so it holds a hash.
    signal = types.Array(types.float64, 1, "A")
    given = types.Array(types.float64, 1, "C", readonly=True)
    step = discretize_loop(PlantModel(), PidGains(), Sampling())
    signature: Any = (
        typeof(loop_at_rest(0.0)),  # type: ignore[no-untyped-call]
        typeof(step),  # type: ignore[no-untyped-call]
        *(given for _ in LoopInputs._fields),
        *(signal for _ in SIMULATED),
    )

    def closed_loop(
        state: LoopState,
        step: LoopStep,
        references: FloatArray,
        tolerances: FloatArray,
        gaps: FloatArray,
        u: FloatArray,
        current: FloatArray,
        omega_m: FloatArray,
        theta_m: FloatArray,
        theta_d: FloatArray,
        q2: FloatArray,
        q3: FloatArray,
    ) -> LoopState:
        _ = sources
        plant, pid = state
        hold = (gaps.size - 1) // references.size
        for k in range(references.size):
            error = references[k] - plant.structure.q3
            pid, voltage = dead_zone_pid_step(pid, error, tolerances[k], step.pid)
            for sample in range(k * hold, (k + 1) * hold):
                u[sample] = voltage
                current[sample] = plant.motor.current
                omega_m[sample] = plant.motor.speed
                theta_m[sample] = plant.motor.angle
                theta_d[sample] = plant.theta_d
                q2[sample] = plant.structure.q2
                q3[sample] = plant.structure.q3
                plant = plant_step(plant, voltage, gaps[sample + 1], step.plant)
        return LoopState(plant, pid)

    with _rows_in_vectors():
        return njit([signature], cache=True, nogil=True)(closed_loop)


@contextmanager
def _rows_in_vectors() -> Iterator[None]:
    """Let LLVM work on the rows of a step side by side: a quarter less time, the same floats."""
    settings: Any = config
    before = settings.SLP_VECTORIZE
    settings.SLP_VECTORIZE = 1
    try:
        yield
    finally:
        settings.SLP_VECTORIZE = before
