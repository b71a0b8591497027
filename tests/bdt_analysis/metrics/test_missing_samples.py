"""Holes of samples that a sensor dropped."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_analysis.analyze import analyze
from bdt_analysis.metrics.missing_samples import LONGEST_INTERPOLATION, interpolate_missing_samples

SAMPLE_TIME = 0.001
TIME = np.arange(500) * SAMPLE_TIME
ROWS = np.stack([TIME, 3 * TIME - 1, 7 - 2 * TIME], axis=1)


@given(st.sets(st.integers(1, 498)))
def test_straight_lines_come_back(lost):
    """Where no hole is longer than what is bridged."""
    kept = np.delete(ROWS, sorted(lost), axis=0)
    found = interpolate_missing_samples(kept, SAMPLE_TIME)
    if np.diff(kept[:, 0]).max() <= LONGEST_INTERPOLATION:
        assert found == pytest.approx(ROWS, abs=1e-12)
    assert np.isin(kept, found).all()


def test_long_holes_stay_open():
    kept = np.delete(ROWS, [10, *range(100, 130)], axis=0)
    found = interpolate_missing_samples(kept, SAMPLE_TIME)
    assert found == pytest.approx(np.delete(ROWS, range(100, 130), axis=0), abs=1e-12)


def test_whole_telemetry_is_not_copied():
    assert interpolate_missing_samples(ROWS, SAMPLE_TIME) is ROWS


@pytest.mark.parametrize("lost", [0.0, 0.3])
def test_limit_cycle_and_its_end_with_dropped_samples(signal_messages, tmp_path, lost):
    """1.5 Hz at 2 % of the step in the first step, nothing in the second."""
    time = np.arange(20_000) * 1e-3
    position = np.where(time < 10, 1e-3 + 1e-5 * np.sin(3 * np.pi * time), 0.0)
    drop = np.random.default_rng(3).random(time.size) < lost
    messages = signal_messages(time, np.where(drop, np.nan, position), [(0.0, 1e-3), (10.0, 0.0)])
    summary = analyze(messages.write(tmp_path / "bag"))
    assert [step.limit_cycle for step in summary.steps] == [True, False]
    assert summary.steps[0].residual_peak_to_peak_m == pytest.approx(2e-5, rel=1e-3)
    assert summary.missing_samples == drop.sum()
    assert summary.lost_messages == 0


def test_dropped_samples_do_not_shift_the_bias(signal_messages, tmp_path):
    """A sensor that drops every other sample on one side of the oscillation."""
    time = np.arange(10_000) * 1e-3
    swing = np.sin(4 * np.pi * time)
    drop = (swing > 0) & (np.arange(time.size) % 2 == 1)
    position = np.where(drop, np.nan, 1e-3 + 1e-5 * swing)
    summary = analyze(signal_messages(time, position, [(0.0, 1e-3)]).write(tmp_path / "bag"))
    assert summary.steps[0].bias_m == pytest.approx(0.0, abs=1e-9)
