"""The tabulated wave of the cogging is a sine and a cosine."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.cog_wave import VALUES_PER_TURN, cog_wave

OFF = (2.0 * math.pi / VALUES_PER_TURN) ** 2 / 8.0
"""What a straight line between two values of a sine is off by at most."""


@given(st.floats(-1e4, 1e4))
def test_it_is_sine_and_cosine(turns):
    sine, cosine = cog_wave(turns)
    assert sine == pytest.approx(math.sin(2.0 * math.pi * turns), abs=OFF + 1e-10)
    assert cosine == pytest.approx(math.cos(2.0 * math.pi * turns), abs=OFF + 1e-10)


@pytest.mark.parametrize("turns", [0.0, -1e-300, -1e-17, math.nextafter(1.0, 0.0), 1.0, -3.0])
def test_it_has_a_value_at_the_ends_of_its_table(turns):
    assert cog_wave(turns) == pytest.approx((0.0, 1.0), abs=1e-12)
