"""How late a motor answers, and what is made of a reading that would be early."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel
from bdt_study.calibration.motor_lag import (
    SMALLEST_LAG,
    motor_lag,
    with_lag,
    without_early_reading,
)
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.unknowns import Unknowns

MODEL = PlantModel(motor=MotorParameters(inertia=2e-5))
DELAY = EFFECTS.index("delay")


def unknowns(delay):
    effects = np.arange(len(EFFECTS)) * 1e-3
    effects[DELAY] = delay
    return Unknowns(np.ones(3), np.zeros(3), np.zeros((1, 6)), effects)


def test_it_is_the_time_by_which_the_angle_is_behind_that_of_a_motor_without_inertia():
    motor, voltage, end = MODEL.motor, 3.0, 1.0

    def slopes(_time, state):
        current, speed, _ = state
        driven = voltage - motor.resistance * current - motor.back_emf_constant * speed
        return driven / motor.inductance, motor.torque_constant * current / motor.inertia, speed

    found = solve_ivp(slopes, (0.0, end), [0.0, 0.0, 0.0], method="Radau", rtol=1e-9, atol=1e-12)
    behind = end - found.y[2, -1] * motor.back_emf_constant / voltage
    assert motor_lag(MODEL) == pytest.approx(behind, rel=1e-6)


@given(st.floats(1e-5, 1.0))
def test_a_mechanism_is_given_any_lag_by_its_inertia_alone(lag):
    changed = with_lag(MODEL, lag)
    assert motor_lag(changed) == pytest.approx(lag)
    motor = replace(changed.motor, inertia=MODEL.motor.inertia)
    assert replace(changed, motor=motor) == MODEL


@given(st.floats(-0.1, 0.0, exclude_max=True))
def test_an_early_reading_becomes_a_quicker_motor(delay):
    given = unknowns(delay)
    model, changed = without_early_reading(MODEL, given)
    total = motor_lag(MODEL) + delay
    assert motor_lag(model) == pytest.approx(max(total, SMALLEST_LAG))
    assert motor_lag(model) + changed.effects[DELAY] == pytest.approx(total)
    assert (np.delete(changed.effects, DELAY) == np.delete(given.effects, DELAY)).all()


@pytest.mark.parametrize("delay", [0.0, 1e-3])
def test_a_late_reading_is_left_as_it_is(delay):
    given = unknowns(delay)
    assert without_early_reading(MODEL, given) == (MODEL, given)
