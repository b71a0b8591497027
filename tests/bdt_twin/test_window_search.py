"""The fit of a window that has no predecessor, or one that is of no use, and the work it takes."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel
from bdt_twin import window_search
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import EFFECTS, YIELD_ANGLE, first_knowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.output_error_fit import HALVINGS, WindowFit
from bdt_twin.stretch import Stretch
from bdt_twin.unknowns import INITIAL_CONDITION, Unknowns
from bdt_twin.window_model import WindowModel
from bdt_twin.window_search import (
    FEWEST_SIMULATIONS,
    MOST_SAMPLES,
    fit_window,
    initial_conditions_at_rest,
)

RATE, BLOCK = 1000.0, 5
GROWTH_CHANGE = math.radians(0.02)
# A motor without friction has none that yields.
KNOWN = first_knowledge(PlantModel().motor).without({YIELD_ANGLE})
GROWING = GapProfile(kind="ramp", initial=0.1, final=0.3, growth_time=12.0)


def window_of(loop, begin=0, end=12000, rate=RATE, block=BLOCK):
    stretch = Stretch(begin, *np.ascontiguousarray(loop.rows[begin:end, 1:].T))
    knots = np.arange(math.floor(begin / rate), math.ceil(end / rate) + 1.0)
    return WindowModel(PlantModel(), [stretch], knots, rate, block)


def unknowns_with(window, degrees):
    gaps = np.full(window.knots.size, math.radians(degrees))
    return Unknowns(gaps, np.zeros(len(FACTORS)), initial_conditions_at_rest(window))


@pytest.fixture
def simulated(monkeypatch):
    """Count the samples that windows simulate, by their sampling rate."""
    counts = {}
    simulate = WindowModel.simulate

    def counted(window, unknowns):
        samples = sum(stretch.voltage.size for stretch in window.stretches)
        rate = round(window.block_rate * window.block)
        counts.setdefault(rate, []).append(samples)
        return simulate(window, unknowns)

    monkeypatch.setattr(WindowModel, "simulate", counted)
    return counts


@pytest.mark.parametrize("degrees", [0.5, 5.0, 12.0, 22.0, 40.0, 90.0])
def test_a_gap_of_any_size_is_found_without_a_predecessor(closed_loop, degrees):
    window = window_of(closed_loop(degrees, dead_zone=degrees))
    fit = fit_window(window, GROWTH_CHANGE, KNOWN)
    assert np.rad2deg(fit.unknowns.gaps[3:-3]) == pytest.approx(degrees, abs=0.02)


@pytest.mark.parametrize("predicted", [0.0, 30.0])
def test_a_prediction_that_is_far_off_does_not_hold_the_fit(closed_loop, predicted):
    loop = closed_loop(GROWING)
    window = window_of(loop)
    fit = fit_window(
        window, GROWTH_CHANGE, KNOWN, unknowns_with(window, predicted), 1e-9, NoiseLevels(1e-9)
    )
    times = window.knots[3:-3]
    true = loop.gaps[np.rint(times * RATE).astype(int)]
    assert np.rad2deg(fit.unknowns.gaps[3:-3] - true) == pytest.approx(0.0, abs=0.02)


def test_a_prediction_that_describes_the_data_is_followed(closed_loop, simulated):
    window = window_of(closed_loop(12.0))
    first = fit_window(window, GROWTH_CHANGE, KNOWN)
    simulated.clear()
    fit = fit_window(
        window, GROWTH_CHANGE, KNOWN, first.unknowns, first.prediction_error, first.levels
    )
    assert list(simulated) == [RATE]
    assert len(simulated[RATE]) < 12
    assert fit.prediction_error <= 1.05 * first.prediction_error


def test_another_prediction_is_tried_where_the_first_leaves_the_newest_data_unexplained(
    closed_loop, monkeypatch
):
    """A gap of the last second that is far off is enough for a fit that is easily content."""
    window = window_of(closed_loop(12.0))
    found = fit_window(window, GROWTH_CHANGE, KNOWN)
    gaps = found.unknowns.gaps.copy()
    gaps[-2:] = math.radians(60.0)
    wrong = replace(found.unknowns, gaps=gaps)
    begun = []
    solve = WindowFit.solve
    monkeypatch.setattr(
        WindowFit, "solve", lambda fit, first, *most, **how: begun.append(first) or stay(first)
    )
    stay = partial(solve, WindowFit(window, GROWTH_CHANGE, KNOWN), steps=0, simulations=1)
    content = 1.0, NoiseLevels(1e-7)
    fit = fit_window(window, GROWTH_CHANGE, KNOWN, wrong, *content, found.unknowns)
    assert begun == [wrong, found.unknowns]
    assert fit.unknowns is found.unknowns
    begun.clear()
    fit_window(window, GROWTH_CHANGE, KNOWN, found.unknowns, *content, wrong)
    assert begun == [found.unknowns]


def test_a_motor_that_walks_may_be_anywhere_in_its_gap(closed_loop, monkeypatch):
    """A window begins with a guess of the last fit, which is not better than the middle."""
    window = window_of(closed_loop(12.0), begin=3100)
    found = fit_window(window, GROWTH_CHANGE, KNOWN)
    initial_conditions = found.unknowns.initial_conditions.copy()
    initial_conditions[:, 0] = -found.unknowns.initial_conditions[:, 0]
    wrong = replace(found.unknowns, initial_conditions=initial_conditions)
    shares = []
    solve = WindowFit.solve

    def solved(fit, first, *most, **how):
        shares.append(float(first.initial_conditions[0, 0]))
        return solve(fit, first, *most, **how)

    monkeypatch.setattr(WindowFit, "solve", solved)
    walks = NoiseLevels(reading=1e-9, slow=1e-5)
    as_good, worse = 2.0 * found.prediction_error, 0.8 * found.prediction_error
    fit_window(window, GROWTH_CHANGE, KNOWN, wrong, as_good, walks)
    assert shares == [wrong.initial_conditions[0, 0]]
    shares.clear()
    fit_window(window, GROWTH_CHANGE, KNOWN, wrong, worse, walks)
    assert shares == [*2 * [wrong.initial_conditions[0, 0]], 0.0]


@pytest.mark.parametrize(
    ("walk", "friction", "cogs", "begins"),
    [
        (0.2, 0.0, 0, [0.0]),
        (1.0, 0.0, 0, [1.0, 1.0 / 12.0]),
        (1.0, 0.1, 0, [1.0]),
        (1.0, 0.0, 24, [1.0]),
    ],
    ids=["slight", "neither slight nor large", "of friction", "of cogging"],
)
def test_a_walk_without_a_reason_is_tried_and_a_quieter_one_besides(
    closed_loop, monkeypatch, walk, friction, cogs, begins
):
    window = window_of(closed_loop(12.0), begin=3100).with_cogs(cogs)
    found = fit_window(window, GROWTH_CHANGE, KNOWN)
    effects = found.unknowns.effects.copy()
    effects[EFFECTS.index("friction_voltage")] = friction
    ratios, fits = [], []
    solve = WindowFit.solve

    def solved(fit, *most, levels, **how):
        ratios.append(levels.slow / levels.reading)
        fits.append(solve(fit, *most, levels=levels, **how))
        return fits[-1]

    monkeypatch.setattr(WindowFit, "solve", solved)
    begun = replace(found.unknowns, effects=effects)
    walks = NoiseLevels(reading=1e-6, slow=walk * 1e-6)
    fit = fit_window(window, GROWTH_CHANGE, KNOWN, begun, 1.0, walks)
    assert ratios == pytest.approx(begins)
    assert fit.prediction_error == min(each.prediction_error for each in fits)
    assert fit.simulated == sum(each.simulated for each in fits)


def test_a_slight_walk_of_the_window_before_does_not_keep_a_wrong_beginning(closed_loop):
    """It explains a screw that is off by a third of the readings' noise from its first motion."""
    loop = closed_loop(12.0)
    rows = loop.rows.copy()
    rows[:, 2] += np.random.default_rng(2).normal(scale=5e-6, size=len(rows))
    window = window_of(loop._replace(rows=rows))
    found = fit_window(window, GROWTH_CHANGE, KNOWN)
    initial_conditions = found.unknowns.initial_conditions.copy()
    initial_conditions[:, INITIAL_CONDITION.index("share")] += 0.05
    wrong = replace(found.unknowns, initial_conditions=initial_conditions)
    error = found.prediction_error
    walks = NoiseLevels(error, 0.2 * error, 0.2 * error, 0.0)
    fit = fit_window(window, GROWTH_CHANGE, KNOWN, wrong, error, walks)
    assert not any(fit.levels[1:])
    assert fit.prediction_error <= 1.01 * error


@pytest.mark.parametrize(("wrong", "fits"), [(None, 1), (60.0, 2)])
def test_the_work_of_a_window_is_limited(closed_loop, simulated, monkeypatch, wrong, fits):
    """A position that no model explains makes every fit go on as long as it may."""
    for most in ("MOST_SAMPLES", "MOST_FOLLOWING"):
        monkeypatch.setattr(window_search, most, 12000)
    window = window_of(closed_loop(15.0))
    walk = np.cumsum(np.random.default_rng(1).normal(scale=1e-6, size=12000))
    stretch = window.stretches[0]
    spoiled = WindowModel(
        PlantModel(),
        [stretch._replace(position=stretch.position + walk)],
        window.knots,
        RATE,
        BLOCK,
    )
    predicted = None if wrong is None else unknowns_with(window, wrong)
    fit = fit_window(spoiled, GROWTH_CHANGE, KNOWN, predicted, 1e-9, NoiseLevels(1e-9))
    assert len(simulated[RATE]) <= fits * FEWEST_SIMULATIONS
    assert fit.simulated == sum(map(sum, simulated.values()))
    # All initial_conditions together are tried with fewer samples than a single fit has.
    assert sum(simulated[500]) < MOST_SAMPLES


def test_a_fit_that_is_wrong_after_its_patience_ends(closed_loop):
    window = window_of(closed_loop(15.0))
    problem, first = WindowFit(window, GROWTH_CHANGE, KNOWN), unknowns_with(window, 60.0)
    levels = NoiseLevels(1e-6)
    patient = problem.solve(first, 10, 100, levels=levels)
    ended = problem.solve(first, 10, 100, levels=levels, patience=2, enough=0.0)
    assert ended.simulated <= (2 + HALVINGS) * window.samples < patient.simulated
    same = problem.solve(first, 10, 100, levels=levels, patience=2, enough=1.0)
    assert same.prediction_error == patient.prediction_error


def test_a_coarse_copy_is_the_same_mechanism(closed_loop):
    """Positions of the copy are those of the window in the middle of the samples it averages."""
    window = window_of(closed_loop(GROWING, rate=5000.0), 12503, 52503, 5000.0, 25)
    coarse = window.coarse(1000.0, 50.0)
    unknowns = unknowns_with(window, 10.0)
    fine, rough = window.simulate(unknowns)[0].position, coarse.simulate(unknowns)[0].position
    assert coarse.block == 20
    assert rough.size % 20 == 0
    middles = np.rint(5 * coarse.stretches[0].first - 12503 + 5 * np.arange(rough.size)).astype(int)
    kept = fine[middles]
    measured = window.stretches[0].position[middles]
    assert coarse.stretches[0].position == pytest.approx(measured, abs=1e-6)
    # Contact is found a sample of the copy late at most.
    assert np.abs(rough - kept).max() < 0.02 * np.ptp(kept)


def test_a_coarse_copy_of_coarse_data_keeps_all_samples(closed_loop):
    window = window_of(closed_loop(12.0, rate=500.0), 0, 6000, 500.0, 2)
    coarse = window.coarse(1000.0, 50.0)
    assert (coarse.stretches[0].voltage == window.stretches[0].voltage).all()
    assert coarse.block == 10
