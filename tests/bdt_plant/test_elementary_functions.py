"""Exponential function, logarithm, power and sine against decimal arithmetic in many digits."""

import math
from decimal import Context, Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.elementary_functions import (
    decaying_exponential,
    exponential,
    float_exponential,
    float_logarithm,
    logarithm,
    power,
    sine_of_turns,
)

DIGITS = Context(prec=50)


@given(st.floats(-740.0, 709.0))
def test_the_exponential_function_is_right_to_two_units_in_the_last_place(number):
    exact = DIGITS.exp(Decimal(number))
    error = abs(Decimal(float(exponential(number))) - exact)
    assert error <= 2 * Decimal(math.ulp(float(exact)))


@given(st.floats(1e-300, 1e300) | st.floats(0.9, 1.1))
def test_the_logarithm_is_right_to_three_units_in_the_last_place(number):
    exact = DIGITS.ln(Decimal(number))
    error = abs(Decimal(float(logarithm(number))) - exact)
    assert error <= 3 * Decimal(math.ulp(float(exact)))


@given(st.floats(-1e3, 1e3) | st.floats(-1e-3, 1e-3))
def test_the_exponential_function_of_a_float_is_that_of_an_array(number):
    with np.errstate(over="ignore"):
        assert float_exponential(number) == exponential(number)


@given(st.floats(1e-300, 1e300) | st.floats(0.9, 1.1))
def test_the_logarithm_of_a_float_is_that_of_an_array(number):
    assert float_logarithm(number) == logarithm(number)


def test_what_is_no_number_stays_none():
    assert math.isnan(float_exponential(math.nan))
    assert math.isnan(float_logarithm(math.nan))


@given(st.floats(0.0, 1.0), st.floats(0.1, 10.0))
def test_a_power_is_right_to_1e_15(base, exponent):
    exact = DIGITS.power(Decimal(base), Decimal(exponent)) if base else Decimal(0)
    assert abs(Decimal(float(power(np.array(base), exponent))) - exact) <= Decimal("1e-15")


@pytest.mark.parametrize("exponent", [0.1, 0.5, 1.0, 1.7, 2.0, 10.0])
def test_a_power_of_nothing_is_nothing_and_of_one_is_one(exponent):
    assert power(np.array([0.0, 1.0]), exponent).tolist() == [0.0, 1.0]


def test_a_square_is_rounded_once():
    fractions = np.random.default_rng(1).uniform(size=1000)
    assert (power(fractions, 2.0) == fractions * fractions).all()


def test_what_no_float_holds_is_zero_or_infinite():
    with np.errstate(over="ignore"):
        assert exponential([-1e15, 0.0, 1e15]).tolist() == [0.0, 1.0, math.inf]


@given(st.floats(-0.5, 0.5))
def test_the_sine_is_right_to_1e_15(turns):
    assert abs(sine_of_turns(turns) - math.sin(2 * math.pi * turns)) <= 1e-15


@given(st.floats(-1e6, 1e6))
def test_the_sine_repeats_with_every_turn(turns):
    part = turns - round(turns)  # exact
    assert abs(sine_of_turns(turns) - math.sin(2 * math.pi * part)) <= 1e-15


@given(st.floats(-740.0, 0.0))
def test_the_decaying_exponential_is_right_to_1e_15(number):
    exact = math.exp(number)
    assert abs(decaying_exponential(number) - exact) <= 1e-15 * exact + 1e-300
