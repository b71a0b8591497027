"""The device's side of the protocol, with time as the test has it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_drive_emulator.emulated_device import FAULT_KIND, EmulatedDevice
from bdt_drive_emulator.emulator_settings import EmulatorSettings
from bdt_drive_emulator.line_faults import FAULT_TIME, Fault
from bdt_serial_drive.frames import Frame, FrameReader, encoded
from bdt_serial_drive.messages import (
    Kind,
    begin_payload,
    read_identity,
    read_samples,
    voltage_payload,
)


class Bench:
    """A device, and the computer's end of its line."""

    def __init__(self, mechanism, **settings):
        self.device = EmulatedDevice(mechanism, EmulatorSettings(**settings))
        self.device.advance(0.0)
        self.now = 0.0
        self._reader = FrameReader()

    def send(self, kind, payload=b""):
        return self._frames(self.device.receive(encoded(Frame(kind, 0, payload)), self.now))

    def run(self, duration):
        """Let time pass in steps of 1 ms and return the messages with samples."""
        sent, end = [], self.now + duration
        while self.now < end - 1e-9:
            self.now += 1e-3
            sent += self.device.advance(self.now)
        return [read_samples(frame.payload) for frame in self._frames(sent)]

    def _frames(self, sent):
        return self._reader.feed(b"".join(sent))


@pytest.fixture
def bench(workshop):
    made = Bench(workshop)
    made.send(Kind.BEGIN, begin_payload(0.1))
    return made


def voltages(messages):
    return np.concatenate([message.rows[:, 0] for message in messages])


def positions(messages):
    return np.concatenate([message.rows[:, 1] for message in messages])


def test_it_says_nothing_before_a_computer_begins(workshop):
    assert Bench(workshop).run(0.1) == []


def test_it_tells_who_it_is(workshop):
    (frame,) = Bench(workshop).send(Kind.BEGIN, begin_payload(0.25))
    assert frame.kind == Kind.IDENTITY
    assert read_identity(frame.payload) == pytest.approx((1, 5000.0, 24.0, 0.25))


def test_samples_come_in_a_row_at_the_sampling_rate(bench):
    messages = bench.run(1.0)
    assert sum(len(message.rows) for message in messages) == pytest.approx(5000, abs=5)
    numbers = [message.first for message in messages]
    assert np.all(np.diff(numbers) == 5)


def test_a_clock_that_is_off_makes_more_samples(workshop):
    bench = Bench(workshop, clock_error=0.01)
    bench.send(Kind.BEGIN, begin_payload(0.1))
    assert sum(len(message.rows) for message in bench.run(1.0)) == pytest.approx(5050, abs=5)


def test_a_voltage_is_applied_and_told_and_limited(bench):
    bench.send(Kind.VOLTAGE, voltage_payload(3.0))
    assert voltages(bench.run(0.05)) == pytest.approx(3.0)
    bench.send(Kind.VOLTAGE, voltage_payload(100.0))
    assert voltages(bench.run(0.05)) == pytest.approx(24.0)


def test_the_platform_follows_the_voltage(bench):
    for _ in range(10):
        bench.send(Kind.VOLTAGE, voltage_payload(3.0))
        messages = bench.run(0.05)
    assert positions(messages)[-1] > 0.0005


@pytest.mark.parametrize("kind", [Kind.STOP, Kind.END, Kind.BEGIN])
def test_a_stop_takes_the_voltage_off_and_so_do_end_and_begin(bench, kind):
    bench.send(Kind.VOLTAGE, voltage_payload(3.0))
    bench.run(0.02)
    bench.send(kind, begin_payload(0.1) if kind == Kind.BEGIN else b"")
    if kind == Kind.END:
        assert bench.run(0.02) == []
        bench.send(Kind.BEGIN, begin_payload(0.1))
    assert voltages(bench.run(0.02)) == pytest.approx(0.0)


def test_without_a_voltage_message_the_watchdog_takes_it_off_and_says_so(bench):
    bench.send(Kind.VOLTAGE, voltage_payload(3.0))
    before = bench.run(0.099)
    assert voltages(before) == pytest.approx(3.0)
    assert not any(message.is_silent for message in before)
    after = bench.run(0.05)[3:]
    assert voltages(after) == pytest.approx(0.0)
    assert all(message.is_silent for message in after)
    bench.send(Kind.VOLTAGE, voltage_payload(1.0))
    assert not any(message.is_silent for message in bench.run(0.01))


@given(st.lists(st.binary(max_size=300), max_size=5))
def test_no_bytes_move_it_or_make_it_fail(workshop, received):
    device = EmulatedDevice(workshop, EmulatorSettings())
    device.advance(0.0)
    for number, content in enumerate(received):
        device.receive(content, 0.001 * number)
        assert device.advance(0.001 * number) == []


def test_it_can_be_told_to_be_silent_for_a_while(bench):
    bench.send(FAULT_KIND, b"silent")
    assert bench.run(FAULT_TIME - 0.01) == []
    assert bench.run(0.1)


def test_it_can_be_told_that_its_sensor_is_stuck(bench):
    bench.send(FAULT_KIND, b"stuck")
    assert np.ptp(positions(bench.run(0.1))) == 0.0
    bench.run(FAULT_TIME)
    assert np.ptp(positions(bench.run(0.1))) > 0.0


@pytest.mark.parametrize("fault", [Fault.TORN, Fault.LOST, Fault.GARBLED])
def test_such_a_fault_costs_a_part_of_the_frames(bench, fault):
    bench.send(FAULT_KIND, str(fault).encode())
    numbers = [message.first for message in bench.run(FAULT_TIME)]
    assert 200 < len(numbers) < 299
    assert len(set(numbers)) == len(numbers)


def test_noise_costs_none_of_them(bench):
    bench.send(FAULT_KIND, b"noise")
    assert len(bench.run(FAULT_TIME)) >= 298


def test_doubled_frames_come_twice(bench):
    bench.send(FAULT_KIND, b"doubled")
    numbers = [message.first for message in bench.run(FAULT_TIME)]
    assert 5 < len(numbers) - len(set(numbers)) < 100


def test_a_fault_that_it_does_not_know_is_none(bench):
    bench.send(FAULT_KIND, b"\xff\xfe")
    assert len(bench.run(0.1)) == pytest.approx(100, abs=1)
