"""What an error of the screw's thread does to the position, against simulations."""

import math

import numpy as np
import pytest
from scipy.signal import lsim

from bdt_plant.structure import StructureParameters, discretize_structure, structure_state_space
from bdt_twin.thread_error import thread_response, thread_waves

BLOCK_TIME, BLOCK = 4e-3, 4
TIMES = np.arange(500) * BLOCK_TIME
SCREW = 8.0 * np.sin(1.5 * TIMES)
TURNS = 2.3


def test_a_part_moves_the_screw_by_what_it_has_changed_since_the_beginning():
    waves = thread_waves(SCREW, TURNS)
    first = 2.0 * math.pi * TURNS
    assert waves[:, 0] == pytest.approx(np.sin(first + SCREW) - math.sin(first), abs=1e-5)
    assert waves[:, 1] == pytest.approx(np.cos(first + SCREW) - math.cos(first), abs=1e-5)
    assert waves[0] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_the_platform_follows_it_as_the_structure_does():
    structure, sizes = StructureParameters(), np.array([3e-6, -2e-6])
    a, b = structure_state_space(structure)
    base = thread_waves(SCREW, TURNS) @ sizes
    inputs = np.stack([base, np.gradient(base, TIMES)], axis=1)
    _, expected, _ = lsim((a, b, np.array([[0, 0, 1, 0]]), np.zeros((1, 2))), inputs, TIMES)
    step = np.array(discretize_structure(structure, BLOCK_TIME))
    found = thread_response(step, SCREW, TURNS, sizes, BLOCK)
    assert found.shape == (TIMES.size * BLOCK,)
    assert (found.reshape(-1, BLOCK) == found[::BLOCK, None]).all()
    assert found[::BLOCK] == pytest.approx(expected, abs=1e-8)
