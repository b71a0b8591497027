"""What the curved way of the motor within a sample does to the structure."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.motor import MotorParameters, MotorState, discretize_motor, motor_step
from bdt_plant.motor_path import add_motor_path, discretize_contact
from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    discretize_structure,
    structure_step,
)

MOTOR, STRUCTURE = MotorParameters(), StructureParameters()
PITCH = LeadScrewParameters().pitch
SAMPLE_TIME = 2e-4
AT_REST = StructureState(0.0, 0.0, 0.0, 0.0)
CONTACT = discretize_contact(MOTOR, STRUCTURE, PITCH, SAMPLE_TIME)


def in_short_steps(motor, voltage, count):
    """Return motor and structure after one sample, on a way of so many straight pieces."""
    motor_rows = discretize_motor(MOTOR, SAMPLE_TIME / count)
    structure_rows = discretize_structure(STRUCTURE, SAMPLE_TIME / count)
    structure = AT_REST
    for _ in range(count):
        before, motor = motor, motor_step(motor, voltage, motor_rows)
        structure = structure_step(
            structure, PITCH * before.angle, PITCH * motor.angle, structure_rows
        )
    return motor, structure


@pytest.mark.parametrize(
    ("current", "speed", "voltage"), [(0.0, 0.0, 24.0), (1.0, -50.0, 5.0), (-0.5, 100.0, -12.0)]
)
def test_straight_line_and_addition_together_are_the_motor_s_way(current, speed, voltage):
    motor = MotorState(current, speed, 0.0)
    end, expected = in_short_steps(motor, voltage, 400)
    straight = structure_step(
        AT_REST, 0.0, PITCH * end.angle, discretize_structure(STRUCTURE, SAMPLE_TIME)
    )
    curved = add_motor_path(straight, motor, voltage, CONTACT)
    # The pieces are right to 1 / 400^2 of what the curvature adds.
    added = np.abs(np.subtract(expected, straight))
    assert (np.abs(np.subtract(curved, expected)) <= 1e-4 * added).all()
    assert added[1] > 1e-9


@given(st.floats(-200.0, 200.0))
def test_a_motor_of_constant_speed_goes_straight(speed):
    motor = MotorState(0.0, speed, 0.0)
    curved = add_motor_path(AT_REST, motor, MOTOR.back_emf_constant * speed, CONTACT)
    np.testing.assert_allclose(curved, 0.0, rtol=0, atol=1e-15)
