"""When effects that show no evidence are tried, and what of it is believed."""

from types import SimpleNamespace

import numpy as np
import pytest

from bdt_twin.effect_trials import (
    CERTAIN_GAIN,
    LAG_GAIN,
    LATE_VOLTAGE,
    LEAST_THREAD_ERROR,
    LEAST_TOP_MASS,
    OTHER_TOP_MASS,
    THREAD_COVERAGE,
    THREAD_ERROR,
    TOP_MASS_COVERAGE,
    TRIED_AGAIN,
    TrialTimes,
)
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import EFFECTS, THREAD, TOP_MASS, VOLTAGE_LAG, MachineKnowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import HARDLY_EXPLAINED
from bdt_twin.unknowns import LATE, Unknowns

DELAY = EFFECTS.index("delay")


def unknowns_with(**sizes):
    effects = np.array([sizes.get(name, 0.0) for name in EFFECTS])
    return Unknowns(np.ones(3), np.zeros(len(FACTORS)), np.zeros((1, 6)), effects)


def machine_with(spread=1e-3, **sizes):
    unknowns = unknowns_with(**sizes)
    expected = np.concatenate([unknowns.factors, unknowns.effects])
    return MachineKnowledge(expected, spread**2 * np.eye(expected.size))


def found(gain, walk=0.0, spread=1e-3, **sizes):
    """Return what a trial has found: its gain, walk of the motor and effects with a spread."""
    return SimpleNamespace(
        gain_over=lambda fit: gain,
        levels=NoiseLevels(1e-6, fast=walk * 1e-6),
        unknowns=unknowns_with(**sizes),
        machine=machine_with(spread, **sizes),
    )


def test_each_effect_is_tried_less_and_less_often_and_one_in_a_window():
    times, late = TrialTimes(), machine_with(delay=2.0 * LATE)
    tried = [times.due((), late) for _ in range(12 * TRIED_AGAIN)]
    assert tried[:3] == [LATE_VOLTAGE, OTHER_TOP_MASS, THREAD_ERROR]
    for trial in (LATE_VOLTAGE, OTHER_TOP_MASS, THREAD_ERROR):
        numbers = [number for number, each in enumerate(tried) if each is trial]
        assert len(numbers) == 4
        assert (np.diff(numbers) >= [TRIED_AGAIN, 2 * TRIED_AGAIN, 4 * TRIED_AGAIN]).all()


def test_a_voltage_is_not_late_where_no_reading_is():
    times, prompt = TrialTimes(), machine_with(delay=0.9 * LATE)
    tried = [times.due(THREAD, prompt) for _ in range(8 * TRIED_AGAIN)]
    numbers = [number for number, each in enumerate(tried) if each is OTHER_TOP_MASS]
    assert numbers == [TRIED_AGAIN * n for n in (0, 1, 3, 7)]
    assert all(each in (None, OTHER_TOP_MASS) for each in tried)


def test_what_a_machine_has_is_not_tried():
    times, late = TrialTimes(), machine_with(delay=2.0 * LATE)
    assert not any(times.due({VOLTAGE_LAG, TOP_MASS, *THREAD}, late) for _ in range(9))


def test_a_trial_begins_with_a_voltage_as_late_as_the_reading_was():
    begun = LATE_VOLTAGE.begun(unknowns_with(delay=1e-3))
    assert (begun.effects[VOLTAGE_LAG], begun.effects[DELAY]) == (1e-3, 0.0)


@pytest.mark.parametrize("trial", [OTHER_TOP_MASS, THREAD_ERROR])
def test_another_one_begins_with_next_to_nothing_that_has_a_slope(trial):
    without = unknowns_with(delay=1e-3)
    begun = trial.begun(without)
    assert (begun.effects[list(trial.places)] > 0.0).all()
    sizes = dict(zip(EFFECTS, begun.effects.tolist(), strict=True))
    assert not trial.is_believed(found(1e6, 0.0, 1e-12, **sizes), None)
    assert begun.effects[DELAY] == 1e-3
    assert not without.effects[list(trial.places)].any()


@pytest.mark.parametrize(
    ("gain", "walk", "delay", "is_one"),
    [
        (LAG_GAIN + 1.0, 1.0, 0.0, True),
        (LAG_GAIN - 1.0, 1.0, 0.0, False),
        (100.0, HARDLY_EXPLAINED + 1.0, 0.0, False),
        (100.0, 1.0, -LATE, False),
    ],
)
def test_a_voltage_is_late_that_explains_more_and_all_of_it(gain, walk, delay, is_one):
    trial = found(gain, walk, voltage_lag=2.0 * LATE, delay=delay)
    assert LATE_VOLTAGE.is_believed(trial, None) == is_one


@pytest.mark.parametrize(
    ("gain", "coverage", "top_mass", "is_one"),
    [
        (CERTAIN_GAIN + 1.0, TOP_MASS_COVERAGE + 1.0, 0.2, True),
        (CERTAIN_GAIN + 1.0, TOP_MASS_COVERAGE + 1.0, -0.2, True),
        (CERTAIN_GAIN - 1.0, TOP_MASS_COVERAGE + 1.0, 0.2, False),
        (1000.0, TOP_MASS_COVERAGE - 1.0, 0.2, False),
        (1000.0, 100.0, 0.9 * LEAST_TOP_MASS, False),
    ],
)
def test_a_mass_is_another_one_that_explains_more_for_certain(gain, coverage, top_mass, is_one):
    for walk in (0.0, 100.0):
        trial = found(gain, walk, abs(top_mass) / coverage, top_mass=top_mass)
        assert OTHER_TOP_MASS.is_believed(trial, None) == is_one


@pytest.mark.parametrize(
    ("sine", "cosine", "spread", "is_one"),
    [
        (1e-6, 0.0, 1e-6 / (THREAD_COVERAGE + 1.0), True),
        (0.6e-6, -0.8e-6, 1e-6 / (THREAD_COVERAGE + 1.0), True),
        (0.6e-6, -0.8e-6, 1e-6 / (THREAD_COVERAGE - 1.0), False),
        (0.0, 0.9 * LEAST_THREAD_ERROR, 1e-9, False),
    ],
)
def test_a_thread_is_off_by_both_parts_of_its_error_together(sine, cosine, spread, is_one):
    trial = found(100.0, 1.0, spread, thread_sine=sine, thread_cosine=cosine)
    assert THREAD_ERROR.is_believed(trial, None) == is_one
