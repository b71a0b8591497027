"""Cogging against its formula; its motion is in test_machine.py."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.cogging import CoggingParameters, cogging_current, cogging_of
from bdt_plant.motor import MotorParameters


@given(st.floats(-30, 30), st.floats(1e-4, 1.0), st.integers(1, 100))
def test_the_torque_is_a_sine_with_so_many_periods_in_a_turn(angle, torque, periods):
    cogging = cogging_of(MotorParameters(), CoggingParameters(torque, periods))
    expected = torque * math.sin(periods * angle)
    assert 0.8 * cogging_current(angle, cogging) == pytest.approx(expected, abs=1e-11 * torque)


def test_by_default_there_is_none():
    assert cogging_current(0.1, cogging_of(MotorParameters(), CoggingParameters())) == 0.0


@pytest.mark.parametrize(
    ("field", "value"), [("cogging_torque", -1.0), ("cogging_periods", 0), ("cogging_periods", 2.5)]
)
def test_what_no_motor_does_is_refused(field, value):
    with pytest.raises(ValueError, match=rf"^CoggingParameters\.{field} = .*: must be"):
        CoggingParameters(**{field: value})
