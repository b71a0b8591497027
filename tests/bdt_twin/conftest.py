"""Recordings of the closed loop, the data of the twin's tests."""

import threading
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile
from bdt_plant.gap_profile import GapProfile, gap_at, gaps_at
from bdt_plant.plant import AT_REST, PlantModel, Sampling, discretize_plant, plant_step
from bdt_study.simulation.closed_loop import Scenario, simulate

RATE, HOLD = 5000, 10
MODEL = PlantModel()


class Recording(NamedTuple):
    """Voltage, position and what only a simulator knows, one element a sample."""

    voltage: np.ndarray
    position: np.ndarray
    theta_m: np.ndarray
    theta_d: np.ndarray
    gap: np.ndarray


@cache
def record(profile, duration, step_time=2.0):
    """Record the loop with the dead zone of figure 4 and 5 mm steps, `duration` [s] long."""
    step = discretize_plant(PlantModel(), 1 / RATE)
    ten_degrees_of_screw = 1e-3 * 10 / 360
    settings = ControllerSettings(dead_zone_tolerance=ten_degrees_of_screw)
    controller = DeadZoneController(PidGains(), settings)
    state, rows = AT_REST, []
    for sample in range(round(duration * RATE)):
        if sample % HOLD == 0:
            reference = 0.0 if (sample // round(step_time * RATE)) % 2 else 5e-3
            voltage = controller.step(reference, state.structure.q3)
        gap = gap_at(profile, sample / RATE)
        rows.append((voltage, state.structure.q3, state.motor.angle, state.theta_d, gap))
        state = plant_step(state, voltage, gap_at(profile, (sample + 1) / RATE), step)
    columns = np.array(rows).T
    columns.flags.writeable = False
    return Recording(*columns)


@pytest.fixture
def constant_gap():
    """Record the loop with a constant gap [deg]."""
    return lambda degrees, duration=8.0: record(
        GapProfile(kind="constant", initial=float(np.deg2rad(degrees))), duration
    )


@pytest.fixture
def growing_gap():
    """Record the loop with a gap that grows evenly from one angle to another [deg]."""
    return lambda first, last, duration: record(
        GapProfile(
            kind="ramp",
            initial=float(np.deg2rad(first)),
            final=float(np.deg2rad(last)),
            growth_time=duration,
        ),
        duration,
    )


LONGEST_WINDOW = 60.0
"""Time [s] that a window may take on a busy machine."""


@pytest.fixture(autouse=True)
def nothing_goes_on_beside_the_next_test():
    """Wait for a twin's window: its node does not, and the next test may count fits."""
    yield
    for thread in threading.enumerate():
        if thread.name == "estimation":
            thread.join(LONGEST_WINDOW)
            assert not thread.is_alive()


class Loop(NamedTuple):
    """Telemetry rows (t, u, q3) of a closed loop, and what only a simulator knows."""

    rows: np.ndarray
    theta_d: np.ndarray
    gaps: np.ndarray


@cache
def simulate_loop(profile, duration, rate, dead_zone_degrees, step_time, model):
    """Simulate 5 mm steps; see the fixture `closed_loop`."""
    scenario = Scenario(
        duration=duration,
        reference=ReferenceProfile(step_time=step_time),
        gap=profile,
        dead_zone=1e-3 * dead_zone_degrees / 360,
        model=model,
        sampling=Sampling(sampling_rate=rate),
    )
    loop = simulate(scenario, keep=("u", "q3", "theta_d"))
    rows = np.column_stack([loop.t, loop.u, loop.q3])
    found = Loop(rows, loop.theta_d, gaps_at(profile, loop.t))
    # All tests have the same ones.
    for array in found:
        array.flags.writeable = False
    return found


@pytest.fixture
def closed_loop():
    """Simulate the loop for a gap [deg] or its profile, the same telemetry at any sampling rate."""

    def simulated(gap=10.0, duration=12.0, rate=1000.0, dead_zone=10.0, step_time=3.0, model=MODEL):
        if not isinstance(gap, GapProfile):
            gap = GapProfile(kind="constant", initial=float(np.deg2rad(gap)))
        return simulate_loop(gap, duration, rate, dead_zone, step_time, model)

    return simulated
