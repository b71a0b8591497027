"""Samples from batches and from single messages."""

import numpy as np
import pytest

from bdt_bags.bag_error import BagError
from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import (
    COMMAND,
    DIAGNOSTICS,
    MEASUREMENT,
    PARAMETER_EVENTS,
    REFERENCE,
    TELEMETRY,
    TRUTH,
)

TIME = np.arange(1000) * 0.01


def test_measurement_and_command_in_place_of_telemetry(small_loop, tmp_path):
    """They are the telemetry at the control rate; the voltage holds for the period that follows."""
    whole = load_recording(small_loop.write(tmp_path / "whole"))
    recording = load_recording(small_loop.without(TELEMETRY).write(tmp_path / "bag"))
    time, voltage, position = recording.telemetry.T
    assert time == pytest.approx(np.arange(100) / 50)
    np.testing.assert_array_equal(position[:-1], recording.truth[:-1, 6])
    later = np.searchsorted(whole.telemetry[:, 0], time + 1e-9)
    np.testing.assert_array_equal(voltage[:-1], whole.telemetry[later[:-1], 1])
    assert recording.batch_rows == 0
    assert "no telemetry: samples are those of measurement and command" in recording.missing


def test_measurement_alone(small_loop, tmp_path):
    messages = small_loop.without(TELEMETRY, COMMAND, TRUTH, REFERENCE, PARAMETER_EVENTS)
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert np.isnan(recording.telemetry[:, 1]).all()
    assert recording.sample_time == pytest.approx(0.02)
    assert recording.missing_samples == 0
    assert len(recording.missing) == 5


def test_telemetry_alone(small_loop, tmp_path):
    dropped = (MEASUREMENT, COMMAND, TRUTH, REFERENCE, PARAMETER_EVENTS, DIAGNOSTICS)
    recording = load_recording(small_loop.without(*dropped).write(tmp_path / "bag"))
    assert recording.telemetry.shape == (1000, 3)
    assert "no command: latency unknown" in recording.missing
    assert recording.missing[-1] == "neither parameter events nor diagnostics: dead zone unknown"


def test_repeated_and_unanswered_measurements(small_loop, tmp_path):
    """A lockstep plant sends a measurement again until it is answered."""
    messages = small_loop.without(TELEMETRY)
    first, last = (
        [item for item in messages.items if item[0] == f"/{topic.name}"][k]
        for topic, k in ((MEASUREMENT, 0), (COMMAND, -1))
    )
    messages.items = [item for item in messages.items if item is not last]
    messages.items.insert(0, first)
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert len(recording.telemetry) == 100
    assert np.flatnonzero(np.isnan(recording.telemetry[:, 1])).tolist() == [99]


def test_messages_of_other_shapes_are_read_one_by_one(small_loop, tmp_path):
    """Another frame, velocities, the other byte order: the same numbers."""
    expected = load_recording(small_loop.without(TELEMETRY).write(tmp_path / "a"))
    messages = small_loop.without(TELEMETRY)
    store, number = messages.store, 0
    for k, (name, type_, received, message) in enumerate(messages.items):
        if name == "/measurement":
            number += 1
            other = store.deserialize_cdr(store.serialize_cdr(message, type_), type_)
            if number % 3 == 1:
                other.header.frame_id = "rig"
            elif number % 3 == 2:
                other.velocity = np.ones(1)
            data = bytes(store.serialize_cdr(other, type_, little_endian=number % 5 > 0))
            messages.items[k] = (name, type_, received, data)
    found = load_recording(messages.write(tmp_path / "b"))
    np.testing.assert_array_equal(found.telemetry, expected.telemetry)
    np.testing.assert_array_equal(found.measurements.stamps, expected.measurements.stamps)


@pytest.mark.parametrize("shift", [0.0, 0.0041])
def test_time_that_begins_anew(signal_messages, tmp_path, shift):
    """A plant that was started again during the recording, with the same stamps or others."""
    first = signal_messages(TIME, np.sin(TIME), [(0.0, 1.0)])
    second = signal_messages(TIME[:500] + shift, np.cos(TIME[:500]), [(0.0, 1.0)])
    first.items.extend((name, type_, t + 20, m) for name, type_, t, m in second.items)
    with pytest.raises(BagError, match="time goes back: holds 2 runs"):
        load_recording(first.write(tmp_path / "bag"))


def test_samples_that_a_sensor_dropped(signal_messages, tmp_path):
    position = np.sin(TIME)
    position[::10] = np.nan
    messages = signal_messages(TIME, position, [(0.0, 1.0)])
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert recording.missing_samples == 100
    assert len(recording.telemetry) == 900
    assert recording.sample_time == pytest.approx(0.01)
    assert "100 of 1000 samples are not finite" in recording.missing
