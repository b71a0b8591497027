"""Mechanisms drawn from what the twin knows."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_plant.plant import PlantModel, discretize_plant
from bdt_plant.quick_exponential import quick_exponential
from bdt_twin import mechanism_ensemble
from bdt_twin.decision_loop import HOLD
from bdt_twin.estimator import Estimate
from bdt_twin.machine_knowledge import EFFECTS, TOP_MASS, first_knowledge
from bdt_twin.mechanism_ensemble import MechanismEnsemble
from bdt_twin.model_factors import FACTORS

MODEL = PlantModel()
RATE = 500.0
ESTIMATE = Estimate(10.0, 0.2, 0.01, 0.002, 0.0005)
KNOWN = first_knowledge(MODEL.motor)


def ensemble(members):
    return MechanismEnsemble(MODEL, members, RATE, 1)


def test_the_first_mechanism_is_the_expected_one():
    first, *_ = ensemble(5).draw(ESTIMATE, None, 12.0, 14.0)
    assert first.plant == discretize_plant(MODEL, 1.0 / (HOLD * RATE), quick_exponential)
    assert first.gap == pytest.approx(0.2 + 0.002 * 4.0)
    assert (first.disturbance, first.lag) == (0.0, 0)


def test_the_gain_that_an_estimator_corrects_is_that_of_the_mechanism():
    corrected = ESTIMATE._replace(gain_correction=1.05)
    (found,) = ensemble(1).draw(corrected, None, 12.0, 14.0)
    faster = replace(MODEL, motor=replace(MODEL.motor, back_emf_constant=0.1 / 1.05))
    expected = discretize_plant(faster, 1.0 / (HOLD * RATE))
    assert np.array(found.plant.motor).ravel() == pytest.approx(
        np.array(expected.motor).ravel(), rel=1e-9
    )


def test_gaps_have_the_uncertainty_that_the_estimate_states():
    gaps = [one.gap for one in ensemble(100).draw(ESTIMATE, None, 10.0, 10.0)]
    assert np.mean(gaps) == pytest.approx(0.2, abs=0.004)
    assert np.std(gaps) == pytest.approx(0.01, rel=0.25)


def test_an_estimator_that_does_not_know_how_sure_it_is_gives_one_gap():
    unsure = ESTIMATE._replace(uncertainty=math.nan, growth=0.0, growth_uncertainty=0.0)
    assert {one.gap for one in ensemble(8).draw(unsure, None, 10.0, 12.0)} == {0.2}


def test_no_gap_is_negative():
    small = ESTIMATE._replace(gap=0.001, uncertainty=0.1)
    assert min(one.gap for one in ensemble(100).draw(small, None, 10.0, 10.0)) == 0.0


def test_constants_have_the_covariance_of_the_posterior(monkeypatch):
    monkeypatch.setattr(mechanism_ensemble, "discretize_plant", lambda model, *_: model)
    spread = np.zeros(len(FACTORS) + len(EFFECTS))
    places = [*range(len(FACTORS)), len(FACTORS) + TOP_MASS]
    spread[places] = 0.01, 0.02, 0.1, 0.05
    knowledge = KNOWN._replace(covariance=np.diag(spread**2))
    models = [one.plant for one in ensemble(100).draw(ESTIMATE, knowledge, 10.0, 10.0)]
    constants = np.log(
        [
            (
                one.motor.back_emf_constant,
                one.structure.stiffness,
                one.structure.damping,
                one.structure.top_mass_ratio,
            )
            for one in models
        ]
    )
    assert constants.std(axis=0) == pytest.approx(spread[places], rel=0.25)
    assert {one.structure.mass for one in models} == {MODEL.structure.mass}


def test_a_payload_is_drawn_as_heavy_as_it_may_be(monkeypatch):
    monkeypatch.setattr(mechanism_ensemble, "discretize_plant", lambda model, *_: model)
    expected = KNOWN.expected.copy()
    expected[len(FACTORS) + TOP_MASS] = math.log(2.9)
    knowledge = KNOWN._replace(expected=expected)
    models = [one.plant for one in ensemble(20).draw(ESTIMATE, knowledge, 10.0, 10.0)]
    ratios = [one.structure.top_mass_ratio for one in models]
    assert ratios[0] == pytest.approx(2.9)
    assert max(ratios) == pytest.approx(3.0)


def test_constants_that_are_tied_together_are_drawn_together():
    covariance = np.zeros((len(FACTORS) + len(EFFECTS),) * 2)
    offset = len(FACTORS) + EFFECTS.index("voltage_offset")
    friction = len(FACTORS) + EFFECTS.index("friction_voltage")
    covariance[np.ix_([friction, offset], [friction, offset])] = [[4e-4, 2e-4], [2e-4, 1e-4]]
    expected = KNOWN.expected.copy()
    expected[friction] = 0.5
    members = ensemble(50).draw(
        ESTIMATE, KNOWN._replace(expected=expected, covariance=covariance), 10.0, 10.0
    )
    offsets = np.array([one.disturbance for one in members])
    frictions = np.array([one.plant.friction.current for one in members]) * MODEL.motor.resistance
    assert np.std(offsets) == pytest.approx(0.01, rel=0.3)
    np.testing.assert_allclose(frictions - 0.5, 2.0 * offsets, atol=1e-6)


@pytest.mark.parametrize("late", [{"delay": 4e-3}, {"voltage_lag": 4e-3}])
def test_a_loop_is_late_by_its_voltage_as_by_its_reading(late):
    expected = KNOWN.expected.copy()
    for name, time in late.items():
        expected[len(FACTORS) + EFFECTS.index(name)] = time
    (member,) = ensemble(1).draw(ESTIMATE, KNOWN._replace(expected=expected), 10.0, 10.0)
    assert member.lag == round(4e-3 * HOLD * RATE)


def test_the_same_seed_draws_the_same_mechanisms():
    first, again = (ensemble(5).draw(ESTIMATE, KNOWN, 12.0, 14.0) for _ in range(2))
    assert first == again
