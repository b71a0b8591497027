"""Samples are numbered by time; the window is the same however the telemetry was split."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.estimator import TelemetryRejectedError
from bdt_twin.telemetry_stream import TelemetryStream
from bdt_twin.telemetry_window import TelemetryWindow

RATE = 100.0


def rows_of(begin, end, offset=0.0):
    numbers = np.arange(begin, end)
    return np.column_stack([numbers / RATE + offset, numbers, -numbers]).astype(float)


def test_samples_are_numbered_by_time():
    window = TelemetryWindow(RATE, 100)
    assert window.end is None
    assert window.append(rows_of(250, 300)) == range(250, 300)
    assert window.append(rows_of(300, 310)) == range(300, 310)
    assert window.end == 310
    assert window.time(305) == 3.05


def test_stamps_between_the_multiples_of_the_sample_time_do_not_matter():
    window = TelemetryWindow(RATE, 100)
    for begin in range(0, 100, 10):
        assert window.append(rows_of(begin, begin + 10, offset=0.0049)).start == begin


@given(st.lists(st.integers(1, 399), max_size=6), st.integers(1, 400))
def test_stretches_do_not_depend_on_the_batches(cuts, end):
    window, bounds = TelemetryWindow(RATE, 100), [0, *sorted(set(cuts)), 400]
    for begin, stop in pairwise(bounds):
        window.append(rows_of(begin, stop))
    [stretch] = window.stretches(end, 1, 1)
    first = max(end - 100, 0)
    assert stretch.first == first
    assert stretch.voltage.tolist() == list(range(first, end))
    assert (stretch.position == -stretch.voltage).all()


def test_a_hole_splits_the_window():
    window = TelemetryWindow(RATE, 100)
    for begin, end in [(0, 30), (30, 45), (60, 90)]:
        window.append(rows_of(begin, end))
    found = window.stretches(90, 10, 4)
    assert [(stretch.first, stretch.voltage.size) for stretch in found] == [(1, 44), (62, 28)]
    assert [stretch.first for stretch in window.stretches(90, 31, 4)] == [1]


def test_half_a_sample_missing_is_a_hole():
    window = TelemetryWindow(RATE, 100)
    window.append(rows_of(0, 30))
    window.append(rows_of(30, 60, offset=0.004))
    assert len(window.stretches(61, 1, 1)) == 2


def test_what_no_window_holds_is_forgotten():
    window = TelemetryWindow(RATE, 100)
    for begin in range(0, 300, 50):
        window.append(rows_of(begin, begin + 50))
        window.forget(begin + 50)
    assert window.stretches(300, 1, 1)[0].first == 200
    with pytest.raises(StopIteration):
        window.time(149)


def test_a_stretch_knows_the_voltage_before_it():
    window = TelemetryWindow(1000.0, 100)
    for begin in range(0, 300, 50):
        numbers = np.arange(begin, begin + 50.0)
        window.append(np.column_stack([numbers / 1000.0, numbers, -numbers]))
        window.forget(begin + 50)
    [stretch] = window.stretches(300, 1, 1)
    assert stretch.before.tolist() == list(range(190, 200))


def test_a_stretch_after_a_hole_does_not_know_the_voltage_before_it():
    window = TelemetryWindow(RATE, 100)
    window.append(rows_of(0, 30))
    window.append(rows_of(40, 70))
    assert [stretch.before.size for stretch in window.stretches(70, 1, 1)] == [0, 0]


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        (np.empty((0, 3)), "empty"),
        (np.array([[1.0, np.nan, 0.0]]), "row 0 is not finite"),
        (np.array([[1.0, 0.0, 0.0], [1.02, 0.0, np.inf]]), "row 1 is not finite"),
        (rows_of(100, 120)[::2], "time step of 0.020000 s instead of 0.010000 s at t = 1.020000"),
        (rows_of(100, 120)[::-1], "time step of -0.010000 s"),
    ],
)
def test_a_useless_batch_leaves_a_hole(rows, reason):
    window = TelemetryWindow(RATE, 100)
    window.append(rows_of(0, 100))
    with pytest.raises(TelemetryRejectedError, match=reason):
        window.append(rows)
    window.append(rows_of(120, 130))
    assert [stretch.first for stretch in window.stretches(130, 1, 1)] == [30, 120]


def test_time_that_goes_back_begins_anew():
    window = TelemetryWindow(RATE, 100)
    window.append(rows_of(0, 100))
    with pytest.raises(
        TelemetryRejectedError, match=r"time goes back by 0.490000 s at t = 0.500000"
    ):
        window.append(rows_of(50, 60))
    assert window.end is None
    assert window.append(rows_of(60, 70)) == range(60, 70)


@pytest.mark.parametrize(("late", "is_hole"), [(0.009, False), (-0.009, False), (0.011, True)])
def test_the_grid_goes_on_from_batch_to_batch_to_one_percent_of_a_sample(late, is_hole):
    """For windows a hole, for a stream the end: docs/source/how-to/use-your-own-hardware.md."""
    first, second = rows_of(100, 120), rows_of(120, 140)
    second[:, 0] += late * 0.01
    window, stream = TelemetryWindow(100.0, 1000), TelemetryStream(100.0)
    window.append(first)
    stream.accept(first)
    assert (window.append(second) == range(120, 140)) is not is_hole
    if is_hole:
        with pytest.raises(TelemetryRejectedError):
            stream.accept(second)
    else:
        assert not stream.accept(second)
