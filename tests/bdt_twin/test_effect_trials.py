"""When effects that show no evidence are tried, and what of it is believed."""

from types import SimpleNamespace

import numpy as np
import pytest

from bdt_twin.effect_trials import (
    LAG_GAIN,
    LEAST_TOP_MASS,
    TOP_MASS_COVERAGE,
    TOP_MASS_GAIN,
    TRIED,
    TRIED_AGAIN,
    TrialTimes,
    begun_with,
    is_believed,
)
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import EFFECTS, TOP_MASS, VOLTAGE_LAG, MachineKnowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import HARDLY_EXPLAINED
from bdt_twin.unknowns import LATE, Unknowns

DELAY = EFFECTS.index("delay")


def unknowns_with(**sizes):
    effects = np.array([sizes.get(name, 0.0) for name in EFFECTS])
    return Unknowns(np.ones(3), np.zeros(len(FACTORS)), np.zeros((1, 6)), effects)


def found(gain, walk=0.0, spread=1e-3, **sizes):
    """Return what a trial has found: its gain, walk of the motor and effects with a spread."""
    unknowns = unknowns_with(**sizes)
    expected = np.concatenate([unknowns.factors, unknowns.effects])
    return SimpleNamespace(
        gain_over=lambda fit: gain,
        levels=NoiseLevels(1e-6, fast=walk * 1e-6),
        unknowns=unknowns,
        machine=MachineKnowledge(expected, spread**2 * np.eye(expected.size)),
    )


def test_each_effect_is_tried_less_and_less_often():
    times = TrialTimes()
    for effect in TRIED:
        tried = [times.is_due(effect) for _ in range(8 * TRIED_AGAIN)]
        assert np.flatnonzero(tried).tolist() == [TRIED_AGAIN * n for n in (0, 1, 3, 7)]


def test_a_trial_begins_with_a_voltage_as_late_as_the_reading_was():
    begun = begun_with(VOLTAGE_LAG, unknowns_with(delay=1e-3))
    assert (begun.effects[VOLTAGE_LAG], begun.effects[DELAY]) == (1e-3, 0.0)


def test_a_trial_begins_with_a_mass_that_has_a_slope():
    without = unknowns_with(delay=1e-3)
    begun = begun_with(TOP_MASS, without)
    assert 0.0 < begun.effects[TOP_MASS] < LEAST_TOP_MASS
    assert begun.effects[DELAY] == 1e-3
    assert without.effects[TOP_MASS] == 0.0


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
    assert is_believed(VOLTAGE_LAG, trial, None) == is_one


@pytest.mark.parametrize(
    ("gain", "coverage", "top_mass", "is_one"),
    [
        (TOP_MASS_GAIN + 1.0, TOP_MASS_COVERAGE + 1.0, 0.2, True),
        (TOP_MASS_GAIN + 1.0, TOP_MASS_COVERAGE + 1.0, -0.2, True),
        (TOP_MASS_GAIN - 1.0, TOP_MASS_COVERAGE + 1.0, 0.2, False),
        (1000.0, TOP_MASS_COVERAGE - 1.0, 0.2, False),
        (1000.0, 100.0, 0.9 * LEAST_TOP_MASS, False),
    ],
)
def test_a_mass_is_another_one_that_explains_more_for_certain(gain, coverage, top_mass, is_one):
    for walk in (0.0, 100.0):
        trial = found(gain, walk, abs(top_mass) / coverage, top_mass=top_mass)
        assert is_believed(TOP_MASS, trial, None) == is_one
