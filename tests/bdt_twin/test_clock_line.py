"""The line through stamps is the clock that made the samples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.clock_line import ClockLine

RATE = 5000.0


def batches(times, cuts):
    return np.split(times, sorted(set(cuts)))


@given(
    st.floats(-5e-3, 5e-3),
    st.floats(0.0, 2e9),
    st.lists(st.integers(1, 2999), max_size=8),
)
def test_even_stamps_of_any_clock_are_left_as_they_are(drift, begin, cuts):
    stamps = begin + np.arange(3000) / (RATE * (1.0 + drift))
    line = ClockLine(RATE)
    times = np.concatenate([line.times(part) for part in batches(stamps, cuts)])
    resolved = 4 * np.spacing(begin + 1.0)
    assert np.abs(times - stamps).max() < 1e-9 + resolved
    assert line.rate == pytest.approx(RATE * (1.0 + drift), rel=1e-6 + 3000.0 * resolved)
    assert line.jitter < 1e-9 + resolved


def test_jitter_averages_out():
    even, generator = np.arange(50_000) / 5003.0, np.random.default_rng(0)
    line = ClockLine(RATE)
    stamps = even + generator.normal(0.0, 1e-4, even.size)
    times = np.concatenate([line.times(part) for part in np.split(stamps, 100)])
    late = (times - even)[5000:]
    assert np.abs(late).max() < 1e-5
    assert line.rate == pytest.approx(5003.0, rel=1e-5)
    assert line.jitter == pytest.approx(1e-4, rel=0.15)


def test_where_samples_were_lost_the_line_begins_anew():
    line, stamps = ClockLine(RATE), np.arange(4000) / RATE
    kept = np.concatenate([stamps[:2000], stamps[2003:]])
    times = np.concatenate([line.times(part) for part in np.split(kept, [500, 1000, 1500, 2000])])
    assert times == pytest.approx(kept, abs=1e-9)
