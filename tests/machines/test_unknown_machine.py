"""The independent machine moves as the plant does, with each effect and with all of them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from machine_with_twin import HOLD, SAMPLING_RATE
from running_machine import RunningMachine
from scipy.signal import lsim
from unknown_machine import PITCH, UnknownMachine

from bdt_plant.actuator import ActuatorParameters
from bdt_plant.amplifier_lag import AmplifierLag
from bdt_plant.cogging import CoggingParameters
from bdt_plant.gap_profile import GapProfile
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel
from bdt_plant.screw_load import ScrewMechanics
from bdt_plant.sensor import SensorParameters
from bdt_plant.stiffening_tower import BeamParameters
from bdt_plant.stribeck import StribeckParameters
from bdt_plant.structure import StructureParameters
from bdt_study.simulation.closed_loop import Scenario, simulate

DURATION = 12.0
GAP = math.radians(12.0)
LEAD = 4e-5
"""Time by which the independent machine is ahead [s]."""
MORE_LEAD = {"screw_stiffness": 2e-5, "amplifier_lag": 1e-5}
"""What it is more with an elastic screw and with a voltage that is integrated, too [s]."""
LIKENESS = 2e-7
"""Distance of both [m], in motions of 16 mm."""
QUIET = UnknownMachine(noise=0.0, quantum=0.0)
MOTOR = MotorParameters()
FRICTION = 0.01
"""Coulomb friction where something else depends on it [N m]."""


def frictional(**constants):
    """Return a motor with friction, and more."""
    return replace(MOTOR, coulomb_friction=FRICTION, **constants)


EFFECTS = {
    "nothing": ({}, {}, {}),
    "Coulomb friction": ({"coulomb_friction": FRICTION}, {"motor": frictional()}, {}),
    "viscous friction": (
        {"viscous_friction": 2e-5},
        {"motor": replace(MOTOR, viscous_friction=2e-5)},
        {},
    ),
    "friction at rest, larger forward": (
        {"coulomb_friction": FRICTION, "friction_at_rest": 0.016, "friction_asymmetry": 0.2},
        {"motor": frictional(), "stribeck": StribeckParameters(0.016, 2.0, 0.2)},
        {},
    ),
    "cogging beside friction": (
        {"coulomb_friction": FRICTION, "cogging": 3e-3},
        {"motor": frictional(), "cogging": CoggingParameters(3e-3, 24)},
        {},
    ),
    "load": (
        {"coulomb_friction": FRICTION, "efficiency": 0.4},
        {"motor": frictional(), "screw_mechanics": ScrewMechanics(0.4)},
        {},
    ),
    "a payload": (
        {"upper_mass": 1.3},
        {"structure": StructureParameters(top_mass_ratio=1.3)},
        {},
    ),
    "an elastic screw": (
        {"coulomb_friction": FRICTION, "screw_stiffness": 5e5},
        {"motor": frictional(), "screw_mechanics": ScrewMechanics(0.0, 5e5)},
        {},
    ),
    "a thread that is off": (
        {"coulomb_friction": FRICTION, "thread_error": 3e-6},
        {"motor": frictional(), "screw_mechanics": ScrewMechanics(thread_error=3e-6)},
        {},
    ),
    "stiffening beams": ({"cubic_stiffness": 2e6}, {"beams": BeamParameters(2e6)}, {}),
    "amplifier that lags": (
        {"coulomb_friction": FRICTION, "amplifier_lag": 2e-3},
        {"motor": frictional(), "amplifier": AmplifierLag(2e-3)},
        {},
    ),
    "amplifier": (
        {"amplifier_gain": 1.02, "amplifier_offset": 0.05},
        {},
        {"actuator": ActuatorParameters(gain=1.02, offset=0.05)},
    ),
    "sensor": (
        {"delay": 1e-3, "bias": 5e-5, "drift_rate": 2e-7},
        {},
        {"sensor": SensorParameters(delay=1e-3, bias=5e-5, drift=2e-7)},
    ),
}
"""What each effect is for the independent machine, for the mechanism and for what is around it."""


def readings(machine, voltages, gap=GAP):
    """Return what the independent machine reads when it is given some voltages [m]."""
    running = RunningMachine(machine, np.full(len(voltages), gap), SAMPLING_RATE, seed=0)
    for voltage in voltages[::HOLD]:
        running.hold(float(voltage), HOLD)
    return running.telemetry()[:, 2]


@pytest.mark.parametrize("name", EFFECTS)
def test_the_same_voltages_move_both_alike(name):
    constants, parts, around = EFFECTS[name]
    gap = GapProfile(kind="constant", initial=GAP)
    scenario = Scenario(DURATION, gap=gap, dead_zone=1.2 * PITCH * GAP, model=PlantModel(**parts))
    loop = simulate(replace(scenario, **around), ("u", "measured"))
    found, without = (readings(each, loop.u) for each in (replace(QUIET, **constants), QUIET))
    lead = LEAD + sum(MORE_LEAD.get(name, 0.0) for name in constants)
    late = np.interp(loop.t - lead, loop.t, found)
    assert np.abs(late - loop.measured).max() < LIKENESS
    if constants:
        assert np.abs(without - loop.measured).max() > 5.0 * LIKENESS


def last_reading(machine, voltage, duration):
    """Return where a machine is that was given a voltage for a time [s]."""
    return readings(machine, np.full(round(duration * SAMPLING_RATE), voltage))[-1]


def speed_of_screw(machine, voltage):
    """Return how fast a voltage drives the screw in contact [m/s], in closed form."""
    held_back = machine.resistance * machine.coulomb_friction / machine.torque_constant
    return PITCH * (voltage - held_back) / machine.back_emf_constant


def test_friction_that_fades_lets_the_motor_turn_faster():
    lasting = replace(QUIET, coulomb_friction=FRICTION)
    fading = replace(lasting, friction_fade=0.05)
    gained = speed_of_screw(QUIET, 1.0) - speed_of_screw(lasting, 1.0)
    ahead = last_reading(fading, 1.0, 8.0) - last_reading(lasting, 1.0, 8.0)
    assert ahead == pytest.approx(gained * 0.05 * 8.0**2 / 2.0, rel=0.01)


def test_an_amplifier_that_lags_filters_what_a_machine_without_a_gap_does():
    lag, voltages = 2e-3, np.repeat([5.0, -3.0, 0.0], round(0.5 * SAMPLING_RATE))
    prompt, lagging = (
        readings(machine, voltages, gap=0.0)
        for machine in (QUIET, replace(QUIET, amplifier_lag=lag))
    )
    times = np.arange(voltages.size) / SAMPLING_RATE
    _, filtered, _ = lsim(([1.0], [lag, 1.0]), prompt, times)
    assert lagging == pytest.approx(filtered, abs=LIKENESS)
    assert np.abs(lagging - prompt).max() > 100.0 * LIKENESS


def test_resistance_that_rises_lets_the_motor_turn_more_slowly():
    cold = replace(QUIET, coulomb_friction=FRICTION)
    lost = speed_of_screw(QUIET, 1.0) - speed_of_screw(cold, 1.0)
    behind = last_reading(cold, 1.0, 8.0) - last_reading(replace(cold, warming=0.01), 1.0, 8.0)
    assert behind == pytest.approx(lost * 0.01 * 8.0**2 / 2.0, rel=0.01)


def test_friction_that_differs_within_a_turn_repeats_with_each():
    share, voltage = 0.5, 0.25
    machine = replace(QUIET, coulomb_friction=FRICTION, friction_in_turn=share)
    mean = speed_of_screw(machine, voltage) / PITCH
    swing = share * (speed_of_screw(QUIET, voltage) / PITCH - mean)
    turn = 2.0 * math.pi / math.sqrt(mean**2 - swing**2)
    after_one, after_two = (last_reading(machine, voltage, n * turn) for n in (1.0, 2.0))
    assert after_two - after_one == pytest.approx(2.0 * math.pi * PITCH, rel=1e-3)


def test_a_gap_that_is_larger_along_the_screw_is_crossed_where_it_is():
    along, half, speed = 20.0, 0.5 * GAP, 5.0 / QUIET.back_emf_constant
    gaps = np.full(round(14.0 * SAMPLING_RATE), GAP)
    running = RunningMachine(replace(QUIET, gap_along=along), gaps, SAMPLING_RATE, seed=0)
    for voltage, duration in ((5.0, 0.8), (0.0, 6.0), (-5.0, 0.4), (0.0, 6.0)):
        running.hold(voltage, round(duration * SAMPLING_RATE))
    growth = half * along * PITCH
    there = PITCH * (0.8 * speed - half) / (1.0 + growth)
    back = PITCH * (0.4 * speed + half) / (1.0 - growth)
    positions, gaps = running.true_positions(), running.true_gaps()
    at_rest = round(6.8 * SAMPLING_RATE) - 1
    assert positions[at_rest] == pytest.approx(there, rel=1e-4)
    assert positions[-1] == pytest.approx(back, rel=1e-4)
    assert gaps[at_rest] == pytest.approx(GAP * (1.0 + along * there), rel=1e-4)
    assert running.gap == pytest.approx(GAP * (1.0 + along * back), rel=1e-4)


def test_friction_grows_along_the_screw():
    machine = replace(QUIET, coulomb_friction=FRICTION, friction_along=50.0)
    begin = speed_of_screw(machine, 1.0)
    rate = 50.0 * (speed_of_screw(QUIET, 1.0) - begin)
    moved = 8.0 - 0.5 * GAP * PITCH / begin
    assert last_reading(machine, 1.0, 8.0) == pytest.approx(
        begin * -math.expm1(-rate * moved) / rate, rel=1e-3
    )


def test_the_error_of_the_thread_repeats_with_each_turn():
    error, voltages = 5e-6, np.full(round(16.0 * SAMPLING_RATE), 0.1)
    off = readings(replace(QUIET, thread_error=error), voltages) - readings(QUIET, voltages)
    turn = round(2.0 * math.pi * SAMPLING_RATE)
    assert np.abs(off[-turn:]).max() == pytest.approx(error, rel=0.02)
    assert off[-2 * turn : -turn] == pytest.approx(off[-turn:], abs=0.02 * error)


def test_guides_hold_back_the_platforms():
    force = 0.1
    behind = last_reading(QUIET, 0.1, 8.0) - last_reading(
        replace(QUIET, guide_friction=force), 0.1, 8.0
    )
    assert behind == pytest.approx(3.0 * force / QUIET.stiffness, rel=0.01)


@pytest.mark.parametrize(
    ("constants", "voltage", "left"),
    [
        ({"amplifier_dead_band": 0.5}, -2.0, -1.5),
        ({"amplifier_dead_band": 0.5}, 0.4, 0.0),
        ({"amplifier_sag": 0.1}, -24.0, -21.6),
        ({"amplifier_sag": 0.1}, 12.0, 11.4),
    ],
)
def test_an_amplifier_leaves_less_of_some_voltages(constants, voltage, left):
    duration = round(0.5 * SAMPLING_RATE)
    found = readings(replace(QUIET, **constants), np.full(duration, voltage))
    assert found == pytest.approx(readings(QUIET, np.full(duration, left)), abs=1e-15)


def test_a_motor_coasts_where_its_bridge_drops_more_than_it_induces():
    drop, voltages = 1.0, np.repeat([1.5, 0.0], 2 * round(SAMPLING_RATE))
    machine = replace(QUIET, bridge_drop=drop)
    running = readings(machine, voltages)
    speed = PITCH * (1.5 - drop) / QUIET.back_emf_constant
    assert running[-1] - running[voltages.size // 2] == pytest.approx(2.0 * speed, rel=2e-3)
    held = readings(replace(machine, coulomb_friction=FRICTION), voltages)
    driven = speed_of_screw(replace(machine, coulomb_friction=FRICTION), 1.5 - drop)
    coasted = (driven / PITCH) ** 2 * QUIET.inertia / (2.0 * FRICTION) * PITCH
    assert held[-1] == pytest.approx(2.0 * driven + coasted - 0.5 * GAP * PITCH, rel=2e-3)
