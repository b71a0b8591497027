"""What a recording says, whatever its clocks, topics and gaps."""

import tracemalloc

import numpy as np
import pytest

from bdt_bags.reading.bag_reader import BagError
from bdt_bags.reading.completeness import lost_messages
from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    DEAD_ZONE_JOINT,
    MEASUREMENT,
    REFERENCE,
    TELEMETRY,
    TRUTH,
)

TIME = np.arange(1000) * 0.01


@pytest.fixture
def signal(signal_messages):
    return signal_messages(TIME, np.sin(TIME), [(0.0, 1.0)])


def test_loop(following_bag):
    recording = load_recording(following_bag)
    assert recording.telemetry.shape == (100_000, 3)
    assert recording.truth.shape == (10_000, 7)
    assert recording.sample_time == pytest.approx(2e-4)
    assert recording.duration == pytest.approx(20.0)
    assert recording.real_time_factor == pytest.approx(4.0)
    assert recording.reference.tolist() == [[0, 5e-3], [5, 0], [10, 5e-3], [15, 0]]
    assert recording.reconfigurations == len(recording.dead_zones) - 1 > 50
    assert recording.dead_zones[0].tolist() == [0.0, 0.0]
    assert recording.measurements.stamps == pytest.approx(np.arange(10_000) / 500)
    assert recording.pitch is None
    assert lost_messages(recording).total == 0


def test_namespace(loop_messages, tmp_path):
    messages = loop_messages(duration=4.0, step_time=2.0, namespace="/lab/rig_1", delay=0.2)
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert recording.message_counts["/lab/rig_1/telemetry"] == 40
    assert recording.reconfigurations > 5
    assert len(recording.dead_zones) == recording.reconfigurations + 1


def test_only_what_is_required(signal, tmp_path):
    recording = load_recording(signal.write(tmp_path / "bag"))
    assert recording.truth is None
    assert recording.estimates.shape == recording.dead_zones.shape == (0, 2)
    assert recording.reconfigurations is None
    assert recording.real_time_factor == pytest.approx(4.0)
    assert lost_messages(recording).total == 0


def test_recorded_topics_without_messages(signal, tmp_path):
    """A recorder creates every topic, also those nobody publishes."""
    path = signal.write(tmp_path / "bag", empty=(TRUTH, BACKLASH_ESTIMATE, MEASUREMENT))
    recording = load_recording(path)
    assert recording.truth is None
    assert recording.message_counts["/truth"] == 0
    assert "no truth: error of the estimate unknown" in recording.missing
    unset = load_recording(signal.without(REFERENCE).write(tmp_path / "b", empty=(REFERENCE,)))
    assert unset.reference.shape == (0, 2)
    nothing = signal.without(TELEMETRY).write(tmp_path / "c", empty=(TELEMETRY, MEASUREMENT))
    with pytest.raises(BagError, match="/measurement and /telemetry have no messages"):
        load_recording(nothing)


def test_wall_clock_telemetry(signal_messages, tmp_path):
    start = 1_800_000_000.0
    time = start + 0.25 + TIME
    messages = signal_messages(time, np.sin(TIME), [(start + 0.25, 1.0), (start + 5, 2.0)])
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert recording.time_origin == start
    assert recording.telemetry[0, 0] == pytest.approx(0.25)
    assert recording.reference[:, 0] == pytest.approx([0.25, 5.0])


def test_controller_on_the_wall_clock(signal, tmp_path):
    """Stamps of another clock are replaced by the time of what was received with them."""
    signal.dead_zone(1_800_000_000.0, 1e-5, initial=True, received=0.0)
    signal.dead_zone(1_800_000_001.0, 2e-5, received=5.0)
    dead_zones = load_recording(signal.write(tmp_path / "bag")).dead_zones
    assert dead_zones[:, 1].tolist() == [1e-5, 2e-5]
    assert dead_zones[1, 0] == pytest.approx(5.0, abs=1.0)


def test_reference_without_stamps(signal, tmp_path):
    signal.reference(0.0, 2.0, received=5.0)
    reference = load_recording(signal.write(tmp_path / "bag")).reference
    assert reference[1] == pytest.approx([5.0, 2.0], abs=1.0)


def test_uncertainties_of_those_estimates_that_state_one(signal, tmp_path):
    signal.estimate(1.0, 0.1)
    signal.estimate(2.0, 0.2, 0.01)
    signal.estimate(3.0, 0.3, np.nan)
    recording = load_recording(signal.write(tmp_path / "bag"))
    assert recording.estimates[:, 1].tolist() == [0.1, 0.2, 0.3]
    assert recording.uncertainties[:, 1].tolist() == [0.01]
    assert recording.uncertainties[0, 0] == recording.estimates[1, 0]


def test_requests_of_those_estimates_that_tell_one_in_the_order_of_their_data(signal, tmp_path):
    """An estimator may find the last reversal a little earlier when it knows more."""
    signal.estimate(1.0, 0.1)
    signal.estimate(2.0, 0.2, 0.01, age=0.5, tolerance=4e-5)
    signal.estimate(1.9, 0.3, 0.01, age=1.6, tolerance=5e-5)
    signal.estimate(4.0, 0.4, tolerance=6e-5)
    recording = load_recording(signal.write(tmp_path / "bag"))
    assert recording.estimates[:, 1].tolist() == [0.1, 0.3, 0.2, 0.4]
    assert recording.requests == pytest.approx(
        np.array([[2.5, 4e-5, 2.0, 0.2], [3.5, 5e-5, 1.9, 0.3], [4.0, 6e-5, 4.0, 0.4]])
    )


def test_a_gap_is_held_from_the_newest_sample_behind_it(signal, tmp_path):
    """Whether a dead zone is asked for with it or not; without an age the stamp is that sample."""
    signal.estimate(1.0, 0.1)
    signal.estimate(2.0, 0.2, 0.01, age=0.5, tolerance=4e-5)
    signal.estimate(1.9, 0.3, 0.01, age=1.6)
    signal.estimate(3.0, 0.4, age=np.nan)
    held = load_recording(signal.write(tmp_path / "bag")).held_gaps
    assert held == pytest.approx(np.array([[1.0, 0.1], [2.5, 0.2], [3.5, 0.3]]))


def test_requests_that_are_not_finite_are_left_out(signal, tmp_path):
    signal.estimate(1.0, 0.1, age=0.0, tolerance=np.nan)
    signal.estimate(2.0, 0.2, age=np.inf, tolerance=4e-5)
    signal.estimate(3.0, 0.2, age=0.0, tolerance=4e-5)
    requests = load_recording(signal.write(tmp_path / "bag")).requests
    assert requests.tolist() == [[3.0, 4e-5, 3.0, 0.2]]


def test_the_voltage_offsets_that_the_twin_asked_for_are_read_with_the_newest_sample(
    signal, tmp_path
):
    signal.estimate(1.0, 0.1, age=0.0, tolerance=4e-5)
    signal.estimate(2.0, 0.2, age=0.5, tolerance=4e-5, voltage_offset=-0.02)
    signal.estimate(3.0, 0.2, age=0.0, tolerance=4e-5, voltage_offset=np.nan)
    recording = load_recording(signal.write(tmp_path / "bag"))
    assert recording.voltage_offset_requests.tolist() == [[2.5, -0.02]]
    assert len(recording.requests) == 3


def test_an_estimate_that_tells_a_voltage_offset_without_a_value_is_an_error(signal, tmp_path):
    signal.estimate(1.0, 0.1, tolerance=4e-5, voltage_offset=-0.02)
    signal.items[-1][3].effort = np.empty(0)
    with pytest.raises(BagError, match=r"message 0 of /backlash_estimate: .* voltage_offset once"):
        load_recording(signal.write(tmp_path / "bag"))


def test_an_estimate_that_tells_a_dead_zone_twice_is_an_error(signal, tmp_path):
    signal.estimate(1.0, 0.1, tolerance=4e-5)
    _, _, _, message = signal.items[-1]
    message.name.append(DEAD_ZONE_JOINT)
    message.position = np.append(message.position, 5e-5)
    with pytest.raises(BagError, match=r"message 0 of /backlash_estimate: .* once"):
        load_recording(signal.write(tmp_path / "bag"))


def test_a_dead_zone_diagnosed_after_the_first_change_is_not_the_initial_one(signal, tmp_path):
    signal.dead_zone(2.0, 4e-5)
    signal.diagnosed_dead_zone(3.0, 4e-5)
    recording = load_recording(signal.write(tmp_path / "bag"))
    assert recording.dead_zones.tolist() == [[2.0, 4e-5]]


def test_first_dead_zone_from_diagnostics(signal, tmp_path):
    """Parameter events are volatile: a late recorder has missed the first value."""
    for time, value in ((1.0, 3e-5), (2.0, 3e-5), (7.0, 4e-5)):
        signal.diagnosed_dead_zone(time, value)
    recording = load_recording(signal.write(tmp_path / "a"))
    assert recording.dead_zones[:, 1].tolist() == [3e-5, 4e-5]
    assert recording.reconfigurations is None
    signal.dead_zone(6.0, 4e-5)
    recording = load_recording(signal.write(tmp_path / "b"))
    assert recording.dead_zones[:, 1].tolist() == [3e-5, 4e-5]
    assert recording.reconfigurations == 1


def test_two_controllers(signal, tmp_path):
    for namespace in ("/a", "/b"):
        signal.namespace = namespace
        signal.dead_zone(1.0, 1e-5)
    with pytest.raises(BagError, match="/a/controller and /b/controller both have"):
        load_recording(signal.write(tmp_path / "bag"))


def test_pitch_of_the_bag(signal, tmp_path):
    signal.parameter(0.0, "/plant", "lead_screw.pitch", 2e-4, initial=True)
    assert load_recording(signal.write(tmp_path / "bag")).pitch == 2e-4


def test_two_runs_in_one_bag(signal, signal_messages, tmp_path):
    other = signal_messages(TIME, np.cos(TIME), [(0.0, 1.0)])
    signal.items.extend((name, type_, t + 20, m) for name, type_, t, m in other.items)
    with pytest.raises(BagError, match="time goes back: holds 2 runs, choose one with"):
        load_recording(signal.write(tmp_path / "bag"))


def test_repeated_and_late_batches(signal, tmp_path):
    name, type_, received, message = next(x for x in signal.items if x[0] == "/telemetry")
    signal.items.append((name, type_, received + 3, message))
    recording = load_recording(signal.write(tmp_path / "bag"))
    assert recording.telemetry[:, 0] == pytest.approx(TIME)


def test_samples_that_are_not_finite_are_left_out(signal_messages, tmp_path):
    position = np.sin(TIME)
    position[[3, 4]] = np.nan, 1e200
    messages = signal_messages(TIME, position, [(0.0, 1.0), (2.0, np.nan)])
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert len(recording.telemetry) == 998
    assert len(recording.reference) == 1
    nothing = signal_messages(TIME, position * np.nan, [(0.0, 1.0)])
    with pytest.raises(BagError, match="0 valid samples: must have at least two"):
        load_recording(nothing.write(tmp_path / "b"))


def test_telemetry_is_loaded_by_messages_and_not_by_rows(signal_messages, tmp_path, count_calls):
    """Two minutes at 5000 Hz are 600 000 rows in 1200 messages."""
    calls = []
    for rows in (50, 50, 5000):  # the first time, definitions are compiled
        time = np.arange(20 * rows) / 5000
        messages = signal_messages(time, np.sin(time), [(0.0, 1.0)], batch=rows)
        path = messages.write(tmp_path / f"{len(calls)}")
        calls.append(count_calls(lambda path=path: load_recording(path)))
    assert calls[2] < 1.1 * calls[1]


def test_numbers_stay_in_arrays_while_they_are_loaded(signal_messages, tmp_path):
    time = np.arange(100_000) / 5000
    messages = signal_messages(time, np.sin(time), [(0.0, 1.0)], batch=100_000)
    path = messages.write(tmp_path / "bag")
    tracemalloc.start()
    try:
        recording = load_recording(path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(recording.telemetry[:, 2], np.sin(time))
    # Some copies of a row of 24 bytes. As floats of Python, in a list, it would be 96 more.
    assert peak < 140 * len(time)
