"""The limits of the hardware hold, whatever is commanded."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.limits import HardwareLimits, LimitedDrive


@given(st.floats(), st.floats())
def test_no_voltage_is_beyond_the_limit_and_none_is_applied_beyond_the_travel(voltage, position):
    limits = HardwareLimits(voltage=24.0, position=0.05)
    applied = LimitedDrive(limits).voltage(voltage, position)
    assert abs(applied) <= 24.0
    if not abs(position) <= 0.05 or not math.isfinite(voltage):
        assert applied == 0.0
    elif abs(voltage) <= 24.0:
        assert applied == voltage
    else:
        assert applied == math.copysign(24.0, voltage)


def test_the_motor_gets_voltage_again_when_the_platform_is_back():
    drive = LimitedDrive(HardwareLimits(position=0.01))
    assert drive.voltage(5.0, 0.011) == 0.0
    assert drive.is_stopped
    assert drive.voltage(-5.0, 0.011) == 0.0
    assert drive.voltage(-5.0, 0.009) == -5.0
    assert not drive.is_stopped
    assert (drive.stopped_steps, drive.limited_steps) == (2, 0)


def test_limited_steps_are_counted():
    drive = LimitedDrive(HardwareLimits(voltage=10.0))
    for voltage in (9.0, 10.0, 11.0, -1e300):
        drive.voltage(voltage, 0.0)
    assert drive.limited_steps == 2


@pytest.mark.parametrize("values", [{"voltage": 0.0}, {"position": -1.0}, {"voltage": math.inf}])
def test_limits_that_are_none_are_refused(values):
    with pytest.raises(ValueError, match="must be"):
        HardwareLimits(**values)
