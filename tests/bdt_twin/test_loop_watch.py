"""What telemetry tells of the loop: rests, heights and lengths of steps, and whether it rests."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bdt_twin.loop_watch import REST, LoopWatch

RATE = 100.0


def telemetry(steps, length, busy):
    """Return rows of a loop that moves for some time and rests until the next step."""
    rows = []
    for number, (level, height) in enumerate(zip([0.0, *steps], steps, strict=False)):
        time = np.arange(round(length * RATE)) / RATE
        voltage = np.where(time < busy, np.cos(7.0 * (number * length + time)), 0.0)
        # The sample at which the voltage changes still has the old level.
        position = np.where(time == 0.0, level, height)
        rows.append(np.column_stack([number * length + time, voltage, position]))
    return np.concatenate(rows)


def watched(rows, patience=8.0, expected=None, batch=10):
    watch = LoopWatch(patience)
    if expected is not None:
        watch.expect(expected)
    batches = [rows[first : first + batch] for first in range(0, len(rows), batch)]
    told = [(each[-1, 0], watch.take(each)) for each in batches]
    return watch, [(time, text) for time, text in told if text]


@settings(max_examples=20)
@given(st.integers(1, 700))
def test_steps_are_known_however_telemetry_is_batched(batch):
    rows = telemetry([5e-3, 0.0, 8e-3, 0.0], 5.0, 2.0)
    watch, _ = watched(rows, batch=batch)
    assert list(watch.heights) == pytest.approx([5e-3, 8e-3])
    assert watch.step_time == pytest.approx(5.0)


def test_a_loop_that_has_made_no_step_tells_nothing():
    watch, _ = watched(telemetry([0.0], 5.0, 0.0))
    assert (list(watch.heights), watch.step_time) == ([], None)


def test_a_nudge_is_no_step():
    rows = telemetry([5e-3, 0.0, 1e-5, 0.0, 5e-3, 0.0], 4.0, 1.0)
    watch, _ = watched(rows)
    assert min(watch.heights) > 4e-3


def test_a_loop_that_rests_as_expected_is_left_alone():
    assert watched(telemetry([5e-3, 0.0] * 5, 6.0, 4.0), expected=3.0)[1] == []


def test_a_loop_that_never_rests_is_told_once_patience_is_over():
    rows = telemetry([5e-3] * 4, 10.0, 10.0)
    (at, text), *later = watched(rows, patience=8.0, expected=3.0)[1]
    assert at == pytest.approx(8.0 + 3.0 + REST, abs=0.2)
    assert "has not rested for 12" in text
    assert all(after - at > 11.0 for after, _ in later)


def test_without_an_expectation_nothing_is_worse():
    assert watched(telemetry([5e-3] * 4, 10.0, 10.0))[1] == []
