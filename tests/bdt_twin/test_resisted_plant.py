"""The twin's motor against friction, load and cogging is the plant's own, but for its steps."""

from dataclasses import replace

import numpy as np
import pytest

from bdt_plant.cogging import CoggingParameters
from bdt_plant.machine import MACHINE_AT_REST, discretize_machine, machine_step
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import AT_REST, PlantModel, Sampling
from bdt_plant.resisted_motor import discretize_resisted_motor
from bdt_plant.screw_load import ScrewMechanics
from bdt_plant.stribeck import StribeckParameters, friction_law, friction_size
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS
from bdt_twin.resisted_model import LEAST_HOLDING, resisted_plant_with, rotated, with_cogs
from bdt_twin.resisted_plant import (
    FAST,
    STEEPEST,
    resisted_plant_step,
    slope_left,
    slow_share,
    steepness,
)

RATE, GAP, COGS = 5000.0, np.deg2rad(10.0), 24
FRICTION, EXCESS, EFFICIENCY, COGGING = 10e-3, 6e-3, 0.4, 2e-3
PER_VOLT = 0.8 / 12.0
"""Torque of a motor at rest for a volt [N m/V]."""
PITCH = 1e-3 / (2.0 * np.pi)
FRICTIONAL = PlantModel(motor=MotorParameters(coulomb_friction=FRICTION))
MACHINES = {
    "coulomb": (FRICTIONAL, {}),
    "stribeck": (
        replace(FRICTIONAL, stribeck=StribeckParameters(static_friction=FRICTION + EXCESS)),
        {"excess_voltage": EXCESS / PER_VOLT},
    ),
    "load": (
        replace(FRICTIONAL, screw_mechanics=ScrewMechanics(EFFICIENCY)),
        {"load_voltage": PITCH / EFFICIENCY / PER_VOLT},
    ),
    "cogging": (
        replace(FRICTIONAL, cogging=CoggingParameters(COGGING, COGS)),
        {"cogging_sine": COGGING / PER_VOLT},
    ),
}


def positions_of_plant(model, voltages, rate=RATE, sub_steps=20):
    step, state = discretize_machine(model, Sampling(rate, rate, sub_steps)), MACHINE_AT_REST
    found = []
    for voltage in voltages:
        state = machine_step(state, voltage, GAP, step)
        found.append(state.structure.q3)
    return np.array(found)


def positions_of_twin(voltages, effects, cogs=0, rate=RATE):
    values = np.array([effects.get(name, 0.0) for name in EFFECTS])
    step = resisted_plant_with(PlantModel(), np.zeros(len(FACTORS)), values, 1.0 / rate)
    step, state = with_cogs(step, cogs, 0.0, values), AT_REST
    found = []
    for voltage in voltages:
        state = resisted_plant_step(state, voltage, GAP, step, 0.0)
        found.append(state.structure.q3)
    return np.array(found)


@pytest.mark.parametrize("name", [name for name, (_, effects) in MACHINES.items() if effects])
def test_it_moves_as_the_plant_does(name):
    model, effects = MACHINES[name]
    # Held for 2 ms as a controller does, through zero, slow and fast, against all resistances.
    times = np.floor(np.arange(round(0.6 * RATE)) / 10.0) * 10.0 / RATE
    voltages = (1.5 * np.sin(2.0 * np.pi * 3.0 * times)).tolist()
    friction = {"friction_voltage": FRICTION / PER_VOLT}
    expected = positions_of_plant(model, voltages)
    found = positions_of_twin(voltages, friction | effects, COGS)
    without = positions_of_twin(voltages, friction | dict.fromkeys(effects, 0.0), COGS)
    moved = np.abs(without - expected).max()
    assert moved > 5e-7
    assert np.abs(found - expected).max() < 0.05 * moved


@pytest.mark.parametrize("name", MACHINES)
def test_in_long_steps_a_motor_stops_turns_and_breaks_loose_as_in_short_ones(name):
    model, effects = MACHINES[name]
    rate, hold = 1000.0, 2
    # As a loop that seeks its place: the motor stops, turns and breaks loose many times a second.
    times = np.floor(np.arange(round(2.0 * rate)) / hold) * hold / rate
    voltages = (np.sin(2.0 * np.pi * 13.0 * times) + 0.1 * np.sin(11.0 * times)).tolist()
    friction = {"friction_voltage": FRICTION / PER_VOLT}
    expected = positions_of_plant(model, voltages, rate, sub_steps=100)
    found = positions_of_twin(voltages, friction | effects, COGS, rate)
    assert np.ptp(expected) > 5e-5
    assert np.abs(found - expected).max() < 1e-7


@pytest.mark.parametrize(
    ("rate", "effects", "parts"),
    [
        (5000.0, {"friction_voltage": 0.15}, 1),
        (1000.0, {"friction_voltage": 0.15}, 5),
        (1000.0, {"friction_voltage": 0.9 * LEAST_HOLDING}, 1),
        (1000.0, {"friction_voltage": 0.15, "yield_angle": 0.01}, 1),
    ],
)
def test_a_sample_has_parts_where_rigid_friction_holds_for_long(rate, effects, parts):
    values = np.array([effects.get(name, 0.0) for name in EFFECTS])
    step = resisted_plant_with(PlantModel(), np.zeros(len(FACTORS)), values, 1.0 / rate)
    assert step.parts == parts
    expected = discretize_resisted_motor(MotorParameters(), 1.0 / rate / parts)
    assert np.array(step.in_part.motor) == pytest.approx(np.array(expected.motor), rel=1e-9)
    assert step.in_part[1:] == pytest.approx(expected[1:], rel=1e-9)


def test_stribecks_curve_is_that_of_the_plant():
    law = friction_law(
        FRICTIONAL.motor, StribeckParameters(static_friction=FRICTION + EXCESS, stribeck_speed=1.7)
    )
    for speed in np.linspace(-FAST * 2.0, FAST * 2.0, 301):
        expected = (friction_size(speed, law) - law.coulomb) / law.excess
        assert slow_share(abs(speed) / 1.7) == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize("stribeck_speed", [0.7, 2.0, 5.0])
def test_the_slope_that_falling_friction_leaves_is_that_of_its_curve(stribeck_speed):
    excess, back_emf, change = 0.05, 0.1, 1e-4
    steep = steepness(excess, stribeck_speed, back_emf)
    for speed in np.linspace(0.1, 3.0 * stribeck_speed, 20).tolist():
        faster, slower = (
            excess * np.exp(-(((speed + sign * change) / stribeck_speed) ** 2)) for sign in (1, -1)
        )
        left = 1.0 + (faster - slower) / (2.0 * change * back_emf)
        ratio = speed / stribeck_speed
        assert slope_left(ratio, slow_share(ratio), steep) == pytest.approx(left, abs=1e-4)
    # A motor that sticks and slips has no slope.
    assert slope_left(0.7, slow_share(0.7), 100.0 * steep) == pytest.approx(1.0 - STEEPEST)


def test_a_wave_that_begins_later_is_the_same_wave():
    sine, cosine, begin = 0.3, -0.8, 0.37
    turns = np.linspace(-1.0, 2.0, 50)

    def wave(parts, at):
        return parts[0] * np.sin(2.0 * np.pi * at) + parts[1] * np.cos(2.0 * np.pi * at)

    assert wave(rotated(sine, cosine, begin), turns) == pytest.approx(
        wave((sine, cosine), turns + begin)
    )
