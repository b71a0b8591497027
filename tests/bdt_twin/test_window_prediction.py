"""What a window begins with: the state that the last window's simulation had at that time."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_plant.plant import PlantModel
from bdt_plant.pushes import PushParameters
from bdt_twin.machine_knowledge import first_knowledge
from bdt_twin.noise_levels import NoiseLevels
from bdt_twin.stretch import Stretch
from bdt_twin.unknowns import INITIAL_CONDITION
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor, predicted_unknowns, without_growth
from bdt_twin.window_search import fit_window, initial_conditions_at_rest

RATE, BLOCK = 5000.0, 25
MODEL, GAP = PlantModel(), math.radians(12.0)
SHARE, OFFSET = map(INITIAL_CONDITION.index, ("share", "offset"))


def window_of(loop, begin, end, every):
    """Return the window between two times [s], simulated in steps of several samples."""
    rows = loop.rows[round(begin * RATE) : round(end * RATE), 1:]
    before = loop.rows[round(begin * RATE) - 50 : round(begin * RATE), 1] if begin else np.empty(0)
    stretch = Stretch(begin * RATE, *np.ascontiguousarray(rows.T), before)
    averaged = stretch.averaged(every, BLOCK // every)
    knots = np.arange(math.floor(begin), math.ceil(end) + 1.0)
    return WindowModel(MODEL, [averaged], knots, RATE / every, BLOCK // every)


@pytest.fixture
def last(closed_loop):
    """Make the window from 0 to 9 s, fitted in steps of so many samples, and its loop."""

    def fitted(every, growth=0.0, model=MODEL):
        loop = closed_loop(12.0, duration=12.0, rate=RATE, model=model)
        window = window_of(loop, 0.0, 9.0, every)
        fit = fit_window(window, math.radians(0.02), first_knowledge(MODEL.motor))
        return loop, Predecessor(window, fit, growth)

    return fitted


@pytest.mark.parametrize("before", [1, 5])
@pytest.mark.parametrize("every", [1, 5])
def test_the_mechanism_is_where_it_was_whatever_the_rates_of_both_windows(last, before, every):
    loop, predecessor = last(before)
    # In the middle of a step of the reference, where all is in motion.
    window = window_of(loop, 3.02, 12.0, every)
    (run,) = window.simulate(predicted_unknowns(window, predecessor))
    off = run.position - window.stretches[0].position
    assert np.abs(window.stretches[0].position).max() > 4e-3
    assert np.abs(off).max() < (2e-7 if before == every == 1 else 2e-5)


@pytest.mark.parametrize("begin", [3.02, 3.5])
def test_a_screw_is_where_it_was_even_if_a_platform_was_pushed(last, begin):
    loop, predecessor = last(1, model=replace(MODEL, pushes=PushParameters(2.0, period=3.0)))
    predicted = predicted_unknowns(window_of(loop, begin, 12.0, 1), predecessor)
    screw = MODEL.lead_screw.pitch * loop.theta_d[round(begin * RATE)]
    assert predicted.initial_conditions[0, OFFSET] == pytest.approx(screw, abs=1e-5)


def test_of_a_motor_that_walks_only_its_place_in_the_gap_is_predicted(last):
    loop, predecessor = last(1)
    # Within the reversal after a step, when the motor crosses the gap.
    window = window_of(loop, 3.02, 12.0, 1)
    told = predicted_unknowns(window, predecessor).initial_conditions
    walks = NoiseLevels(reading=1e-7, slow=1e-5)
    walking = predecessor._replace(fit=replace(predecessor.fit, levels=walks))
    predicted = predicted_unknowns(window, walking).initial_conditions
    rests = initial_conditions_at_rest(window)
    assert told[0, SHARE] != rests[0, SHARE]
    assert predicted[0, SHARE] == told[0, SHARE]
    assert (np.delete(predicted, SHARE, axis=1) == np.delete(rests, SHARE, axis=1)).all()


def test_gaps_grow_on_or_stay_as_they_were_at_the_last_reversal(last):
    loop, predecessor = last(1, growth=0.01)
    window = window_of(loop, 3.0, 12.0, 1)
    predicted = predicted_unknowns(window, predecessor)
    assert predicted.gaps == pytest.approx(GAP + 0.01 * np.maximum(window.knots - 9.0, 0), rel=2e-3)
    stays = without_growth(window, predecessor, predicted)
    assert stays.gaps == pytest.approx(GAP, rel=2e-3)
