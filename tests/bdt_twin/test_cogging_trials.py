"""Cogging that no small correction shows is found by trying numbers, on an independent machine."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from recorded_machine import Run, record
from unknown_machine import UnknownMachine

from bdt_plant.plant import PlantModel
from bdt_twin.cogging_trials import FINALISTS, MUCH_WORK, ROUNDS, TRIALS, CoggingTrials
from bdt_twin.machine_knowledge import COGGING
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.output_error_settings import OutputErrorSettings

RATE, DURATION, COGS, TORQUE = 1000.0, 60.0, 12, 2e-3
MOTOR = PlantModel().motor
GROWTH_CHANGE = OutputErrorSettings().growth_change


@cache
def run_of(cogging):
    """Return estimator, estimates and true gaps of a motor without friction."""
    machine = UnknownMachine(cogging=cogging, cogs=float(COGS))
    rows, gaps = record(machine, Run(duration=DURATION, sampling_rate=RATE, seed=2))
    estimator = OutputErrorEstimator(PlantModel(), OutputErrorSettings(), RATE)
    estimates = [estimator.update(batch) for batch in np.split(rows, round(DURATION))]
    return estimator, estimates, gaps


@pytest.fixture
def fits(monkeypatch):
    """Count the fits that are made, by the numbers of their windows."""
    numbers = []
    solve = WindowFit.solve

    def counted(self, *args, **options):
        numbers.append(self._window.cogs)
        return solve(self, *args, **options)

    monkeypatch.setattr(WindowFit, "solve", counted)
    return numbers


def test_a_number_is_found_without_any_slope(monkeypatch):
    """Nobody looks at slopes, and no fit without cogging explains the motion from well to well."""
    monkeypatch.setattr(MachineMemory, "looks_for_cogging", lambda *_: False)
    run_of.cache_clear()
    estimator, estimates, gaps = run_of(TORQUE)
    run_of.cache_clear()
    assert estimator.last_fit.window.cogs == COGS
    size = np.hypot(*estimator.last_fit.fit.unknowns.effects[sorted(COGGING)])
    assert size == pytest.approx(TORQUE / MOTOR.torque_constant * MOTOR.resistance, rel=0.2)
    told = [one for one in estimates[-15:] if not one.reason]
    errors = [math.degrees(one.gap - gaps[round(one.time * RATE)]) for one in told]
    assert len(told) > 10
    assert max(map(abs, errors)) < 0.4


def test_a_machine_that_no_number_explains_gets_none_and_is_left_alone_in_the_end(fits):
    """Windows of a machine without cogging, made to look as if nothing explained them."""
    last = run_of(0.0)[0].last_fit
    restless = last.fit.levels._replace(slow=100.0 * last.fit.levels.reading)
    fit = replace(last.fit, levels=restless)
    trials, memory = CoggingTrials(MOTOR), MachineMemory(MOTOR)
    windows = sum(1 + (len(numbers) + FINALISTS) // TRIALS + FINALISTS for _, numbers in ROUNDS)
    fits.clear()
    for _ in range(windows):
        before = len(fits)
        assert trials.advance(last.window, fit, memory, GROWTH_CHANGE) is None
        tried = {number for number in fits[before:] if number != last.window.cogs}
        assert len(tried) <= TRIALS
    everything = set(fits)
    assert {number for _, numbers in ROUNDS for number in numbers} <= everything
    fits.clear()
    assert trials.advance(last.window, fit, memory, GROWTH_CHANGE) is None
    assert not fits


def test_a_motor_that_does_not_walk_is_not_searched(fits):
    last = run_of(0.0)[0].last_fit
    trials = CoggingTrials(MOTOR)
    fits.clear()
    assert trials.advance(last.window, last.fit, MachineMemory(MOTOR), GROWTH_CHANGE) is None
    assert not fits


def test_short_data_are_not_searched(fits):
    last = run_of(0.0)[0].last_fit
    restless = last.fit.levels._replace(slow=100.0 * last.fit.levels.reading)
    fit, window = replace(last.fit, levels=restless), last.window.newest(2.0)
    trials = CoggingTrials(MOTOR)
    fits.clear()
    assert trials.advance(window, fit, MachineMemory(MOTOR), GROWTH_CHANGE) is None
    assert not fits


def test_a_window_whose_own_fit_takes_long_has_no_time_for_trials(fits):
    last = run_of(0.0)[0].last_fit
    restless = last.fit.levels._replace(slow=100.0 * last.fit.levels.reading)
    trials = CoggingTrials(MOTOR)
    for simulated, tries in ((MUCH_WORK + 1, False), (MUCH_WORK, True)):
        fits.clear()
        fit = replace(last.fit, levels=restless, simulated=simulated)
        trials.advance(last.window, fit, MachineMemory(MOTOR), GROWTH_CHANGE)
        assert bool(fits) is tries
