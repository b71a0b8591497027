"""The control loop as one numba kernel, made of the very step functions that the nodes call.

Nothing of the paper is written here a second time. The steps of plant (eqs 1, 2, 3, 6) and
controller (eqs 4, 5, 7, 8), of sensor and actuator are compiled from outside, so the cores know
nothing of numba, and the kernel gives the floats of the plain Python loop, bit for bit.
"""

from collections.abc import Callable, Collection
from functools import cache
from typing import Any

import numpy as np
from numba import typeof, types
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from bdt_controller.control_law import ControlState, control_step
from bdt_controller.notch import NotchState
from bdt_controller.pid import PidGains, PidState
from bdt_plant.actuator import amplified, saturated
from bdt_plant.compilation import compile_with_steps
from bdt_plant.machine import (
    MACHINE_AT_REST,
    DiscreteMachine,
    discretize_machine,
    first_platform_of_machine,
    machine_step,
)
from bdt_plant.plant import PlantModel, Sampling, first_platform, plant_step
from bdt_plant.sensor import seen_position, sensor_reading
from bdt_plant.sensor_delay import delayed
from bdt_plant.unnamed_states import named_machine, named_plant, unnamed_machine, unnamed_plant
from bdt_study.simulation.loop_model import (
    DiscreteLoop,
    LoopInputs,
    LoopState,
    SensorState,
    discretize_loop,
    loop_at_rest,
)

FloatArray = NDArray[np.float64]

SIMULATED = ("u", "current", "omega_m", "theta_m", "theta_d", "q1", "q2", "q3", "measured")
"""Signals that the kernel writes, in its order."""
INNER = tuple(name for name in SIMULATED if name not in ("u", "q3"))
"""Those that telemetry does not hold: the kernel writes all of them or none."""


def allocate(samples: int, keep: Collection[str] = SIMULATED) -> tuple[FloatArray, ...]:
    """Return the arrays that the kernel writes, those not kept with a single place in memory.

    A stride of zero saves the memory, which costs time, without a second kernel to compile. Where
    no signal of ``INNER`` is kept, these are empty: seven stores in each sample take about as long
    as a tenth of the arithmetic.

    Parameters
    ----------
    samples : int
        Number of samples.
    keep : collection of str
        Signals to keep, out of ``SIMULATED``.

    Returns
    -------
    tuple of ndarray, each of shape (samples,) or empty
        In the order of ``SIMULATED``.
    """
    is_traced = not set(INNER).isdisjoint(keep)

    def array(name: str) -> FloatArray:
        if name in keep:
            return np.empty(samples)
        if name in INNER and not is_traced:
            return np.empty(0)
        # Eight floats, so that each has a cache line of its own.
        return as_strided(np.empty(8), (samples,), (0,))

    return tuple(map(array, SIMULATED))


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
    signals : tuple of ndarray, each of shape (samples,) or empty
        Written: the signals ``SIMULATED``, as :func:`allocate` returns them. Where q1 is kept,
        theta_d is, too.
    """
    is_machine = isinstance(step.plant, DiscreteMachine)
    # The loop writes into what the sensor remembers; the state before stays as it was.
    line, recent = state.sensor.line.copy(), state.sensor.recent.copy()
    state = state._replace(sensor=state.sensor._replace(line=line, recent=recent))
    loop = compiled_loop(is_machine=is_machine)
    plant, (pid, notch, *others), reading = loop(state, step, *inputs, *signals)
    q1 = signals[SIMULATED.index("q1")]
    if not is_machine and q1.strides[0]:
        # Platform 1 follows the screw (eq. 1): storing it in the loop takes 6 % more time.
        np.multiply(step.plant.pitch, signals[SIMULATED.index("theta_d")], out=q1)
    return LoopState(
        named_machine(plant) if is_machine else named_plant(plant),
        ControlState(PidState(*pid), NotchState(*notch), *others),
        SensorState(state.sensor.sample + signals[0].size, reading, line, recent),
    )


SHARED = (control_step, saturated, amplified, delayed, seen_position, sensor_reading)
COMPILED = (plant_step, first_platform, unnamed_plant, *SHARED)
"""Step functions of the cores that the kernel calls."""


@cache
def compiled_loop(*, is_machine: bool) -> Any:
    """Return the compiled loop, from numba's cache if there is one of these very sources.

    Parameters
    ----------
    is_machine : bool
        Whether the plant is one that is not linear: it has a loop of its own, so that the paper's
        is as fast as if there were no other.
    """
    if is_machine:
        steps = (machine_step, first_platform_of_machine, unnamed_machine, *SHARED)
        return compile_with_steps(_machine_loop, steps, _machine_signature)
    return compile_with_steps(_closed_loop, COMPILED, _signature)


def _machine_signature() -> Any:
    _, _, *arrays = _signature()
    step = discretize_loop(PlantModel(), PidGains(), Sampling())
    step = step._replace(plant=discretize_machine(PlantModel(), Sampling()))
    state = loop_at_rest(0.0, plant=MACHINE_AT_REST)
    return typeof(state), typeof(step), *arrays  # type: ignore[no-untyped-call]


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


def _closed_loop(sources: str) -> Callable[..., Any]:
    return _loop_around(
        plant_step, first_platform, unnamed_plant, is_machine=False, sources=sources
    )


def _machine_loop(sources: str) -> Callable[..., Any]:
    return _loop_around(
        machine_step, first_platform_of_machine, unnamed_machine, is_machine=True, sources=sources
    )


def _loop_around(
    plant_step: Any, first_platform: Any, unnamed: Any, *, is_machine: bool, sources: str
) -> Callable[..., Any]:
    def closed_loop(
        state: LoopState,
        step: DiscreteLoop,
        references: FloatArray,
        tolerances: FloatArray,
        gaps: FloatArray,
        noises: FloatArray,
        offsets: FloatArray,
        u: FloatArray,
        current: FloatArray,
        omega_m: FloatArray,
        theta_m: FloatArray,
        theta_d: FloatArray,
        q1: FloatArray,
        q2: FloatArray,
        q3: FloatArray,
        measured: FloatArray,
    ) -> tuple[Any, Any, float]:
        _ = sources
        plant, control, sensor = state
        begin, reading, line, recent = sensor
        hold = (gaps.size - 1) // references.size
        is_traced = current.size > 0
        voltage = applied = 0.0
        for k in range(references.size):
            for sample in range(k * hold, (k + 1) * hold):
                position = plant.structure.q3
                if noises.size > 0:
                    position = delayed(line, begin + sample, position)
                    if step.sensor.is_odd:
                        position = seen_position(position, begin + sample, recent, step.sensor)
                    quantization = step.sensor.quantization
                    reading = sensor_reading(position, noises[sample], reading, quantization)
                else:
                    reading = position
                if sample == k * hold:
                    error = references[k] - reading
                    offset = offsets[k] if offsets.size > 0 else 0.0
                    control, voltage = control_step(
                        control, error, tolerances[k], step.control, step.command_limit, offset
                    )
                    voltage = saturated(voltage, step.amplifier.limit)
                    applied = amplified(voltage, step.amplifier)
                u[sample] = voltage
                q3[sample] = plant.structure.q3
                if is_traced:
                    current[sample] = plant.motor.current
                    omega_m[sample] = plant.motor.speed
                    theta_m[sample] = plant.motor.angle
                    theta_d[sample] = plant.theta_d
                    if is_machine:
                        q1[sample] = first_platform(plant, step.plant)
                    q2[sample] = plant.structure.q2
                    measured[sample] = reading
                plant = plant_step(plant, applied, gaps[sample + 1], step.plant)
        pid, notch, tolerance, offset, blend = control
        return unnamed(plant), (pid[:], notch[:], tolerance, offset, blend), reading

    return closed_loop
