"""The compiled recursion against two passes of scipy's lfilter, bit for bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from bdt_twin.iir_filters import AT_REST, coefficients, compiled_filters, filter_motor_and_screw

REST, PITCH = 0.25, 0.125
FEW = 50
"""Samples after which even an unstable filter has not overflowed."""

numbers = st.floats(-2.0, 2.0)
first = st.floats(0.5, 2.0)


def filters(above, below):
    """Return filters as numerator and denominator, the first coefficient below not zero."""
    top = st.lists(numbers, min_size=above, max_size=above)
    bottom = st.tuples(first, *[numbers] * (below - 1))
    return st.tuples(top.map(np.array), bottom.map(np.array))


def run(recursion, motor, inverse, voltage, position, cuts=()):
    """Return both angles of data that a recursion is given in batches that end at `cuts`."""
    memory, batches = AT_REST, []
    arguments = (REST, PITCH, coefficients(*motor), coefficients(*inverse))
    for u, q3 in zip(np.split(voltage, cuts), np.split(position, cuts), strict=True):
        angles = np.empty(u.size), np.empty(u.size)
        memory = recursion(u, q3, *arguments, memory, *angles)
        batches.append(angles)
    return tuple(map(np.concatenate, zip(*batches, strict=True)))


@pytest.mark.parametrize("recursion", [compiled_filters(), filter_motor_and_screw])
@given(filters(4, 4), filters(5, 3), st.integers(0, 2**32 - 1))
def test_the_angles_are_those_of_two_lfilter_passes_bit_for_bit(recursion, motor, inverse, seed):
    voltage, position = np.random.default_rng(seed).uniform(-12, 12, (2, FEW))
    theta_m, theta_d = run(recursion, motor, inverse, voltage, position)
    assert (theta_m == lfilter(*motor, voltage)).all()
    assert (theta_d == (lfilter(*inverse, position - REST) + REST) / PITCH).all()


@given(filters(4, 4), filters(5, 3), st.lists(st.integers(0, FEW), max_size=6))
def test_any_split_into_batches_gives_the_same_angles_bit_for_bit(motor, inverse, cuts):
    voltage, position = np.random.default_rng(5).uniform(-12, 12, (2, FEW))
    recursion = compiled_filters()
    whole = run(recursion, motor, inverse, voltage, position)
    split = run(recursion, motor, inverse, voltage, position, sorted(cuts))
    for one, other in zip(whole, split, strict=True):
        assert one.tobytes() == other.tobytes()


def test_the_coefficients_are_those_of_the_same_filter_with_a_leading_one():
    above, below = coefficients(np.array([2.0, 3.0]), np.array([4.0, 2.0]))
    assert (above, below) == ((0.5, 0.75), (1.0, 0.5))
