"""What telemetry tells of the loop: rests, heights and lengths of steps, and whether it rests."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bdt_twin.loop_watch import REST, LoopWatch

RATE = 1000.0
GENERATOR = np.random.default_rng(1)


def telemetry(steps, length, busy, swing=2e-3, noise=0.0):
    """Return rows of a loop that swings after each step and rests until the next one."""
    rows = []
    for number, height in enumerate(steps):
        time = np.arange(round(length * RATE)) / RATE
        position = height + np.where(time < busy, swing * np.cos(9.0 * time), 0.0)
        position += noise * GENERATOR.standard_normal(time.size)
        rows.append(np.column_stack([number * length + time, 0.0 * time, position]))
    return np.concatenate(rows)


def watched(rows, patience=8.0, expected=None, lost_motion=0.0, batch=100):
    watch = LoopWatch(patience, 5e-3)
    if expected is not None:
        watch.expect(expected, lost_motion)
    batches = [rows[first : first + batch] for first in range(0, len(rows), batch)]
    told = [(each[-1, 0], watch.take(each)) for each in batches]
    return watch, [(time, text) for time, text in told if text]


@settings(max_examples=20)
@given(st.integers(1, 7000))
def test_steps_are_known_however_telemetry_is_batched(batch):
    rows = telemetry([5e-3, 0.0, 8e-3, 0.0], 5.0, 2.0)
    watch, _ = watched(rows, batch=batch)
    assert list(watch.heights) == pytest.approx([5e-3, 8e-3], rel=0.05)
    assert watch.step_time == pytest.approx(5.0)


def test_noise_is_no_motion():
    rows = telemetry([5e-3, 0.0] * 3, 6.0, 3.0, noise=5e-6)
    watch, told = watched(rows, patience=1.0, expected=3.5)
    assert list(watch.heights) == pytest.approx([5e-3] * 4, rel=0.05)
    assert told == []


def test_a_loop_that_has_made_no_step_tells_nothing():
    watch, _ = watched(telemetry([0.0], 5.0, 0.0))
    assert (list(watch.heights), watch.step_time) == ([], None)


def test_a_nudge_is_no_step():
    rows = telemetry([5e-3, 0.0, 1e-4, 0.0, 5e-3, 0.0], 4.0, 1.0)
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


@pytest.mark.parametrize(("lost_motion", "told"), [(2e-5, True), (2e-4, False)])
def test_what_is_less_than_a_limit_cycle_of_the_gap_is_rest(lost_motion, told):
    rows = telemetry([5e-3] * 4, 10.0, 10.0, swing=2e-4)
    found = watched(rows, expected=3.0, lost_motion=lost_motion)[1]
    assert bool(found) == told


def test_a_swing_below_what_counts_as_a_limit_cycle_is_rest():
    rows = telemetry([5e-3] * 4, 10.0, 10.0, swing=2e-5)
    assert watched(rows, expected=3.0)[1] == []


def test_without_an_expectation_nothing_is_worse():
    assert watched(telemetry([5e-3] * 4, 10.0, 10.0))[1] == []
