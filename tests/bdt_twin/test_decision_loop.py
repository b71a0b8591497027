"""The loop in which the twin simulates decisions, beside plant and controller as they run."""

import math

import numpy as np
import pytest

from bdt_controller.control_law import discretize_control
from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.pid import PidGains
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling, discretize_plant
from bdt_plant.plant_simulator import PlantSimulator
from bdt_twin.decision_loop import HOLD, Member, noise_draws, simulate_steps

RATE = 500.0
MODEL = PlantModel()
LAW = discretize_control(PidGains(), 1.0 / RATE)
PLANT = discretize_plant(MODEL, 1.0 / (HOLD * RATE))
REFERENCES = np.repeat([5e-3, 0.0], 1000)


def test_it_is_the_loop_of_plant_and_controller_bit_for_bit():
    gap, tolerance = math.radians(20.0), 4e-5
    positions, voltages = simulate_steps(
        Member(PLANT, gap, 0.0, 0, 0.0), LAW, tolerance, 24.0, REFERENCES
    )
    plant = PlantSimulator(MODEL, GapProfile("constant", gap), Sampling(HOLD * RATE, RATE))
    settings = ControllerSettings(RATE, tolerance, 24.0)
    controller = DeadZoneController(PidGains(), settings)
    for reference, position, voltage in zip(REFERENCES, positions, voltages, strict=True):
        assert plant.position == position
        assert controller.step(float(reference), plant.position) == voltage
        plant.advance(float(voltage))


@pytest.mark.parametrize("lag", [1, 3])
def test_a_late_reading_is_late_by_whole_samples(lag):
    gap = math.radians(5.0)
    late, _ = simulate_steps(Member(PLANT, gap, 0.0, lag, 0.0), LAW, 1e-5, 0.0, REFERENCES)
    plant = PlantSimulator(MODEL, GapProfile("constant", gap), Sampling(HOLD * RATE, RATE))
    controller = DeadZoneController(PidGains(), ControllerSettings(RATE, 1e-5))
    read = [0.0] * lag
    for reference, position in zip(REFERENCES[:400], late[:400], strict=True):
        assert plant.position == position
        read.append(plant.position)
        voltage = controller.step(float(reference), read[-1 - lag])
        rows = plant.advance(voltage)
        read.extend(float(row[2]) for row in rows[1:])


def test_readings_have_the_noise_of_the_sensor():
    gap, noise = math.radians(5.0), 5e-6
    member = Member(PLANT, gap, 0.0, 0, 0.0, noise)
    positions, voltages = simulate_steps(member, LAW, 1e-5, 0.0, REFERENCES)
    plant = PlantSimulator(MODEL, GapProfile("constant", gap), Sampling(HOLD * RATE, RATE))
    controller = DeadZoneController(PidGains(), ControllerSettings(RATE, 1e-5))
    draws = noise_draws(REFERENCES.size)
    assert (draws.mean(), draws.std()) == pytest.approx((0.0, 1.0), abs=0.05)
    for reference, draw, position, voltage in zip(
        REFERENCES, draws, positions, voltages, strict=True
    ):
        assert plant.position == pytest.approx(position, abs=1e-9)
        asked = controller.step(float(reference), plant.position + noise * float(draw))
        assert asked == pytest.approx(voltage, abs=1e-3)
        plant.advance(float(voltage))


def test_an_offset_that_nobody_takes_back_makes_the_motor_creep():
    member = Member(PLANT, math.radians(20.0), 0.05, 0, 0.0)
    at_rest = np.zeros(1000)
    _, voltages = simulate_steps(member, LAW, 4e-5, 0.0, at_rest)
    assert voltages.any()
    _, quiet = simulate_steps(member._replace(disturbance=0.0), LAW, 4e-5, 0.0, at_rest)
    assert not quiet.any()
