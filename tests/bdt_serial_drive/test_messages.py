"""Payloads: what goes in comes out to within a unit of the line; nothing else is taken for one."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bdt_serial_drive.frames import LONGEST_PAYLOAD
from bdt_serial_drive.messages import (
    LARGEST_COUNT,
    Identity,
    Samples,
    begin_payload,
    identity_payload,
    read_begin,
    read_identity,
    read_samples,
    read_voltage,
    samples_payload,
    voltage_payload,
)

VOLTAGES = st.floats(-2000.0, 2000.0)
READERS = (read_begin, read_voltage, read_identity, read_samples)


@given(VOLTAGES)
def test_a_voltage_arrives_to_the_microvolt(voltage):
    assert read_voltage(voltage_payload(voltage)) == pytest.approx(voltage, abs=0.51e-6)


@pytest.mark.parametrize("voltage", [math.nan, math.inf, -math.inf, 1e9])
def test_what_is_no_voltage_does_not_get_on_the_line(voltage):
    with pytest.raises(ValueError, match=r"voltage = .* V: must be a number within 2147\.48 V"):
        voltage_payload(voltage)


@given(st.integers(0, 2**32 - 1), st.booleans(), st.integers(1, LARGEST_COUNT), st.data())
def test_samples_arrive_to_a_unit(first, is_silent, count, data):
    rows = data.draw(arrays(np.float64, (count, 2), elements=st.floats(-2.0, 2.0)))
    payload = samples_payload(Samples(first, is_silent, rows))
    assert len(payload) <= LONGEST_PAYLOAD
    found = read_samples(payload)
    assert found[:2] == (first, is_silent)
    assert found.rows == pytest.approx(rows, abs=0.51e-6)
    assert found.rows[:, 1] == pytest.approx(rows[:, 1], abs=0.51e-9)


def test_an_identity_arrives():
    identity = Identity(1, 4999.5, 24.0, 0.1)
    assert read_identity(identity_payload(identity)) == pytest.approx(identity)


def test_the_watchdog_arrives_to_the_millisecond():
    assert read_begin(begin_payload(0.1234)) == pytest.approx(0.123)


@pytest.mark.parametrize("read", READERS)
@given(st.binary(max_size=LONGEST_PAYLOAD))
def test_any_payload_is_read_or_refused(read, payload):
    read(payload)


def test_a_payload_of_another_length_is_none():
    assert [read(b"") for read in READERS] == [None] * len(READERS)
    assert [read(bytes(7)) for read in READERS] == [None] * len(READERS)
