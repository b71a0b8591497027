"""Friction that yields, followed beside rigid friction from window to window."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from recorded_machine import Run, record
from unknown_machine import UnknownMachine

from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel
from bdt_twin.alternative_friction import (
    ASTRAY,
    EVERY,
    FIRST_ANGLE,
    MUCH_WORK,
    AlternativeFriction,
)
from bdt_twin.effect_trials import TRIALS
from bdt_twin.friction_evidence import BELIEVED, CERTAIN, EXPLAINED_GAIN, LARGE_ANGLE, MOST_GAIN
from bdt_twin.gap_doubt import UNEXPLAINED_YIELDING, UNSEEN_YIELDING
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import EFFECTS, YIELD_ANGLE
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.next_fit import next_fit
from bdt_twin.stretch import Stretch
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor

RATE, BLOCK = 1000.0, 5
ANGLE = math.radians(0.4)
CHANGE = math.radians(0.02)
RESTLESS, AT_REST = NoiseLevels(1e-6, slow=1e-4), NoiseLevels(1e-6, slow=1e-7)
MUCH = 10.0 * MOST_GAIN
FULL = math.ceil(BELIEVED / MOST_GAIN)
"""Comparisons that suffice where each gains much by a large angle."""


@cache
def window_with_friction(presliding=0.0):
    machine = UnknownMachine(coulomb_friction=0.01, presliding=presliding)
    rows, _ = record(machine, Run(duration=20.0, sampling_rate=RATE, step_time=3.0))
    stretch = Stretch(0, *np.ascontiguousarray(rows[:, 1:].T))
    return WindowModel(PlantModel(), [stretch], np.arange(21.0), RATE, BLOCK)


def memory_of_friction():
    return MachineMemory(MotorParameters(coulomb_friction=0.01))


@cache
def explained():
    """Return a window and its fit, of a motor with friction."""
    return next_fit(window_with_friction(), None, memory_of_friction(), CHANGE)


def followed(window, windows):
    """Return what is known in the end of a machine, and the last of some fits of the same data."""
    friction, memory, last = AlternativeFriction(), memory_of_friction(), None
    for _ in range(windows):
        window, fit = next_fit(window, last, memory, CHANGE)
        memory, fit = friction.better(window, fit, memory, CHANGE)
        last = Predecessor(window, fit, 0.0)
    return memory, last.fit


def test_friction_that_yields_is_found_with_its_angle():
    memory, fit = followed(window_with_friction(ANGLE), 2 * FULL)
    assert YIELD_ANGLE in memory.present
    found = dict(zip(EFFECTS, fit.unknowns.effects, strict=True))
    assert found["friction_voltage"] == pytest.approx(0.01 / 0.8 * 12.0, rel=0.02)
    assert found["yield_angle"] == pytest.approx(ANGLE, rel=0.3)


def test_a_motor_that_rigid_friction_explains_is_not_fitted_again():
    window, fit = explained()
    memory = memory_of_friction()
    friction = AlternativeFriction()
    for _ in range(6):
        assert friction.better(window, fit, memory, CHANGE) == (memory, fit)


class Told(AlternativeFriction):
    """One whose fits gain so much log-likelihood with such an angle, one after the other."""

    def __init__(self, gains, angle=LARGE_ANGLE):
        super().__init__()
        self.waiting, self.angle, self.begun_with = list(gains), angle, []

    def _fit(self, window, fit, machine, other, growth_change):
        gain, angle = self.waiting.pop(0), self.angle if YIELD_ANGLE in other.present else 0.0
        self.begun_with.append(None if self._last else self._other_angle(machine))
        effects = fit.unknowns.effects.copy()
        effects[YIELD_ANGLE] = angle
        error = fit.prediction_error * math.exp(-gain / fit.innovations.size)
        unknowns = replace(fit.unknowns, effects=effects)
        return replace(fit, unknowns=unknowns, prediction_error=error)


def restless(simulated=0):
    """Return a window that its fit leaves restless, and the fit."""
    window, fit = explained()
    return window, replace(fit, levels=RESTLESS, simulated=simulated)


def believed(gains, memory=None):
    """Return after how many windows the other friction is believed; None for never."""
    window, fit = restless()
    told, memory = Told(gains), memory or memory_of_friction()
    for number in range(len(gains)):
        now, _ = told.better(window, fit, memory, CHANGE)
        if now is not memory:
            assert (YIELD_ANGLE in now.present) != (YIELD_ANGLE in memory.present)
            return number + 1
    return None


def test_it_is_believed_once_it_explains_the_data_better_again_and_again():
    assert believed([MUCH] * FULL) == FULL
    assert believed([MUCH] * (FULL - 1)) is None
    assert believed([-MOST_GAIN, *[MUCH] * (FULL + 1)]) == FULL + 2


def test_friction_is_rigid_again_if_that_explains_the_data_better():
    memory = memory_of_friction().with_yield_angle(ANGLE)
    assert believed([MUCH] * FULL, memory) == FULL
    assert believed([-1.0] * FULL, memory) is None


def test_what_was_believed_is_followed_on():
    window, fit = restless()
    told, rigid = Told([MUCH] * (2 * FULL)), memory_of_friction()
    memory = rigid
    for _ in range(FULL):
        memory, _ = told.better(window, fit, memory, CHANGE)
    for _ in range(FULL):
        memory, _ = told.better(window, fit, memory, CHANGE)
    assert memory is rigid


def test_windows_are_compared_seldom_once_the_friction_is_certain():
    window, fit = restless()
    losses = math.ceil(CERTAIN / MOST_GAIN)
    told, memory = Told([-MOST_GAIN] * (losses + 2)), memory_of_friction()
    for _ in range(losses + 2 * EVERY):
        told.better(window, fit, memory, CHANGE)
    assert not told.waiting


def test_a_fit_that_has_gone_astray_begins_anew_with_an_angle_that_has_explained_more():
    window, fit = restless()
    told = Told([MUCH, 0.0, -2.0 * ASTRAY, 0.0])
    for _ in range(4):
        told.better(window, fit, memory_of_friction(), CHANGE)
    assert told.begun_with == [FIRST_ANGLE, None, None, LARGE_ANGLE]


@pytest.mark.parametrize("trial", TRIALS)
def test_fits_with_the_other_friction_begin_anew_once_the_machine_is_another_one(trial):
    window, fit = restless()
    told, memory = Told([0.0] * 3), memory_of_friction()
    told.better(window, fit, memory, CHANGE)
    memory.has_effects(np.zeros(len(EFFECTS)), trial.places)
    for _ in range(2):
        told.better(window, fit, memory, CHANGE)
    assert told.begun_with == [FIRST_ANGLE, FIRST_ANGLE, None]


def test_the_gap_is_less_sure_until_the_friction_is_certain():
    window, fit = explained()
    friction, memory = AlternativeFriction(), memory_of_friction()
    assert friction.doubt(fit) == UNEXPLAINED_YIELDING
    for _ in range(math.ceil(CERTAIN / EXPLAINED_GAIN)):
        friction.better(window, fit, memory, CHANGE)
    assert friction.doubt(fit) == UNSEEN_YIELDING


def test_the_gap_is_less_sure_as_long_as_another_one_may_be_true():
    window, fit = restless()

    class Other(Told):
        def _fit(self, window, fit, machine, other, growth_change):
            found = super()._fit(window, fit, machine, other, growth_change)
            unknowns = replace(found.unknowns, gaps=found.unknowns.gaps + 0.1)
            return replace(found, unknowns=unknowns)

    told = Other([MUCH] * (FULL - 1) + [-MOST_GAIN] * 9)
    for _ in range(FULL - 1):
        told.better(window, fit, memory_of_friction(), CHANGE)
    unsure = told.doubt(fit)
    assert 0.05 < unsure < 0.1
    while told.waiting:
        told.better(window, fit, memory_of_friction(), CHANGE)
    assert told.doubt(fit) == UNEXPLAINED_YIELDING


@pytest.mark.parametrize("case", ["at rest", "much work"])
def test_windows_that_are_explained_or_take_long_are_not_compared(case):
    window, fit = explained()
    levels, work = (AT_REST, 0) if case == "at rest" else (RESTLESS, MUCH_WORK + 1)
    fit = replace(fit, levels=levels, simulated=work)
    memory, told = memory_of_friction(), Told([MUCH] * 6)
    for _ in range(6):
        assert told.better(window, fit, memory, CHANGE) == (memory, fit)
    assert len(told.waiting) == 6


def test_the_work_of_both_fits_counts():
    window, fit = restless(simulated=1000)
    _, after = Told([0.0]).better(window, fit, memory_of_friction(), CHANGE)
    assert after.simulated == 2000
