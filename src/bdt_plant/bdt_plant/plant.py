"""The plant: motor, lead screw with backlash and structure, one step function for all users."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.amplifier_lag import AmplifierLag
from bdt_plant.cogging import CoggingParameters
from bdt_plant.friction import DiscreteFriction, discretize_friction, frictional_motor_step
from bdt_plant.lead_screw import LeadScrewParameters, contact_side, play
from bdt_plant.matrix_exponential import Exponential, matrix_exponential
from bdt_plant.motor import (
    DiscreteMotor,
    MotorParameters,
    MotorState,
    discretize_motor,
    motor_step,
)
from bdt_plant.motor_path import DiscreteContact, add_motor_path, discretize_contact
from bdt_plant.pushes import PushParameters
from bdt_plant.screw_load import ScrewMechanics
from bdt_plant.stiffening_tower import BeamParameters
from bdt_plant.stribeck import StribeckParameters
from bdt_plant.structure import (
    DiscreteStructure,
    StructureParameters,
    StructureState,
    discretize_structure,
    structure_step,
)

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Sampling:
    """Rates of the simulated plant."""

    sampling_rate: float = quantity(
        5000.0, "Hz", "rate of integration and of telemetry", minimum=1.0, maximum=1e6
    )
    control_rate: float = quantity(
        500.0, "Hz", "rate of measurements; divides the sampling rate", minimum=0.1, maximum=1e6
    )
    sub_steps: int = quantity(
        10,
        "",
        "steps of integration in a sample of a mechanism that is not linear; the paper's needs one",
        minimum=1,
        maximum=10_000,
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
    """Everything that is constant about the mechanism.

    The first three parts are the paper's mechanism and Coulomb friction. The others are what it
    leaves out; estimators and design know nothing of them.
    """

    motor: MotorParameters = field(default_factory=MotorParameters)
    lead_screw: LeadScrewParameters = field(default_factory=LeadScrewParameters)
    structure: StructureParameters = field(default_factory=StructureParameters)
    stribeck: StribeckParameters = field(default_factory=StribeckParameters)
    cogging: CoggingParameters = field(default_factory=CoggingParameters)
    screw_mechanics: ScrewMechanics = field(default_factory=ScrewMechanics)
    beams: BeamParameters = field(default_factory=BeamParameters)
    pushes: PushParameters = field(default_factory=PushParameters)
    amplifier: AmplifierLag = field(default_factory=AmplifierLag)

    @property
    def is_piecewise_linear(self) -> bool:
        """Whether the paper's mechanism, with Coulomb friction at most, is all that there is."""
        coulomb = self.motor.coulomb_friction
        uneven = self.stribeck.friction_asymmetry and max(coulomb, self.stribeck.static_friction)
        return not (
            uneven
            or self.stribeck.static_friction > coulomb
            or self.cogging.cogging_torque
            or self.screw_mechanics.efficiency
            or self.screw_mechanics.stiffness
            or self.screw_mechanics.thread_error
            or self.beams.cubic_stiffness
            or self.pushes.force
            or self.amplifier.lag
        )


class DiscretePlant(NamedTuple):
    """Discrete model of the plant for one sample time."""

    motor: DiscreteMotor
    structure: DiscreteStructure
    contact: DiscreteContact
    pitch: float
    friction: DiscreteFriction


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


HoldPeriod = Callable[[PlantState, float, FloatArray, DiscretePlant, FloatArray], PlantState]
"""Type of :func:`hold_period`."""

AT_REST = PlantState(MotorState(0.0, 0.0, 0.0), 0.0, 0, StructureState(0.0, 0.0, 0.0, 0.0))
"""Everything at zero, the motor in the middle of the gap."""


def discretize_plant(
    model: PlantModel, sample_time: float, exponential: Exponential = matrix_exponential
) -> DiscretePlant:
    """Return the exact discrete model of the plant.

    Parameters
    ----------
    model : PlantModel
        Constants of the plant.
    sample_time : float
        Sample time [s].
    exponential : callable
        Returns the exponential of a matrix.
    """
    motor, structure, pitch = model.motor, model.structure, model.lead_screw.pitch
    return DiscretePlant(
        discretize_motor(motor, sample_time, exponential),
        discretize_structure(structure, sample_time, exponential),
        discretize_contact(motor, structure, pitch, sample_time, exponential),
        pitch,
        discretize_friction(motor, sample_time),
    )


def plant_step(state: PlantState, voltage: float, gap: float, step: DiscretePlant) -> PlantState:
    """Advance the plant by one sample (eqs 1, 2, 3 and 6).

    Parameters
    ----------
    state : PlantState
        State at the beginning of the sample.
    voltage : float
        Motor voltage u [V], held over the sample.
    gap : float
        Backlash gap theta_b [rad] at the end of the sample.
    step : DiscretePlant
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


def first_platform(state: PlantState, step: DiscretePlant) -> float:
    """Return the position of platform 1, which follows the lead screw: q1 = d (eq. 1) [m]."""
    return step.pitch * state.theta_d


def hold_period(
    state: PlantState, voltage: float, gaps: FloatArray, step: DiscretePlant, positions: FloatArray
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
    step : DiscretePlant
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
