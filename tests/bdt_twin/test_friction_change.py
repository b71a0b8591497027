"""Friction that changes with time and along the screw, against closed forms of a settled motor."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.motor import MotorState
from bdt_plant.plant import AT_REST, PlantModel
from bdt_twin.forward_model import simulate_stretch, slow_motion
from bdt_twin.friction_change import TURNING, FrictionChange, felt_voltage
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS
from bdt_twin.resisted_model import resisted_plant_with
from bdt_twin.window_loop import DRIVES

FRICTION = 0.15
SPEEDS = st.floats(-400.0, 400.0).filter(lambda speed: abs(speed) > TURNING)
VOLTAGES = st.floats(-24.0, 24.0)
CHANGES = st.builds(
    FrictionChange,
    voltage=st.floats(0.0, 2.0),
    growth=st.floats(-0.1, 0.1),
    slope=st.floats(-200.0, 200.0),
    time=st.floats(-60.0, 0.0),
    place=st.floats(-0.01, 0.01),
)


@given(VOLTAGES, SPEEDS, CHANGES)
def test_a_motor_that_turns_feels_more_friction_against_its_motion(voltage, speed, change):
    share = change.growth * (change.time + 2.0) + change.slope * (change.place + 1e-3)
    felt = felt_voltage(voltage, speed, 2.0, 1e-3, change)
    taken = math.copysign(1.0, speed) * (voltage - felt)
    assert taken == pytest.approx(max(share, -1.0) * change.voltage, abs=1e-12)


@given(VOLTAGES, SPEEDS, CHANGES)
def test_no_friction_drives_a_motor(voltage, speed, change):
    """All that is taken, the unchanging part with it, is at least nothing."""
    felt = felt_voltage(voltage, speed, 2.0, 1e-3, change)
    taken = math.copysign(1.0, speed) * (voltage - felt) + change.voltage
    assert taken >= -1e-12


@given(VOLTAGES, CHANGES)
def test_a_motor_that_stands_turns_from_the_voltage_on_that_friction_takes_then(voltage, change):
    share = change.growth * (change.time + 2.0) + change.slope * (change.place + 1e-3)
    least = max(1.0 + share, 0.0) * change.voltage
    felt = felt_voltage(voltage, 0.0, 2.0, 1e-3, change)
    if abs(abs(voltage) - least) > 1e-9:
        assert (abs(felt) > change.voltage) == (abs(voltage) > least)
    assert felt * voltage >= 0.0, "it never turns against the voltage"


def run_of(change, voltage, duration, rate=5000.0):
    """Return times [s] and what a motor does that turns without a gap."""
    effects = np.zeros(len(EFFECTS))
    effects[EFFECTS.index("friction_voltage")] = FRICTION
    step = resisted_plant_with(PlantModel(), np.zeros(len(FACTORS)), effects, 1.0 / rate)
    back_emf, samples = PlantModel().motor.back_emf_constant, round(duration * rate)
    # It begins as fast as it is to be.
    speed = (voltage - FRICTION * (1.0 + change.growth * change.time)) / back_emf
    state = AT_REST._replace(motor=MotorState(0.0, speed, 0.0))
    run = simulate_stretch(
        step,
        state,
        np.full(samples, voltage),
        np.zeros(samples),
        25,
        1.0 / rate,
        slow_motion(FRICTION, back_emf),
        change,
    )
    return np.arange(samples) / rate, run


def travelled(change, voltage, duration):
    """Return times [s] and the angle that such a motor has turned [rad]."""
    times, run = run_of(change, voltage, duration)
    return times, run.motor_angle


def test_a_motor_whose_friction_fades_turns_faster_and_faster():
    """The speed is (u - F (1 + g (t - T))) / k_B."""
    growth, voltage, duration = -0.02, 2.0, 8.0
    times, angle = travelled(
        FrictionChange(FRICTION, growth, 0.0, -duration, 0.0), voltage, duration
    )
    back_emf = PlantModel().motor.back_emf_constant
    lost = FRICTION * (times + growth * (0.5 * times**2 - duration * times))
    expected = (voltage * times - lost) / back_emf
    unchanged = (voltage - FRICTION) * times / back_emf
    off = np.abs(angle - expected).max()
    assert off < 2e-3 * np.abs(expected - unchanged).max()


def test_a_motor_whose_friction_grows_along_the_screw_slows_down():
    """With dx/dt = r (u - F (1 + s x)) / k_B the screw tends to where friction takes all of it."""
    slope, voltage, duration = 100.0, 1.0, 8.0
    times, angle = travelled(
        FrictionChange(FRICTION, 0.0, slope, -duration, 0.0), voltage, duration
    )
    model = PlantModel()
    rate = model.lead_screw.pitch * FRICTION * slope / model.motor.back_emf_constant
    end = (voltage - FRICTION) / (FRICTION * slope)
    expected = end * (1.0 - np.exp(-rate * times)) / model.lead_screw.pitch
    unchanged = (voltage - FRICTION) * times / model.motor.back_emf_constant
    assert np.abs(angle - expected).max() < 2e-3 * np.abs(expected - unchanged).max()


def test_friction_that_was_none_for_a_while_has_moved_nothing_then():
    """The slope for friction's voltage is zero as long as the share of it is -1."""
    growth, duration = 0.5, 4.0
    _, run = run_of(FrictionChange(FRICTION, growth, 0.0, -duration, 0.0), 2.0, duration)
    moved = run.drives[DRIVES.index("friction")]
    none = round(len(moved) * (duration - 1.0 / growth) / duration)
    assert not moved[: none - 1].any()
    assert moved[-1] == pytest.approx(0.5 / growth, rel=1e-2)
