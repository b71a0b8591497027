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
    ALIKE,
    ASTRAY,
    COMPARISONS,
    EVERY,
    FEWEST_COMPARISONS,
    GREAT_GAIN,
    LEAST_GAIN,
    MUCH_WORK,
    TOTAL_GAIN,
    AlternativeFriction,
)
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
MUCH = 1.1 * TOTAL_GAIN / COMPARISONS


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
    memory, fit = followed(window_with_friction(ANGLE), 4 * COMPARISONS)
    assert YIELD_ANGLE in memory.present
    found = dict(zip(EFFECTS, fit.unknowns.effects, strict=True))
    assert found["friction_voltage"] == pytest.approx(0.01 / 0.8 * 12.0, rel=0.02)
    assert found["yield_angle"] == pytest.approx(ANGLE, rel=0.3)


def test_a_motor_that_rigid_friction_explains_is_not_fitted_again():
    window, fit = explained()
    memory = memory_of_friction()
    friction = AlternativeFriction()
    for _ in range(EVERY * COMPARISONS):
        assert friction.better(window, fit, memory, CHANGE) == (memory, fit)


class Told(AlternativeFriction):
    """One whose fits gain so much log-likelihood with such an angle, one after the other."""

    def __init__(self, gains, angles):
        super().__init__()
        self.waiting = list(zip(gains, angles, strict=True))

    def _fit(self, window, fit, machine, other, growth_change):
        gain, angle = self.waiting.pop(0)
        effects = fit.unknowns.effects.copy()
        effects[YIELD_ANGLE] = angle
        error = fit.prediction_error * math.exp(-gain / fit.innovations.size)
        unknowns = replace(fit.unknowns, effects=effects)
        return replace(fit, unknowns=unknowns, prediction_error=error)


def believed(gains, angles, memory=None, levels=RESTLESS, **changes):
    """Return after how many comparisons the other friction is believed; None for never."""
    window, fit = explained()
    fit = replace(fit, levels=levels, simulated=0, **changes)
    told, memory = Told(gains, angles), memory or memory_of_friction()
    for number in range(EVERY * len(gains)):
        now, _ = told.better(window, fit, memory, CHANGE)
        if now is not memory:
            assert (YIELD_ANGLE in now.present) != (YIELD_ANGLE in memory.present)
            return 1 + number // EVERY
    return None


def test_it_is_believed_if_it_explains_the_data_better_each_time():
    angles = [ANGLE] * (COMPARISONS + 1)
    assert believed([MUCH] * (COMPARISONS + 1), angles) == COMPARISONS
    assert believed([-1.0, *[MUCH] * COMPARISONS], angles) == COMPARISONS + 1


def test_fewer_comparisons_suffice_where_it_explains_much_more():
    great = [1.1 * GREAT_GAIN] * FEWEST_COMPARISONS
    angles = [ANGLE] * FEWEST_COMPARISONS
    assert believed(great, angles) == FEWEST_COMPARISONS
    assert believed([*great[1:], 0.9 * GREAT_GAIN], angles) is None
    assert believed(great, [*angles[1:], 1.1 * ALIKE * ANGLE]) is None


@pytest.mark.parametrize(
    ("gains", "angles"),
    [
        ([*[MUCH] * (COMPARISONS - 1), LEAST_GAIN - 1.0], [ANGLE] * COMPARISONS),
        ([0.8 * MUCH] * COMPARISONS, [ANGLE] * COMPARISONS),
        (
            [MUCH] * COMPARISONS,
            [*[ANGLE] * (COMPARISONS - 1), 1.1 * ALIKE * ANGLE],
        ),
    ],
    ids=["once it did not", "too little in all", "another angle"],
)
def test_it_is_not_believed_otherwise(gains, angles):
    assert believed(gains, angles) is None
    after = believed(gains + [MUCH] * COMPARISONS, angles + [ANGLE] * COMPARISONS)
    assert after is not None, "it is later, if it does from then on"


def test_a_fit_that_has_gone_astray_tells_nothing():
    gains = [MUCH, -2.0 * ASTRAY, *[MUCH] * (COMPARISONS - 1)]
    assert believed(gains, [ANGLE] * len(gains)) == COMPARISONS + 1


def test_friction_is_rigid_again_if_that_explains_the_data_as_well_each_time():
    memory = memory_of_friction().with_yield_angle(ANGLE)
    gains = [1.0] * COMPARISONS
    assert believed(gains, [0.0] * COMPARISONS, memory) == COMPARISONS
    assert believed([*gains[1:], -1.0], [0.0] * COMPARISONS, memory) is None


@pytest.mark.parametrize("case", ["at rest", "much work"])
def test_windows_that_are_explained_or_take_long_are_not_compared(case):
    window, fit = explained()
    levels, work = (AT_REST, 0) if case == "at rest" else (RESTLESS, MUCH_WORK + 1)
    fit = replace(fit, levels=levels, simulated=work)
    memory, told = memory_of_friction(), Told([MUCH] * 6, [ANGLE] * 6)
    for _ in range(6):
        assert told.better(window, fit, memory, CHANGE) == (memory, fit)
    assert len(told.waiting) == 6


def test_the_work_of_both_fits_counts():
    window, fit = explained()
    fit = replace(fit, levels=RESTLESS, simulated=1000)
    _, after = Told([0.0], [ANGLE]).better(window, fit, memory_of_friction(), CHANGE)
    assert after.simulated == 2000
