"""The compiled window is the plant's own loop; its notes are what the trajectory shows."""

import numpy as np
import pytest

from bdt_plant import compilation
from bdt_plant.gap_profile import GapProfile
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import AT_REST, PlantModel, Sampling, discretize_plant
from bdt_plant.plant_simulator import PlantSimulator
from bdt_twin.forward_model import (
    SMALLEST_TRAVEL,
    SlowMotion,
    initial_state,
    simulate_stretch,
)
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS
from bdt_twin.resisted_model import resisted_plant_with
from bdt_twin.window_loop import compiled_window

RATE, BLOCK = 1000.0, 5
STEP = resisted_plant_with(PlantModel(), np.zeros(len(FACTORS)), np.zeros(len(EFFECTS)), 1 / RATE)
SLOW = SlowMotion(speed=5.0, standing_voltage=0.0, back_emf=0.1)


def run_from_rest(loop):
    voltage = np.ascontiguousarray(loop.rows[:, 1])
    return simulate_stretch(STEP, AT_REST, voltage, loop.gaps, BLOCK, 1 / RATE, SLOW)


def test_from_the_true_beginning_the_position_is_that_of_the_plant(closed_loop):
    loop = closed_loop()
    assert np.abs(run_from_rest(loop).position - loop.rows[:, 2]).max() < 1e-15


def test_the_screw_is_where_its_last_contact_left_it(closed_loop):
    """theta_d = theta_m - side gap / 2, taken at the last contact."""
    run, gap = run_from_rest(closed_loop()), np.deg2rad(10.0)
    moved = np.abs(run.side) == 1.0
    assert moved.sum() > 2000
    assert np.abs(run.motor - 0.5 * gap * run.side - run.screw)[moved].max() < 1e-12


def test_reversals_are_where_the_screw_begins_to_turn_back(closed_loop):
    loop = closed_loop()
    angle, found = loop.theta_d, run_from_rest(loop).reversals
    assert len(found) > 8
    ends = [0, *found, angle.size]
    for begin, turn, after in zip(ends, ends[1:], ends[2:], strict=False):
        direction = np.sign(angle[turn] - angle[turn - 1])
        stretch = direction * angle[begin:turn]
        # Before, the screw moved the other way; after, it goes at least as far as counts.
        assert stretch[-1] == stretch.min()
        assert (direction * (angle[turn:after] - angle[turn - 1])).max() >= SMALLEST_TRAVEL


def test_travel_is_the_way_that_the_screw_moved(closed_loop):
    loop = closed_loop()
    assert run_from_rest(loop).travel == pytest.approx(np.abs(np.diff(loop.theta_d)).sum())


def test_the_lag_stays_within_half_of_the_gap(closed_loop):
    run = run_from_rest(closed_loop())
    assert np.abs(run.relative_angle).max() == pytest.approx(np.deg2rad(5.0))


def test_the_motor_begins_at_the_speed_for_its_voltage():
    back_emf = PlantModel().motor.back_emf_constant
    state = initial_state(AT_REST.structure, 0.1, np.array([2.0]), back_emf, STEP.plant)
    run = simulate_stretch(STEP, state, np.full(100, 2.0), np.full(100, 50.0), 1, 1 / RATE, SLOW)
    assert np.diff(run.relative_angle) == pytest.approx(np.full(99, 0.02), rel=2e-2)
    assert run.relative_angle[0] == 0.1


@pytest.mark.parametrize("friction", [0.0, 0.01])
def test_the_motor_begins_as_fast_as_the_voltages_before_have_made_it(friction):
    """What it did more than 10 ms ago is forgotten."""
    model = PlantModel(motor=MotorParameters(coulomb_friction=friction))
    plant = PlantSimulator(model, GapProfile(), Sampling(RATE, RATE))
    voltages = np.random.default_rng(0).uniform(-5.0, 5.0, 60)
    for voltage in voltages[:-1]:
        plant.advance(voltage)
    step = discretize_plant(model, 1 / RATE)
    back_emf = model.motor.back_emf_constant
    state = initial_state(AT_REST.structure, 0.1, voltages[-11:], back_emf, step)
    assert state.motor.speed == pytest.approx(plant.state.motor.speed, abs=1e-3)
    assert state.motor.angle == 0.1


def test_without_numba_the_floats_are_the_same(closed_loop, monkeypatch):
    loop = closed_loop(duration=1.0, step_time=0.5)
    compiled = run_from_rest(loop)
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    compiled_window.cache_clear()
    try:
        plain = run_from_rest(loop)
    finally:
        compiled_window.cache_clear()
    for name, first, second in zip(compiled._fields, compiled, plain, strict=True):
        assert np.array_equal(first, second), name
