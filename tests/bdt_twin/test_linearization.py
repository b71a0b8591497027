"""What a fit's end tells is worked out once somebody asks, and is what quadratic problems have."""

import numpy as np
import pytest

from bdt_twin.linearization import Linearization, Slopes
from bdt_twin.machine_knowledge import EFFECT_SPREAD, EFFECTS

GAPS = 3
COUNT = GAPS + len(EFFECTS)
HELD = 1e9
"""Inverse variance of an effect that a machine is thought not to have, over that of one it may."""


def slopes(seed=0):
    """Return the problem of a window that tells of gaps and effects, all effects held."""
    generator = np.random.default_rng(seed)
    scale = np.concatenate([np.full(GAPS, 1e-2), EFFECT_SPREAD])
    seen = generator.normal(size=(COUNT, 2 * COUNT)) / scale[:, None]
    prior = np.diag(np.concatenate([np.full(GAPS, 1e2), HELD / np.square(EFFECT_SPREAD)]))
    return Slopes(seen @ seen.T, prior, seen @ generator.normal(size=2 * COUNT))


def gain(information, gradient):
    """Return the largest log-likelihood of a quadratic problem beside that at the beginning."""
    return 0.5 * gradient @ np.linalg.solve(information, gradient)


def test_nobody_waits_for_what_nobody_asks():
    asked = []

    def work_out():
        asked.append(True)
        return slopes()

    around = Linearization(work_out, GAPS)
    assert not asked
    for _ in range(2):
        assert around.covariance.shape == around.slopes.told.shape
        assert around.pending.shape == (COUNT,)
        assert around.evidence.shape == (len(EFFECTS),)
    assert len(asked) == 1


def test_covariance_and_step_are_those_of_data_and_prior():
    known = slopes()
    around, information = Linearization(slopes, GAPS), known.told + known.prior
    scale = np.sqrt(np.diag(information))
    identity = around.covariance @ information
    assert identity * np.outer(scale, 1 / scale) == pytest.approx(np.eye(COUNT), abs=1e-8)
    step = around.pending * scale
    assert step == pytest.approx(np.linalg.solve(information, known.gradient) * scale, abs=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_evidence_is_what_an_effect_gains_once_it_may_be_there(seed):
    told, prior, gradient = known = slopes(seed)
    found = Linearization(lambda: known, GAPS).evidence
    without = gain(told + prior, gradient)
    for effect, spread in enumerate(EFFECT_SPREAD):
        free = prior.copy()
        free[GAPS + effect, GAPS + effect] = 1.0 / spread**2
        expected = gain(told + free, gradient) - without
        assert found[effect] == pytest.approx(expected, rel=1e-3, abs=1e-6)


def test_another_covariance_changes_nothing_else():
    around = Linearization(slopes, GAPS)
    other = around.with_covariance(2.0 * around.covariance)
    assert np.array_equal(other.covariance, 2.0 * around.covariance)
    assert other.slopes is around.slopes
    assert np.array_equal(other.pending, around.pending)
    assert np.array_equal(other.evidence, around.evidence)
