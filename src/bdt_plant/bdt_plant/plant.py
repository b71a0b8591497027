"""The plant: motor, lead screw with backlash and structure, one step function for all users."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.gap_profile import GapProfile, gap_at
from bdt_plant.lead_screw import LeadScrewParameters, contact_side, play
from bdt_plant.motor import (
    MotorParameters,
    MotorState,
    MotorStep,
    discretize_motor,
    motor_state_space,
    motor_step,
)
from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    StructureStep,
    discretize_structure,
    structure_state_space,
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


Column = tuple[float, float, float]


class ContactStep(NamedTuple):
    """What the motor's curved path adds to the structure while it drives the screw.

    Each row multiplies (current, speed, voltage) at the beginning of the sample.
    """

    q2: Column
    q2_velocity: Column
    q3: Column
    q3_velocity: Column


class PlantStep(NamedTuple):
    """Discrete model of the plant for one sample time."""

    motor: MotorStep
    structure: StructureStep
    contact: ContactStep
    pitch: float


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


AT_REST = PlantState(MotorState(0.0, 0.0, 0.0), 0.0, 0, StructureState(0.0, 0.0, 0.0, 0.0))
"""Everything at zero, the motor in the middle of the gap."""


def discretize_plant(model: PlantModel, sample_time: float) -> PlantStep:
    """Return the exact discrete model of the plant for `sample_time` [s]."""
    motor = discretize_motor(model.motor, sample_time)
    structure = discretize_structure(model.structure, sample_time)
    return PlantStep(
        motor,
        structure,
        _contact_step(model, sample_time, motor, structure),
        model.lead_screw.pitch,
    )


def _contact_step(
    model: PlantModel, sample_time: float, motor: MotorStep, structure: StructureStep
) -> ContactStep:
    """Return the exact response to the motor's path less the one to the straight line.

    In contact d follows theta_m, whose path within the sample is known from (current, speed,
    voltage): one matrix exponential of motor and structure together gives the exact response.
    """
    a_motor, b_motor = motor_state_space(model.motor)
    a_structure, b_structure = structure_state_space(model.structure)
    joint = np.zeros((8, 8))
    joint[:4, :4] = a_structure
    # States 4 to 6 are current, speed and angle of the motor; d = p theta_m, d' = p omega_m.
    joint[:4, 6] = model.lead_screw.pitch * b_structure[:, 0]
    joint[:4, 5] = model.lead_screw.pitch * b_structure[:, 1]
    joint[4:7, 4:7], joint[4:7, 7:] = a_motor, b_motor
    exact = expm(joint * sample_time)[:4][:, [4, 5, 7]]
    to_d_after = np.array([row[5] for row in structure])
    straight = np.outer(to_d_after, model.lead_screw.pitch * np.array(motor.angle))
    rows = (tuple(float(x) for x in row) for row in exact - straight)
    return ContactStep(*rows)  # type: ignore[arg-type]


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
    contact = contact_side(theta_d, motor.angle, gap)
    structure = structure_step(
        state.structure, step.pitch * state.theta_d, step.pitch * theta_d, step.structure
    )
    if contact != 0 and contact == state.contact:
        structure = add_motor_path(structure, state.motor, voltage, step.contact)
    return PlantState(motor, theta_d, contact, structure)


def add_motor_path(
    structure: StructureState, motor: MotorState, voltage: float, step: ContactStep
) -> StructureState:
    """Add to the structure what the motor's path differs from a straight line.

    Parameters
    ----------
    structure : StructureState
        State at the end of the sample for d linear in time.
    motor : MotorState
        Motor at the beginning of the sample.
    voltage : float
        Motor voltage u [V], held over the sample.
    step : ContactStep
        From :func:`discretize_plant`.
    """
    current, speed, _ = motor
    q2, v2, q3, v3 = structure
    a_i, a_w, a_u = step.q2
    b_i, b_w, b_u = step.q2_velocity
    c_i, c_w, c_u = step.q3
    e_i, e_w, e_u = step.q3_velocity
    return StructureState(
        q2 + (a_i * current + a_w * speed + a_u * voltage),
        v2 + (b_i * current + b_w * speed + b_u * voltage),
        q3 + (c_i * current + c_w * speed + c_u * voltage),
        v3 + (e_i * current + e_w * speed + e_u * voltage),
    )


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
        # Without a gap the motor drives the screw from the very first sample.
        self.state = AT_REST._replace(contact=contact_side(0.0, 0.0, gap_at(profile, 0.0)))
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
