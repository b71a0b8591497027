"""The plant: motor, lead screw with backlash and structure, one step function for all users."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.gap_profile import GapProfile, gap_at
from bdt_plant.lead_screw import LeadScrewParameters, play
from bdt_plant.motor import MotorParameters, MotorState, MotorStep, discretize_motor, motor_step
from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    StructureStep,
    discretize_structure,
    structure_step,
)


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
    pitch: float


class PlantState(NamedTuple):
    """State of the plant: motor, angle of the lead screw theta_d [rad], structure."""

    motor: MotorState
    theta_d: float
    structure: StructureState


AT_REST = PlantState(MotorState(0.0, 0.0, 0.0), 0.0, StructureState(0.0, 0.0, 0.0, 0.0))
"""Everything at zero, the motor in the middle of the gap."""


def discretize_plant(model: PlantModel, sample_time: float) -> PlantStep:
    """Return the exact discrete model of the plant for `sample_time` [s]."""
    return PlantStep(
        discretize_motor(model.motor, sample_time),
        discretize_structure(model.structure, sample_time),
        model.lead_screw.pitch,
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
    motor = motor_step(state.motor, voltage, step.motor)
    theta_d = play(state.theta_d, motor.angle, gap)
    structure = structure_step(
        state.structure, step.pitch * state.theta_d, step.pitch * theta_d, step.structure
    )
    return PlantState(motor, theta_d, structure)


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
    """

    def __init__(self, model: PlantModel, profile: GapProfile, sampling: Sampling) -> None:
        self._profile = profile
        self._sampling = sampling
        self._step = discretize_plant(model, 1.0 / sampling.sampling_rate)
        self.state = AT_REST
        self.sample = 0

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
        """Position q3 of platform 3 [m]."""
        return self.state.structure.q3

    def truth(self) -> tuple[float, float, float, float, float, float, float]:
        """Return (t, theta_m, theta_d, gap, q1, q2, q3) now; see ``TRUTH_COLUMNS``."""
        motor, theta_d, structure = self.state
        return (
            self.time,
            motor.angle,
            theta_d,
            gap_at(self._profile, self.time),
            self._step.pitch * theta_d,
            structure.q2,
            structure.q3,
        )

    def advance(self, voltage: float) -> NDArray[np.float64]:
        """Advance to the next measurement with `voltage` [V] held.

        Returns
        -------
        ndarray, shape (samples_per_control_step, 3)
            Telemetry rows (t [s], u [V], q3 [m]) of the samples passed, the first one being the
            sample at which the voltage was applied.
        """
        rate, state, step, profile = (
            self._sampling.sampling_rate,
            self.state,
            self._step,
            self._profile,
        )
        rows = []
        for sample in range(self.sample, self.sample + self._sampling.samples_per_control_step):
            rows.append((sample / rate, voltage, state.structure.q3))
            state = plant_step(state, voltage, gap_at(profile, (sample + 1) / rate), step)
        self.state = state
        self.sample += len(rows)
        return np.array(rows)
