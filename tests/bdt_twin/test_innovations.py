"""Innovations against dense linear algebra of a whole window, pushes and all."""

import math

import numpy as np
import pytest
from machine_noise import (
    BLOCK_TIME,
    LEVELS,
    STEP,
    moving,
    positions_after,
    random_motion,
    simulated,
    walk_of,
    whitening,
)

from bdt_plant import compilation
from bdt_twin import innovation_filter
from bdt_twin.innovation_filter import LARGEST_PUSH
from bdt_twin.innovations import NoiseLevels
from bdt_twin.robust_sums import mean_logarithm


def dense_covariance(motion, levels, pushed=()):
    """Return G Q G^T + R, each column of G the answer to one noise by itself."""
    count = motion.contact.size
    walk, none = walk_of(motion, levels), np.zeros((count, 2))
    covariance = levels.reading**2 * np.eye(count)
    for block in range(1, count):
        unit = np.zeros(count)
        unit[block] = math.sqrt(walk[block])
        column = positions_after(motion, unit, none)
        covariance += np.outer(column, column)
        for platform in range(2):
            kick = none.copy()
            kick[block, platform] = levels.force * math.sqrt(BLOCK_TIME)
            column = positions_after(motion, np.zeros(count), none, kick)
            covariance += np.outer(column, column)
            if block in pushed:
                kick[block, platform] = LARGEST_PUSH
                column = positions_after(motion, np.zeros(count), kick)
                covariance += np.outer(column, column)
    return covariance


@pytest.mark.parametrize("seed", range(3))
def test_innovations_are_those_of_the_cholesky_factor_of_the_whole_window(seed):
    motion = random_motion(60, seed)
    rows = np.random.default_rng(seed).normal(scale=1e-5, size=(4, 60))
    made = whitening([motion], LEVELS, rows[0])
    factor = np.linalg.cholesky(dense_covariance(motion, LEVELS))
    assert made.deviations == pytest.approx(np.diag(factor), rel=1e-7)
    assert made.apply(rows) == pytest.approx(np.linalg.solve(factor, rows.T).T, rel=1e-6, abs=1e-6)
    assert not made.pushed.any()


def test_they_tell_the_likelihood_of_the_window():
    motion = random_motion(93)
    residual = simulated(motion, LEVELS, 1)
    made = whitening([motion], LEVELS, residual)
    covariance = dense_covariance(motion, LEVELS)
    sign, determinant = np.linalg.slogdet(covariance)
    assert sign > 0
    assert mean_logarithm(made.deviations) == pytest.approx(0.5 * determinant / 93, abs=1e-7)
    squares = np.square(made.apply(residual[None, :])).sum()
    assert squares == pytest.approx(residual @ np.linalg.solve(covariance, residual), rel=1e-6)


def test_a_motor_that_walks_without_contact_moves_nothing():
    levels = LEVELS._replace(force=0.0)
    made = whitening([moving(50, contact=0.0)], levels, np.zeros(50))
    assert (made.deviations == levels.reading).all()


def test_what_the_motor_has_walked_by_the_first_contact_reaches_the_screw_at_once():
    contact = np.zeros(60)
    contact[40] = 1.0
    levels = LEVELS._replace(force=0.0)
    made = whitening([moving(60)._replace(contact=contact)], levels, np.zeros(60))
    assert (made.deviations[:40] == levels.reading).all()
    moved = STEP.q3[5] * levels.fast * math.sqrt(40 * BLOCK_TIME)
    assert made.deviations[40] == pytest.approx(math.hypot(levels.reading, moved), rel=1e-9)
    # The structure follows in its own time.
    assert made.deviations[41:].max() > 1.3 * levels.reading


def test_without_noise_of_the_machine_the_innovations_are_the_residual():
    residual = np.random.default_rng(3).normal(size=40)
    made = whitening([moving(40)], NoiseLevels(2e-6), residual)
    assert made.apply(residual[None, :])[0] == pytest.approx(residual / 2e-6, rel=1e-12)


def test_innovations_of_a_machine_with_that_noise_are_white_and_have_variance_one():
    motion = random_motion(6000, 5)
    residual = simulated(motion, LEVELS, 5)
    found = whitening([motion], LEVELS, residual).apply(residual[None, :])[0]
    # Five standard deviations of an estimate from so many.
    assert np.mean(found**2) == pytest.approx(1.0, abs=5 * math.sqrt(2 / found.size))
    for lag in (1, 2, 5, 30):
        assert abs(np.mean(found[lag:] * found[:-lag])) < 5 / math.sqrt(found.size)
    # The residual itself is anything but white.
    assert np.corrcoef(residual[1:], residual[:-1])[0, 1] > 0.9


def test_two_stretches_do_not_talk_to_each_other():
    motions = [random_motion(70, 1), random_motion(50, 2)]
    residual = np.random.default_rng(0).normal(scale=1e-5, size=(1, 120))
    together = whitening(motions, LEVELS, residual[0])
    parts = np.split(residual, [70], axis=1)
    alone = [
        whitening([motion], LEVELS, part[0]) for motion, part in zip(motions, parts, strict=True)
    ]
    deviations = np.concatenate([made.deviations for made in alone])
    found = [made.apply(part) for made, part in zip(alone, parts, strict=True)]
    assert (together.deviations == deviations).all()
    assert (together.apply(residual) == np.concatenate(found, axis=1)).all()


def kicked(motion, at, velocity, seed=4):
    """Return a residual without and with a push of the top platform before a block."""
    calm = simulated(motion, LEVELS, seed)
    kicks = np.zeros((calm.size, 2))
    kicks[at, 1] = velocity
    return calm, calm + positions_after(motion, np.zeros(calm.size), kicks)


def test_a_push_is_found_where_it_is_and_nothing_else_is_one():
    calm, residual = kicked(random_motion(600, 4), 300, 0.05)
    made = whitening([random_motion(600, 4)], LEVELS, residual, 6.0)
    assert set(np.flatnonzero(made.pushed)) <= {300, 301}
    assert made.pushed.any()
    assert not whitening([random_motion(600, 4)], LEVELS, calm, 6.0).pushed.any()


def test_with_a_push_the_innovations_are_still_those_of_the_dense_covariance():
    motion = random_motion(120, 4)
    _, residual = kicked(motion, 60, 0.05)
    made = whitening([motion], LEVELS, residual, 6.0)
    covariance = dense_covariance(motion, LEVELS, set(np.flatnonzero(made.pushed)))
    factor = np.linalg.cholesky(covariance)
    assert made.deviations == pytest.approx(np.diag(factor), rel=1e-5)
    expected = np.linalg.solve(factor, residual)
    assert made.apply(residual[None, :])[0] == pytest.approx(expected, rel=1e-3, abs=1e-3)


def test_a_push_does_no_harm_to_what_comes_after_it():
    motion = random_motion(600, 4)
    calm, residual = kicked(motion, 300, 0.05)
    made = whitening([motion], LEVELS, residual, 6.0)
    difference = made.apply(residual[None, :])[0] - made.apply(calm[None, :])[0]
    assert np.abs(difference[:300]).max() == 0.0
    assert np.abs(difference[310:]).max() < 0.1
    blind = whitening([motion], LEVELS, residual)
    assert np.abs(blind.apply(residual[None, :])[0][310:]).max() > 20.0
    # Nor is the filter less sure then than it would have been.
    assert made.deviations[340:] == pytest.approx(blind.deviations[340:], rel=0.02)


def test_without_numba_the_floats_are_the_same(monkeypatch):
    motions = [random_motion(60, 1), random_motion(40, 2)]
    residual = kicked(random_motion(100, 4), 50, 0.05)[1]

    def found():
        innovation_filter.compiled_gains.cache_clear()
        innovation_filter.compiled_innovations.cache_clear()
        made = whitening(motions, LEVELS, residual, 6.0)
        assert made.pushed.any()
        return np.concatenate([made.deviations, made.pushed, made.apply(residual[None, :])[0]])

    compiled = found()
    with monkeypatch.context() as patch:
        patch.setattr(compilation, "find_spec", lambda _: None)
        plain = found()
    innovation_filter.compiled_gains.cache_clear()
    innovation_filter.compiled_innovations.cache_clear()
    assert (plain == compiled).all()
