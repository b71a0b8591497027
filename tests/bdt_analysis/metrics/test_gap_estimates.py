"""What was stated about the gap: each of it once, with errors and coverage that are known."""

import numpy as np
import pytest

from bdt_analysis.metrics.gap_estimates import gap_estimates, interval_coverage, live_gap_estimates
from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import BACKLASH_ESTIMATE


def test_the_twin_s_repetitions_count_once_as_well():
    rows = np.array([[1.0, 0.1, 0.01], [1.0, 0.1, 0.02], [1.0, 0.2, 0.02], [3.0, 0.2, 0.02]])
    found = gap_estimates(rows, None)
    assert found.gap.tolist() == [0.1, 0.2, 0.2]
    assert found.uncertainty.tolist() == [0.01, 0.02, 0.02]
    assert np.isnan(found.error).all()


def test_outside_the_truth_there_is_no_error():
    truth = np.zeros((2, 7))
    truth[:, 0] = [1.0, 2.0]
    rows = np.array([[0.5, 0.1, 0.1], [1.5, 0.3, 0.1], [2.5, 0.1, 0.1]])
    np.testing.assert_array_equal(gap_estimates(rows, truth).error, [np.nan, 0.3, np.nan])


def test_live_uncertainties_belong_to_their_estimates(small_loop, tmp_path):
    messages = small_loop.without(BACKLASH_ESTIMATE)
    for time, gap, uncertainty in ((0.5, 0.1, 0.02), (0.5, 0.2, 0.03), (1.0, 0.3, None)):
        messages.estimate(time, gap, uncertainty)
    recording = load_recording(messages.write(tmp_path / "bag"))
    live = live_gap_estimates(recording)
    assert live.gap.tolist() == [0.1, 0.2, 0.3]
    np.testing.assert_array_equal(live.uncertainty, [0.02, 0.03, np.nan])


def test_an_uncertainty_without_a_gap_belongs_to_no_estimate(small_loop, tmp_path):
    messages = small_loop.without(BACKLASH_ESTIMATE)
    for time, gap in ((0.5, np.nan), (1.0, 0.3), (1.5, np.nan)):
        messages.estimate(time, gap, 0.02 * time)
    live = live_gap_estimates(load_recording(messages.write(tmp_path / "bag")))
    assert (live.gap.tolist(), live.uncertainty.tolist()) == ([0.3], [0.02])


def test_a_normal_error_is_covered_in_95_of_100_cases():
    errors = 0.3 * np.random.default_rng(1).standard_normal(100_000)
    assert interval_coverage(errors, np.full(errors.shape, 0.3)) == pytest.approx(95.0, abs=0.3)


def test_what_is_not_stated_or_not_known_is_not_counted():
    nan, inf = np.nan, np.inf
    errors = np.array([0.0, 1.0, nan, 1.0, 1.0])
    assert interval_coverage(errors, np.array([1.0, 0.1, 1.0, nan, inf])) == 50.0
    assert interval_coverage(errors[2:], np.array([1.0, nan, nan])) is None
