"""The plant: motor, lead screw with backlash and structure, one step function for all users."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.actuator import IDEAL_ACTUATOR, ActuatorParameters, saturated
from bdt_plant.friction import FrictionStep, discretize_friction, frictional_motor_step
from bdt_plant.gap_profile import GapProfile, gap_at, gaps_at
from bdt_plant.lead_screw import LeadScrewParameters, contact_side, play
from bdt_plant.motor import (
    MotorParameters,
    MotorState,
    MotorStep,
    discretize_motor,
    motor_step,
)
from bdt_plant.motor_path import ContactStep, add_motor_path, discretize_contact
from bdt_plant.sensor import IDEAL_SENSOR, Sensor, SensorParameters
from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    StructureStep,
    discretize_structure,
    structure_step,
)

FloatArray = NDArray[np.float64]

SAMPLES_AT_A_TIME = 1000
"""Samples for which a simulator reckons times and gaps at a time."""


@dataclass(frozen=True)
class Sampling:
    """Rates of the simulated plant."""

    sampling_rate: float = quantity(
        5000.0, "Hz", "rate of integration and of telemetry", minimum=1.0, maximum=1e6
    )
    control_rate: float = quantity(
        500.0, "Hz", "rate of measurements; divides the sampling rate", minimum=0.1, maximum=1e6
    )

    def __post_init__(self) -> None:
        validate(self)
        ratio = self.sampling_rate / self.control_rate
        if ratio < 1 or ratio != round(ratio):
            raise ValueError(
                f"Sampling.control_rate = {self.control_rate!r} Hz: "
                f"must divide sampling_rate ({self.sampling_rate:g} Hz)"
            )

    @property
    def samples_per_control_step(self) -> int:
        """Number of plant samples between two measurements."""
        return round(self.sampling_rate / self.control_rate)


@dataclass(frozen=True)
class PlantModel:
    """Everything that is constant about the mechanism."""

    motor: MotorParameters = field(default_factory=MotorParameters)
    lead_screw: LeadScrewParameters = field(default_factory=LeadScrewParameters)
    structure: StructureParameters = field(default_factory=StructureParameters)


class PlantStep(NamedTuple):
    """Discrete model of the plant for one sample time."""

    motor: MotorStep
    structure: StructureStep
    contact: ContactStep
    pitch: float
    friction: FrictionStep


class PlantState(NamedTuple):
    """State of the plant.

    Attributes
    ----------
    motor : MotorState
        Motor.
    theta_d : float
        Angle of the lead screw [rad].
    contact : int
        1 or -1 while the motor drives the screw forward or backward, 0 inside the gap.
    structure : StructureState
        Platforms 2 and 3.
    """

    motor: MotorState
    theta_d: float
    contact: int
    structure: StructureState


HoldPeriod = Callable[[PlantState, float, FloatArray, PlantStep, FloatArray], PlantState]
"""Type of :func:`hold_period`."""

AT_REST = PlantState(MotorState(0.0, 0.0, 0.0), 0.0, 0, StructureState(0.0, 0.0, 0.0, 0.0))
"""Everything at zero, the motor in the middle of the gap."""


def discretize_plant(model: PlantModel, sample_time: float) -> PlantStep:
    """Return the exact discrete model of the plant for `sample_time` [s]."""
    motor, structure, pitch = model.motor, model.structure, model.lead_screw.pitch
    return PlantStep(
        discretize_motor(motor, sample_time),
        discretize_structure(structure, sample_time),
        discretize_contact(motor, structure, pitch, sample_time),
        pitch,
        discretize_friction(motor, sample_time),
    )


def plant_step(state: PlantState, voltage: float, gap: float, step: PlantStep) -> PlantState:
    """Advance the plant by one sample (eqs 1, 2, 3 and 6).

    Parameters
    ----------
    state : PlantState
        State at the beginning of the sample.
    voltage : float
        Motor voltage u [V], held over the sample.
    gap : float
        Backlash gap theta_b [rad] at the end of the sample.
    step : PlantStep
        From :func:`discretize_plant`.
    """
    # The driver moves the motor's way without friction: the model of the contact knows none.
    driver, driver_voltage = state.motor, voltage
    if step.friction.current > 0.0:
        motor, driver, driver_voltage = frictional_motor_step(
            state.motor, voltage, step.motor, step.friction
        )
    else:
        motor = motor_step(state.motor, voltage, step.motor)
    theta_d = play(state.theta_d, motor.angle, gap)
    contact = contact_side(theta_d, motor.angle, gap)
    structure = structure_step(
        state.structure, step.pitch * state.theta_d, step.pitch * theta_d, step.structure
    )
    if contact != 0 and contact == state.contact:
        structure = add_motor_path(structure, driver, driver_voltage, step.contact)
    return PlantState(motor, theta_d, contact, structure)


def hold_period(
    state: PlantState, voltage: float, gaps: FloatArray, step: PlantStep, positions: FloatArray
) -> PlantState:
    """Advance the plant by some samples with one voltage held (eqs 1, 2, 3 and 6).

    Parameters
    ----------
    state : PlantState
        State at the first sample.
    voltage : float
        Motor voltage u [V].
    gaps : ndarray, shape (n,)
        Backlash gap theta_b at the end of each sample [rad].
    step : PlantStep
        From :func:`discretize_plant`.
    positions : ndarray, shape (n,)
        Written: position q3 of platform 3 at the end of each sample [m].

    Returns
    -------
    PlantState
        State at the end of the last sample.
    """
    for n in range(gaps.size):
        # A numpy number would make all that follows several times slower in plain Python.
        state = plant_step(state, voltage, float(gaps[n]), step)
        positions[n] = state.structure.q3
    return state


class PlantSimulator:
    """A plant that runs: discrete model, state and sample counter.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    profile : GapProfile
        Growth of the gap.
    sampling : Sampling
        Rates.
    sensor : SensorParameters
        Sensor of platform 3.
    actuator : ActuatorParameters
        Amplifier of the motor.
    period : callable
        :func:`hold_period`, or what gives the same floats in less time.

    Attributes
    ----------
    state : PlantState
        True state.
    sample : int
        Number of samples advanced.
    saturated_steps : int
        Number of control periods in which the voltage was limited.
    """

    def __init__(
        self,
        model: PlantModel,
        profile: GapProfile,
        sampling: Sampling,
        sensor: SensorParameters = IDEAL_SENSOR,
        actuator: ActuatorParameters = IDEAL_ACTUATOR,
        period: HoldPeriod = hold_period,
    ) -> None:
        self._profile = profile
        self._sampling = sampling
        step = discretize_plant(model, 1.0 / sampling.sampling_rate)
        # A pitch written as 1 is an int, for which nothing is compiled.
        self._step = step._replace(pitch=float(step.pitch))
        self._period = period
        self._periods: list[tuple[FloatArray, FloatArray]] = []
        # Without a gap the motor drives the screw from the very first sample.
        self.state = AT_REST._replace(contact=contact_side(0.0, 0.0, gap_at(profile, 0.0)))
        self.sample = self.saturated_steps = 0
        self._voltage_limit = actuator.limit
        self._sensor = Sensor(sensor, sampling.sampling_rate)
        self._reading = self._sensor.read(self.state.structure.q3)

    @property
    def time(self) -> float:
        """Simulated time [s]; computed from the sample counter, so it does not drift."""
        return self.sample / self._sampling.sampling_rate

    @property
    def nanoseconds(self) -> int:
        """Simulated time rounded to nanoseconds."""
        return round(self.sample * 1e9 / self._sampling.sampling_rate)

    @property
    def position(self) -> float:
        """Position q3 of platform 3 as the sensor reads it at this sample [m]."""
        return self._reading

    @property
    def dropped_samples(self) -> int:
        """Number of samples that the sensor dropped."""
        return self._sensor.dropped

    def truth(self) -> tuple[float, float, float, float, float, float, float]:
        """Return the true (t, theta_m, theta_d, gap, q1, q2, q3) now; see ``TRUTH_COLUMNS``."""
        motor, theta_d, _, structure = self.state
        return (
            self.time,
            motor.angle,
            theta_d,
            gap_at(self._profile, self.time),
            self._step.pitch * theta_d,
            structure.q2,
            structure.q3,
        )

    def advance(self, voltage: float) -> FloatArray:
        """Advance to the next measurement with `voltage` [V] held, as far as the actuator can.

        Returns
        -------
        ndarray, shape (samples_per_control_step, 3)
            Telemetry rows (t [s], u [V], q3 [m]) of the samples passed, the first one being the
            sample at which the voltage was applied: the voltage as applied, q3 as read.
        """
        applied = saturated(float(voltage), self._voltage_limit)
        self.saturated_steps += applied != voltage
        gaps, rows = self._next_period()
        positions = np.empty(gaps.size)
        self.state = self._period(self.state, applied, gaps, self._step, positions)
        readings = self._sensor.read_all(positions)
        rows[:, 1] = applied
        rows[0, 2], rows[1:, 2] = self._reading, readings[:-1]
        self._reading = float(readings[-1])
        self.sample += gaps.size
        return rows

    def _next_period(self) -> tuple[FloatArray, FloatArray]:
        """Return the gaps [rad] until the next measurement, and rows with the times [s]."""
        if not self._periods:
            # Some periods at a time: with ten numbers a call of numpy is mostly overhead.
            count = self._sampling.samples_per_control_step
            periods = max(SAMPLES_AT_A_TIME // count, 1)
            samples = np.arange(self.sample, self.sample + periods * count + 1)
            times = samples / self._sampling.sampling_rate
            gaps = gaps_at(self._profile, times[1:]).reshape(periods, count)
            rows = np.empty((periods, count, 3))
            rows[:, :, 0] = times[:-1].reshape(periods, count)
            self._periods = list(zip(gaps, rows, strict=True))[::-1]
        return self._periods.pop()
