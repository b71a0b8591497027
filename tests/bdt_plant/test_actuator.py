"""The amplifier in front of the motor."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.actuator import ActuatorParameters, saturated

finite = st.floats(allow_nan=False, allow_infinity=False)


@given(finite, st.floats(1e-3, 1e6))
def test_the_applied_voltage_is_the_nearest_one_within_the_limit(voltage, limit):
    applied = saturated(voltage, limit)
    assert abs(applied) <= limit
    if abs(voltage) <= limit:
        assert applied == voltage
    else:
        assert applied == math.copysign(limit, voltage)


@given(finite)
def test_without_a_limit_every_voltage_passes_with_all_its_bits(voltage):
    applied = saturated(voltage, ActuatorParameters().limit)
    assert (applied, math.copysign(1, applied)) == (voltage, math.copysign(1, voltage))


def test_saturation_is_off_unless_asked_for_and_then_48_volts():
    assert ActuatorParameters().limit == math.inf
    assert ActuatorParameters(saturation=True).limit == 48.0


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("voltage_limit", 0.0),
        ("voltage_limit", -24.0),
        ("voltage_limit", math.nan),
        ("saturation", 1),
    ],
)
def test_a_limit_that_no_amplifier_has_is_refused(field, value):
    with pytest.raises(ValueError, match=rf"^ActuatorParameters\.{field} = .*: must be"):
        ActuatorParameters(**{field: value})
