"""A plant that runs: from one measurement to the next."""

from typing import Any

import numpy as np

from bdt_plant.actuator import (
    IDEAL_ACTUATOR,
    ActuatorParameters,
    amplified,
    amplifier_of,
    saturated,
)
from bdt_plant.gap_profile import GapProfile, gap_at, gaps_at
from bdt_plant.lead_screw import contact_side
from bdt_plant.machine import (
    MACHINE_AT_REST,
    MachineState,
    discretize_machine,
    first_platform_of_machine,
    hold_machine_period,
)
from bdt_plant.plant import (
    AT_REST,
    FloatArray,
    PlantModel,
    PlantState,
    Sampling,
    discretize_plant,
    first_platform,
    hold_period,
)
from bdt_plant.sensor import IDEAL_SENSOR, Sensor, SensorParameters

SAMPLES_AT_A_TIME = 1000
"""Samples for which a simulator reckons times and gaps at a time."""


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
    period : callable, optional
        What advances this mechanism over a control period, see
        :func:`bdt_plant.compiled_period.compiled_period_of`; None for the plain function, which
        gives the same floats in more time.

    Attributes
    ----------
    state : PlantState or MachineState
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
        period: Any = None,
    ) -> None:
        self._profile = profile
        self._sampling = sampling
        self._model = model
        self._step, at_rest, plain = _dynamics(model, sampling)
        self._period = period or plain
        self._periods: list[tuple[FloatArray, FloatArray]] = []
        self._gap = gap_at(profile, 0.0)
        # Without a gap the motor drives the screw from the very first sample.
        self.state: PlantState | MachineState = at_rest._replace(
            contact=contact_side(0.0, 0.0, self._gap)
        )
        self.sample = self.saturated_steps = 0
        self._amplifier = amplifier_of(actuator)
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

    def check_model(self, model: PlantModel) -> None:
        """Raise a ValueError if the state of this mechanism says nothing of `model`."""
        if model.is_piecewise_linear != self._model.is_piecewise_linear:
            kinds = ("no more than Coulomb friction", "more than Coulomb friction")
            has, lacks = kinds if self._model.is_piecewise_linear else kinds[::-1]
            raise ValueError(f"a mechanism that began with {has} cannot go on with {lacks}")

    def reconfigure(self, model: PlantModel, profile: GapProfile, sensor: SensorParameters) -> None:
        """Go on with another friction, gap and noise from this sample on.

        Parameters
        ----------
        model : PlantModel
            Constants of the mechanism, of the kind that it has.
        profile : GapProfile
            Growth of the gap.
        sensor : SensorParameters
            Sensor of platform 3, of which the noise alone may differ.

        Raises
        ------
        ValueError
            If the mechanism is of another kind; see :meth:`check_model`.
        """
        self.check_model(model)
        self._model, self._profile = model, profile
        self._step, _, _ = _dynamics(model, self._sampling)
        self._periods.clear()
        self._gap = gap_at(profile, self.time)
        self._sensor.set_noise(sensor.noise)

    def truth(self) -> tuple[float, float, float, float, float, float, float]:
        """Return the true (t, theta_m, theta_d, gap, q1, q2, q3) now; see ``TRUTH_COLUMNS``."""
        state = self.state
        if isinstance(state, MachineState):
            q1 = first_platform_of_machine(state, self._step)
        else:
            q1 = first_platform(state, self._step)
        return (
            self.time,
            state.motor.angle,
            state.theta_d,
            self._gap,
            q1,
            state.structure.q2,
            state.structure.q3,
        )

    def advance(self, voltage: float) -> FloatArray:
        """Advance to the next measurement with `voltage` [V] held, as far as the actuator can.

        Returns
        -------
        ndarray, shape (samples_per_control_step, 3)
            Telemetry rows (t [s], u [V], q3 [m]) of the samples passed, the first one being the
            sample at which the voltage was applied: the command within the actuator's limit, q3
            as read.
        """
        command = saturated(float(voltage), self._amplifier.limit)
        self.saturated_steps += command != voltage
        applied = amplified(command, self._amplifier)
        gaps, rows = self._next_period()
        positions = np.empty(gaps.size)
        self.state = self._period(self.state, applied, gaps, self._step, positions)
        readings = self._sensor.read_all(positions)
        rows[:, 1] = command
        rows[0, 2], rows[1:, 2] = self._reading, readings[:-1]
        self._reading = float(readings[-1])
        self.sample += gaps.size
        self._gap = float(gaps[-1])
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


def _dynamics(model: PlantModel, sampling: Sampling) -> tuple[Any, Any, Any]:
    """Return discrete model, state at rest and plain function of a mechanism."""
    if not model.is_piecewise_linear:
        return discretize_machine(model, sampling), MACHINE_AT_REST, hold_machine_period
    step = discretize_plant(model, 1.0 / sampling.sampling_rate)
    # A pitch written as 1 is an int, for which nothing is compiled.
    return step._replace(pitch=float(step.pitch)), AT_REST, hold_period
