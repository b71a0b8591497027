"""The motor's path within a sample, and what its curvature does to the structure in contact."""

from typing import NamedTuple

import numpy as np

from bdt_plant.matrix_exponential import Exponential, matrix_exponential
from bdt_plant.motor import MotorParameters, MotorState, motor_state_space
from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    discretize_structure,
    structure_state_space,
)

Column = tuple[float, float, float]


class DiscreteContact(NamedTuple):
    """What the motor's curved path adds to the structure while it drives the screw.

    Each row multiplies (current, speed, voltage) at the beginning of the sample.
    """

    q2: Column
    q2_velocity: Column
    q3: Column
    q3_velocity: Column


def discretize_contact(
    motor: MotorParameters,
    structure: StructureParameters,
    pitch: float,
    sample_time: float,
    exponential: Exponential = matrix_exponential,
) -> DiscreteContact:
    """Return the exact response to the motor's path less the one to the straight line.

    In contact d follows theta_m, whose path within the sample is known from (current, speed,
    voltage): one matrix exponential of motor and structure together gives the exact response.

    Parameters
    ----------
    motor : MotorParameters
        Constants of the motor.
    structure : StructureParameters
        Constants of the structure.
    pitch : float
        Pitch p of the lead screw [m/rad].
    sample_time : float
        Sample time [s].
    exponential : callable
        Returns the exponential of a matrix.
    """
    a_motor, b_motor = motor_state_space(motor)
    a_structure, b_structure = structure_state_space(structure)
    joint = np.zeros((8, 8))
    joint[:4, :4] = a_structure
    # States 4 to 6 are current, speed and angle of the motor; d = p theta_m, d' = p omega_m.
    joint[:4, 6] = pitch * b_structure[:, 0]
    joint[:4, 5] = pitch * b_structure[:, 1]
    joint[4:7, 4:7], joint[4:7, 7:] = a_motor, b_motor
    response = exponential(joint * sample_time)[:, [4, 5, 7]]
    exact, angle = response[:4], response[6]
    straight_line = discretize_structure(structure, sample_time, exponential)
    to_d_after = np.array([row[5] for row in straight_line])
    straight = np.outer(to_d_after, pitch * angle)
    rows = (tuple(float(x) for x in row) for row in exact - straight)
    return DiscreteContact(*rows)  # type: ignore[arg-type]


def add_motor_path(
    structure: StructureState, motor: MotorState, voltage: float, step: DiscreteContact
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
    step : DiscreteContact
        From :func:`discretize_contact`.
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
