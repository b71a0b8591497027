"""Structures side by side move as the plant's own one does, each for itself."""

from functools import reduce
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.signal import cont2discrete, dlsim

from bdt_plant import compilation
from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    discretize_structure,
    structure_state_space,
    structure_step,
)
from bdt_twin.structure_responses import compiled_responses, structure_after, structure_responses

STEP = discretize_structure(StructureParameters(), 0.005)
SOFT = discretize_structure(StructureParameters(stiffness=500.0), 0.005)
LENGTHS = st.floats(-1e-2, 1e-2)


def states_one_by_one(step, state, base):
    """Return the states by the plant's step, the first one included."""
    states = [state]
    for before, after in pairwise(base):
        states.append(structure_step(states[-1], float(before), float(after), step))
    return states


def drawn(instants, count):
    return np.random.default_rng(1).standard_normal((instants, count)) * 1e-3


def test_each_is_the_plant_s_own_structure_to_the_last_bit():
    bases = drawn(300, 7)
    found = structure_responses(STEP, bases)
    at_rest = StructureState(0.0, 0.0, 0.0, 0.0)
    for base, position in zip(bases.T, found.T, strict=True):
        assert [state.q3 for state in states_one_by_one(STEP, at_rest, base)] == position.tolist()


@given(arrays(np.float64, (20, 3), elements=LENGTHS), arrays(np.float64, (3, 4), elements=LENGTHS))
def test_each_has_its_own_beginning_and_its_own_constants(bases, states):
    steps = [STEP, SOFT, STEP]
    found = structure_responses(np.array(steps), bases, states)
    for step, base, state, position in zip(steps, bases.T, states, found.T, strict=True):
        alone = states_one_by_one(step, StructureState(*state.tolist()), base)
        assert [one.q3 for one in alone] == position.tolist()


def test_the_state_after_a_base_is_that_of_the_last_instant():
    base, state = drawn(50, 1)[:, 0], StructureState(1e-3, -2e-2, 3e-3, 1e-2)
    assert structure_after(STEP, state, base) == states_one_by_one(STEP, state, base)[-1]


def test_it_is_what_scipy_simulates_for_a_base_that_is_linear_between_the_instants():
    """Foh with the base's velocity as another input: both are linear, or constant, in between."""
    a, b = structure_state_space(StructureParameters())
    augmented = np.zeros((5, 5))
    augmented[:4, :4], augmented[:4, 4] = a, b[:, 0]
    inputs = np.vstack([b[:, 1:], [[1.0]]])
    model = cont2discrete((augmented, inputs, np.eye(5), np.zeros((5, 1))), 0.005, method="zoh")
    base = np.cumsum(drawn(400, 1)[:, 0]) * 0.1
    base -= base[0]
    velocity = np.append(np.diff(base), 0.0) / 0.005
    _, _, states = dlsim(model, velocity)
    position = structure_responses(STEP, base[:, None])[:, 0]
    assert position == pytest.approx(states[:, 2], rel=1e-9, abs=1e-15)


def test_a_structure_follows_a_base_that_stays():
    position = structure_responses(STEP, np.full((4000, 1), 1e-3))[:, 0]
    assert position[0] == 0.0
    assert position[-1] == pytest.approx(1e-3, rel=1e-9)


def test_what_is_given_is_left_as_it_is():
    bases, states = drawn(30, 2), drawn(2, 4)
    before = bases.copy(), states.copy()
    structure_responses(STEP, bases, states)
    assert reduce(np.logical_and, map(np.array_equal, before, (bases, states)))


def test_without_numba_the_floats_are_the_same(monkeypatch):
    bases, states = drawn(40, 3), drawn(3, 4)
    compiled = structure_responses(STEP, bases, states)
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    compiled_responses.cache_clear()
    try:
        plain = structure_responses(STEP, bases, states)
    finally:
        compiled_responses.cache_clear()
    assert np.array_equal(compiled, plain)
