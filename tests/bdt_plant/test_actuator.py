"""The amplifier in front of the motor."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.actuator import ActuatorParameters, amplified, amplifier_of, saturated

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


@given(finite)
def test_the_ideal_amplifier_passes_every_bit(voltage):
    applied = amplified(voltage, amplifier_of(ActuatorParameters()))
    assert (applied, math.copysign(1, applied)) == (voltage, math.copysign(1, voltage))


@given(st.floats(-24, 24), st.floats(-1, 1), st.floats(0.5, 2), st.sampled_from([0.0, 0.01, 3.0]))
def test_an_imperfect_amplifier_rounds_then_amplifies_then_adds_and_stays_within_its_limit(
    voltage, offset, gain, resolution
):
    amplifier = amplifier_of(
        ActuatorParameters(saturation=True, offset=offset, gain=gain, resolution=resolution)
    )
    applied = amplified(voltage, amplifier)
    unlimited = gain * voltage + offset
    assert abs(applied) <= 48.0
    assert abs(applied - max(-48.0, min(48.0, unlimited))) <= 0.5 * gain * resolution + 1e-12
    if resolution and abs(applied) < 48.0:
        steps = (applied - offset) / gain / resolution
        assert steps == pytest.approx(round(steps), abs=1e-9)


def test_an_offset_makes_a_motor_turn_that_is_commanded_to_rest():
    applied = amplified(0.0, amplifier_of(ActuatorParameters(offset=-0.05)))
    assert applied == -0.05


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
        ("offset", math.nan),
        ("offset", 2e3),
        ("gain", 0.0),
        ("gain", -1.0),
        ("resolution", -0.01),
    ],
)
def test_a_limit_that_no_amplifier_has_is_refused(field, value):
    with pytest.raises(ValueError, match=rf"^ActuatorParameters\.{field} = .*: must be"):
        ActuatorParameters(**{field: value})
