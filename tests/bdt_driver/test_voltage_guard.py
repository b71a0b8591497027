"""A motor gets no more voltage, and no faster, than the limits say; nothing begins with a jump."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_driver.driver_settings import DriveLimits
from bdt_driver.voltage_guard import VoltageGuard

PERIOD = 0.002
VOLTAGES = st.floats(-1e3, 1e3)


def engaged(limits=None):
    """Return a guard that commands pass with full weight."""
    guard = VoltageGuard(limits or DriveLimits(), engage_time=0.2)
    for _ in range(200):
        guard.voltage(0.0, PERIOD)
    return guard


def test_a_command_within_the_limits_passes():
    assert engaged().voltage(-7.25, PERIOD) == -7.25


@given(st.lists(VOLTAGES, min_size=1, max_size=50))
def test_no_command_gets_beyond_the_voltage_or_its_rate(commands):
    limits = DriveLimits(voltage=12.0, voltage_rate=500.0)
    guard = VoltageGuard(limits, engage_time=0.2)
    before = 0.0
    for command in commands:
        after = guard.voltage(command, PERIOD)
        assert abs(after) <= limits.voltage
        assert abs(after - before) <= limits.voltage_rate * PERIOD * (1 + 1e-12)
        before = after


@given(VOLTAGES)
def test_the_first_voltage_after_a_rest_is_below_one_percent_of_the_limit(command):
    guard = engaged()
    guard.rest()
    assert guard.applied == 0.0
    assert abs(guard.voltage(command, PERIOD)) <= 0.01 * DriveLimits().voltage


def test_a_constant_command_comes_into_force_along_a_straight_line():
    guard = VoltageGuard(DriveLimits(), engage_time=0.2)
    applied = [guard.voltage(10.0, PERIOD) for _ in range(120)]
    assert applied[:100] == pytest.approx([0.1 * number for number in range(1, 101)])
    assert applied[100:] == [10.0] * 20


def test_what_was_limited_is_counted():
    guard = engaged(DriveLimits(voltage=5.0))
    guard.voltage(5.0, PERIOD)
    assert guard.limited == 0
    guard.voltage(5.1, PERIOD)
    assert guard.limited == 1
