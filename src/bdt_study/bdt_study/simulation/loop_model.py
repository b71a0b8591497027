"""The control loop as numbers: state, discrete models and inputs of the kernel."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_controller.control_law import (
    INITIAL_CONTROL,
    ControlLaw,
    ControlState,
    discretize_control,
)
from bdt_controller.notch import NO_NOTCH, NotchFilter
from bdt_controller.pid import PidGains
from bdt_plant.actuator import IDEAL_ACTUATOR, Amplifier, amplifier_of
from bdt_plant.lead_screw import contact_side
from bdt_plant.machine import DiscreteMachine, MachineState, discretize_machine
from bdt_plant.plant import (
    AT_REST,
    DiscretePlant,
    PlantModel,
    PlantState,
    Sampling,
    discretize_plant,
)
from bdt_plant.sensor import IDEAL_SENSOR, DiscreteSensor, discretize_sensor
from bdt_plant.sensor_delay import delay_line, recent_positions

FloatArray = NDArray[np.float64]


class SensorState(NamedTuple):
    """State of the sensor between two control periods.

    Attributes
    ----------
    sample : int
        Number of the next sample.
    reading : float
        Reading of the sample before [m].
    line : ndarray, shape (samples of delay,)
        Positions not yet read [m].
    recent : ndarray, shape (3,)
        Positions that came out of the line before, the newest first [m].
    """

    sample: int
    reading: float
    line: FloatArray
    recent: FloatArray


IDEAL_DISCRETE = discretize_sensor(IDEAL_SENSOR, 1.0)
"""The ideal sensor, at any sampling rate."""


class LoopState(NamedTuple):
    """State of plant, controller and sensor between two control periods."""

    plant: PlantState | MachineState
    control: ControlState
    sensor: SensorState


class DiscreteLoop(NamedTuple):
    """Discrete models of plant and controller, and what limits them.

    Attributes
    ----------
    plant : DiscretePlant or DiscreteMachine
        Plant; the other one when it is not linear.
    control : ControlLaw
        Controller.
    command_limit : float
        Voltage limit of the controller [V]; 0 for none.
    amplifier : Amplifier
        Actuator.
    sensor : DiscreteSensor
        Sensor.
    """

    plant: DiscretePlant | DiscreteMachine
    control: ControlLaw
    command_limit: float = 0.0
    amplifier: Amplifier = amplifier_of(IDEAL_ACTUATOR)
    sensor: DiscreteSensor = IDEAL_DISCRETE


IDEAL = np.empty(0)
IDEAL.flags.writeable = False
"""Noise of the ideal sensor, which has none."""
NO_OFFSET = IDEAL
"""Offsets of a controller that adds none."""


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
    offsets : ndarray, shape (control steps,)
        Voltage that the controller adds to each command [V]; empty for none.
    """

    references: FloatArray
    tolerances: FloatArray
    gaps: FloatArray
    noises: FloatArray = IDEAL
    offsets: FloatArray = NO_OFFSET

    def between(self, first: int, last: int) -> "LoopInputs":
        """Return what acts on the loop from measurement `first` to before measurement `last`."""
        hold = (self.gaps.size - 1) // self.references.size
        return LoopInputs(
            self.references[first:last],
            self.tolerances[first:last],
            self.gaps[first * hold : last * hold + 1],
            self.noises[first * hold : last * hold],
            self.offsets[first:last],
        )


def discretize_loop(
    model: PlantModel, gains: PidGains, sampling: Sampling, notch: NotchFilter = NO_NOTCH
) -> DiscreteLoop:
    """Return the discrete models of plant and controller."""
    return DiscreteLoop(_discrete_plant(model, sampling), _control_law(gains, sampling, notch))


# The matrix exponentials take as long as ten seconds of the loop, and sweeps share them.
@lru_cache(maxsize=64)
def _discrete_plant(model: PlantModel, sampling: Sampling) -> DiscretePlant | DiscreteMachine:
    if not model.is_piecewise_linear:
        return discretize_machine(model, sampling)
    plant = discretize_plant(model, 1.0 / sampling.sampling_rate)
    return plant._replace(pitch=float(plant.pitch))


# Its decimal exponentials are the same in all runs of a sweep but those that vary the gains.
@lru_cache(maxsize=64)
def _control_law(gains: PidGains, sampling: Sampling, notch: NotchFilter) -> ControlLaw:
    return discretize_control(gains, 1.0 / sampling.control_rate, notch)


def loop_at_rest(
    gap: float,
    sensor: DiscreteSensor = IDEAL_DISCRETE,
    plant: PlantState | MachineState = AT_REST,
) -> LoopState:
    """Return the state in which new plant, controller and sensor begin.

    Parameters
    ----------
    gap : float
        First gap [rad].
    sensor : DiscreteSensor
        The sensor.
    plant : PlantState or MachineState
        The plant, in the middle of the gap.
    """
    plant = plant._replace(contact=contact_side(0.0, 0.0, gap))
    return LoopState(
        plant, INITIAL_CONTROL, SensorState(0, 0.0, delay_line(sensor.delay), recent_positions())
    )
