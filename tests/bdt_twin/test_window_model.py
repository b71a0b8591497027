"""The Jacobian of the window's model is that of its own simulation."""

import math

import numpy as np
import pytest

from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS
from bdt_twin.stretch import Stretch
from bdt_twin.unknowns import (
    GAP_PER_ANGLE,
    INITIAL_CONDITION,
    SMALLEST_LAG,
    SMALLEST_YIELD_ANGLE,
    Unknowns,
)
from bdt_twin.window_model import WindowModel

PLANT = PlantModel()
RATE, BLOCK, COGS = 1000.0, 5, 24
KNOTS = np.arange(0.0, 12.1, 2.0)


def window_of(loop, *cuts, model=PLANT):
    stretches = [
        Stretch(begin, *np.ascontiguousarray(loop.rows[begin:end, 1:].T)) for begin, end in cuts
    ]
    return WindowModel(model, stretches, KNOTS, RATE, BLOCK, COGS)


EFFECTS_ALONE = {
    "friction_voltage": 0.05,
    "voltage_offset": 0.01,
    "delay": 2e-4,
    "drift": 1e-6,
}
RESISTED = EFFECTS_ALONE | {
    "excess_voltage": 0.03,
    "stribeck_speed": 0.1,
    "load_voltage": 5e-3,
    "cogging_sine": 8e-4,
    "cogging_cosine": -1e-3,
    "friction_growth": -8e-3,
    "friction_slope": 15.0,
}
YIELDS = EFFECTS_ALONE | {"yield_angle": 6e-3}
YIELDS_AND_MORE = RESISTED | {"yield_angle": 6e-3}
LAGS = RESISTED | {"voltage_lag": 1.5e-3}
LADEN = RESISTED | {"top_mass": 0.15}
OFF = RESISTED | {"thread_sine": 2e-6, "thread_cosine": -3e-6}


def unknowns_of(window, effects=RESISTED):
    """Return unknowns away from any special case."""
    initial_conditions = np.zeros((len(window.stretches), len(INITIAL_CONDITION)))
    initial_conditions[:] = [0.3, 1e-4, 2e-4, -1e-3, 3e-4, 2e-3]
    gaps = np.deg2rad(np.linspace(8.0, 12.0, KNOTS.size))
    return Unknowns(
        gaps,
        np.array([0.021, -0.013, 0.105]),
        initial_conditions,
        np.array([effects.get(name, 0.0) for name in EFFECTS]),
    )


def means(window, unknowns):
    return np.concatenate(
        [
            simulate.position.reshape(-1, BLOCK).mean(axis=1)
            for simulate in window.simulate(unknowns)
        ]
    )


def test_a_vector_holds_all_unknowns(closed_loop):
    unknowns = unknowns_of(window_of(closed_loop(), (0, 5000), (6000, 12000)))
    vector = unknowns.as_vector()
    assert vector.size == KNOTS.size + len(FACTORS) + len(EFFECTS) + 2 * len(INITIAL_CONDITION)
    assert (unknowns.from_vector(vector).as_vector() == vector).all()


def test_unknowns_stay_where_they_have_a_meaning(closed_loop):
    unknowns = unknowns_of(window_of(closed_loop(), (0, 5000)))
    far = unknowns.from_vector(unknowns.as_vector() - 5.0)
    assert (far.gaps == 0.0).all()
    assert (far.factors == -1.0).all()
    assert far.initial_conditions[0, 0] == -1.0
    assert far.effects[EFFECTS.index("friction_voltage")] == 0.0


def test_friction_that_yields_stays_one_that_does_and_a_rigid_one_rigid(closed_loop):
    window = window_of(closed_loop(), (0, 5000))
    for effects, least in ((YIELDS, SMALLEST_YIELD_ANGLE), (EFFECTS_ALONE, 0.0)):
        unknowns = unknowns_of(window, effects)
        far = unknowns.from_vector(unknowns.as_vector() - 1.0)
        assert far.effects[EFFECTS.index("yield_angle")] == least


def test_a_gap_is_larger_for_friction_that_yields_later(closed_loop):
    unknowns = unknowns_of(window_of(closed_loop(), (0, 5000)), YIELDS)
    other = unknowns.with_yield_angle(0.01)
    assert other.effects[EFFECTS.index("yield_angle")] == 0.01
    assert other.gaps == pytest.approx(unknowns.gaps + GAP_PER_ANGLE * (0.01 - 6e-3))
    back = other.with_yield_angle(6e-3)
    assert back.as_vector() == pytest.approx(unknowns.as_vector())


def test_a_reading_that_was_late_is_not_where_the_voltage_is(closed_loop):
    window = window_of(closed_loop(), (0, 5000))
    unknowns = unknowns_of(window)
    other = unknowns.with_late_voltage()
    assert other.effects[EFFECTS.index("voltage_lag")] == RESISTED["delay"]
    assert other.effects[EFFECTS.index("delay")] == 0.0
    assert unknowns.effects[EFFECTS.index("delay")] == RESISTED["delay"]


def test_a_voltage_that_is_late_stays_one_that_may_be_and_a_prompt_one_prompt(closed_loop):
    window = window_of(closed_loop(), (0, 5000))
    for effects, least in ((LAGS, SMALLEST_LAG), (RESISTED, 0.0)):
        unknowns = unknowns_of(window, effects)
        far = unknowns.from_vector(unknowns.as_vector() - 1.0)
        assert far.effects[EFFECTS.index("voltage_lag")] == least


def test_an_amplifier_that_lags_moves_the_motor_as_far_later(closed_loop):
    window = window_of(closed_loop(), (0, 5000))
    lag = LAGS["voltage_lag"]
    prompt, lagging = (
        window.simulate(unknowns_of(window, effects))[0].motor_angle for effects in (RESISTED, LAGS)
    )
    times = np.arange(prompt.size) / RATE
    late = np.interp(times - lag, times, prompt)
    away = np.abs(lagging - prompt).max()
    assert 0.0 < np.abs(lagging - late).max() < 0.5 * away


def test_a_payload_is_told_as_one_that_the_model_has(closed_loop):
    loop = closed_loop()
    effects = RESISTED | {"top_mass": math.log(1.3)}
    found = means(window_of(loop, (0, 5000)), unknowns_of(window_of(loop, (0, 5000)), effects))
    laden = PlantModel(structure=StructureParameters(top_mass_ratio=1.3))
    window = window_of(loop, (0, 5000), model=laden)
    expected = means(window, unknowns_of(window))
    assert np.abs(found - expected).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.parametrize("cuts", [[(0, 12000)], [(1000, 6000), (7000, 12000)]])
@pytest.mark.parametrize(
    ("effects", "share"),
    [
        (EFFECTS_ALONE, 0.08),
        (RESISTED, 0.13),
        (YIELDS, 0.13),
        (YIELDS_AND_MORE, 0.13),
        (LAGS, 0.13),
        (LADEN, 0.13),
        (OFF, 0.13),
    ],
)
def test_the_jacobian_is_that_of_the_simulation(closed_loop, cuts, effects, share):
    window = window_of(closed_loop(), *cuts)
    unknowns = unknowns_of(window, effects)
    vector = unknowns.as_vector()
    # Taken from block to block, they miss what is faster than a block.
    jacobian = window.jacobian(unknowns, window.simulate(unknowns))
    assert jacobian.shape == (vector.size, sum(end - begin for begin, end in cuts) // BLOCK)
    absent = KNOTS.size + len(FACTORS) + np.flatnonzero(unknowns.effects == 0.0)
    for number, slope in enumerate(jacobian):
        if number in absent:
            continue
        change = np.zeros(vector.size)
        change[number] = 1e-6
        ahead, behind = (
            means(window, unknowns.from_vector(vector + sign * change)) for sign in (1, -1)
        )
        expected = (ahead - behind) / 2e-6
        assert np.linalg.norm(slope - expected) < share * np.linalg.norm(expected), number


def test_weights_interpolate_between_the_knots(closed_loop):
    window = window_of(closed_loop(), (0, 5000))
    times, gaps = np.array([0.0, 0.5, 3.0, 12.0]), np.arange(7.0) ** 2
    assert gaps @ window.weights(times) == pytest.approx(np.interp(times, KNOTS, gaps))


@pytest.mark.parametrize(("duration", "samples"), [(3.0, 3000), (3.0019, 3000), (12.0, 6000)])
def test_the_newest_data_are_those_of_the_last_stretch(closed_loop, duration, samples):
    window = window_of(closed_loop(), (0, 4000), (5000, 11000))
    newest = window.newest(duration)
    (stretch,) = newest.stretches
    assert stretch.first == 11000 - samples
    assert newest.samples == samples
    assert newest.cogs == COGS
    # The gap at their beginning is between two knots.
    assert newest.knots[0] <= stretch.first / RATE < newest.knots[1]
    assert newest.knots[-1] == KNOTS[-1]


def test_data_without_a_hole_that_are_short_are_all_the_newest(closed_loop):
    window = window_of(closed_loop(), (0, 4000))
    assert window.newest(4.0) is window
    assert window.newest(3.0) is not window
