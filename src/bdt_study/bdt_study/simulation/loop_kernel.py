"""The control loop as one numba kernel, made of the very step functions that the nodes call.

Nothing of the paper is written here a second time. The steps of plant (eqs 1, 2, 3, 6) and
controller (eqs 4, 5, 7, 8), of sensor and actuator are compiled from outside, so the cores know
nothing of numba, and the kernel gives the floats of the plain Python loop, bit for bit.
"""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import config, typeof, types
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from bdt_controller.pid import INITIAL_PID, DiscretePid, PidGains, PidState, discretize_pid
from bdt_controller.voltage_limit import limited_pid_step
from bdt_plant.actuator import IDEAL_ACTUATOR, Amplifier, amplified, amplifier_of, saturated
from bdt_plant.compilation import compile_with_steps
from bdt_plant.lead_screw import contact_side
from bdt_plant.plant import (
    AT_REST,
    DiscretePlant,
    PlantModel,
    PlantState,
    Sampling,
    discretize_plant,
    plant_step,
)
from bdt_plant.sensor import IDEAL_SENSOR, DiscreteSensor, discretize_sensor, sensor_reading
from bdt_plant.sensor_delay import delay_line

FloatArray = NDArray[np.float64]

SIMULATED = ("u", "current", "omega_m", "theta_m", "theta_d", "q2", "q3", "measured")
"""Signals that the kernel writes, in its order."""


class SensorState(NamedTuple):
    """State of the sensor between two control periods.

    Attributes
    ----------
    sample : int
        Number of the next sample.
    reading : float
        Reading of the sample before [m].
    line : ndarray
        Positions that were not yet read, see :func:`bdt_plant.sensor_delay.delay_line` [m].
    """

    sample: int
    reading: float
    line: FloatArray


IDEAL_DISCRETE = discretize_sensor(IDEAL_SENSOR, 1.0)
"""The ideal sensor, at any sampling rate."""


class LoopState(NamedTuple):
    """State of plant, controller and sensor between two control periods."""

    plant: PlantState
    pid: PidState
    sensor: SensorState


class DiscreteLoop(NamedTuple):
    """Discrete models of plant and controller, and what limits them.

    Attributes
    ----------
    plant : DiscretePlant
        Plant.
    pid : DiscretePid
        Controller.
    command_limit : float
        Voltage limit of the controller [V]; 0 for none.
    amplifier : Amplifier
        Actuator.
    sensor : DiscreteSensor
        Sensor.
    """

    plant: DiscretePlant
    pid: DiscretePid
    command_limit: float = 0.0
    amplifier: Amplifier = amplifier_of(IDEAL_ACTUATOR)
    sensor: DiscreteSensor = IDEAL_DISCRETE


IDEAL = np.empty(0)
IDEAL.flags.writeable = False
"""Noise of the ideal sensor, which has none."""


class LoopInputs(NamedTuple):
    """What acts on the loop, sample by sample.

    Attributes
    ----------
    references, tolerances : ndarray, shape (control steps,)
        Reference r and dead-zone tolerance epsilon_dz at each measurement [m].
    gaps : ndarray, shape (samples + 1,)
        Gap theta_b at each sample and at the end of the last one [rad].
    noises : ndarray, shape (samples,)
        Noise of the sensor at each sample [m], NaN where a sample is dropped; empty for a sensor
        that is ideal and reads the true position.
    """

    references: FloatArray
    tolerances: FloatArray
    gaps: FloatArray
    noises: FloatArray = IDEAL

    def between(self, first: int, last: int) -> "LoopInputs":
        """Return what acts on the loop from measurement `first` to before measurement `last`."""
        hold = (self.gaps.size - 1) // self.references.size
        return LoopInputs(
            self.references[first:last],
            self.tolerances[first:last],
            self.gaps[first * hold : last * hold + 1],
            self.noises[first * hold : last * hold],
        )


# The matrix exponentials take as long as ten seconds of the loop, and sweeps share them.
@lru_cache(maxsize=64)
def discretize_loop(model: PlantModel, gains: PidGains, sampling: Sampling) -> DiscreteLoop:
    """Return the discrete models of plant and controller."""
    plant = discretize_plant(model, 1.0 / sampling.sampling_rate)
    pid = discretize_pid(gains, 1.0 / sampling.control_rate)
    # A gain written as 3000 is an int, for which nothing is compiled.
    return DiscreteLoop(plant._replace(pitch=float(plant.pitch)), DiscretePid(*map(float, pid)))


def loop_at_rest(gap: float, sensor: DiscreteSensor = IDEAL_DISCRETE) -> LoopState:
    """Return the state in which new plant, controller and sensor begin.

    Parameters
    ----------
    gap : float
        First gap [rad].
    sensor : DiscreteSensor
        The sensor.
    """
    plant = AT_REST._replace(contact=contact_side(0.0, 0.0, gap))
    return LoopState(plant, INITIAL_PID, SensorState(0, 0.0, delay_line(sensor.delay)))


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
    state: LoopState, step: DiscreteLoop, inputs: LoopInputs, signals: tuple[FloatArray, ...]
) -> LoopState:
    """Run the compiled loop over the inputs and return the state after them.

    Parameters
    ----------
    state : LoopState
        State at the first measurement.
    step : DiscreteLoop
        Discrete models.
    inputs : LoopInputs
        Inputs of all control periods.
    signals : tuple of ndarray, each of shape (samples,)
        Written: the signals ``SIMULATED``.
    """
    result: LoopState = compiled_loop()(state, step, *inputs, *signals)
    return result


COMPILED = (plant_step, limited_pid_step, saturated, amplified, sensor_reading)
"""Step functions of the cores that the kernel calls."""


@cache
def compiled_loop() -> Any:
    """Return the compiled loop, from numba's cache if there is one of these very sources."""
    with _rows_in_vectors():
        return compile_with_steps(_closed_loop, COMPILED, _signature)


def _signature() -> Any:
    signal = types.Array(types.float64, 1, "A")
    given = types.Array(types.float64, 1, "C", readonly=True)
    step = discretize_loop(PlantModel(), PidGains(), Sampling())
    return (
        typeof(loop_at_rest(0.0)),  # type: ignore[no-untyped-call]
        typeof(step),  # type: ignore[no-untyped-call]
        *(given for _ in LoopInputs._fields),
        *(signal for _ in SIMULATED),
    )


def _closed_loop(sources: str) -> Callable[..., LoopState]:
    def closed_loop(
        state: LoopState,
        step: DiscreteLoop,
        references: FloatArray,
        tolerances: FloatArray,
        gaps: FloatArray,
        noises: FloatArray,
        u: FloatArray,
        current: FloatArray,
        omega_m: FloatArray,
        theta_m: FloatArray,
        theta_d: FloatArray,
        q2: FloatArray,
        q3: FloatArray,
        measured: FloatArray,
    ) -> LoopState:
        _ = sources
        plant, pid, sensor = state
        begin, reading, line = sensor.sample, sensor.reading, sensor.line.copy()
        hold = (gaps.size - 1) // references.size
        voltage = applied = 0.0
        for k in range(references.size):
            for sample in range(k * hold, (k + 1) * hold):
                position = plant.structure.q3
                if noises.size > 0:
                    reading = sensor_reading(
                        line, begin + sample, position, noises[sample], reading, step.sensor
                    )
                else:
                    reading = position
                if sample == k * hold:
                    error = references[k] - reading
                    pid, voltage = limited_pid_step(
                        pid, error, tolerances[k], step.pid, step.command_limit
                    )
                    voltage = saturated(voltage, step.amplifier.limit)
                    applied = amplified(voltage, step.amplifier)
                u[sample] = voltage
                current[sample] = plant.motor.current
                omega_m[sample] = plant.motor.speed
                theta_m[sample] = plant.motor.angle
                theta_d[sample] = plant.theta_d
                q2[sample] = plant.structure.q2
                q3[sample] = plant.structure.q3
                measured[sample] = reading
                plant = plant_step(plant, applied, gaps[sample + 1], step.plant)
        return LoopState(plant, pid, SensorState(begin + u.size, reading, line))

    return closed_loop


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
