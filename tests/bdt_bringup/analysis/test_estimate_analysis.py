"""Errors of the estimate with known answers."""

import numpy as np
import pytest

from bdt_bringup.analysis.estimate_analysis import (
    estimate_errors,
    summarize_estimate,
)
from bdt_bringup.run_signals import RunSignals

PITCH = 2e-4


def truth(times, gaps) -> np.ndarray:
    rows = np.zeros((len(times), 7))
    rows[:, 0], rows[:, 3] = times, gaps
    return rows


def run(truth, estimates, dead_zones=()) -> RunSignals:
    return RunSignals(
        telemetry=np.zeros((2, 3)),
        truth=truth,
        reference=np.empty((0, 2)),
        estimates=np.array(estimates).reshape(-1, 2),
        dead_zones=np.array(dead_zones).reshape(-1, 2),
        pitch=PITCH,
    )


def test_estimate_holds_from_its_stamp_on():
    estimates = np.array([[1.0, 0.5], [3.0, 0.7]])
    errors = estimate_errors(truth([0, 1, 2, 3, 4], [0.1] * 5), estimates)
    assert errors[:, 0].tolist() == [1, 2, 3, 4]
    assert errors[:, 1] == pytest.approx([0.4, 0.4, 0.6, 0.6])


def test_rms_and_largest_error():
    found = summarize_estimate(run(truth([0, 1], [0.0, 0.4]), [[0.0, 0.3], [1.0, 0.0]]))
    assert found.rms_error_rad == pytest.approx(np.sqrt((0.09 + 0.16) / 2))
    assert found.max_error_rad == pytest.approx(0.4)
    assert found.worst_lag_s is None


def test_nothing_is_known_without_truth_or_estimates():
    assert summarize_estimate(run(None, [[0.0, 0.3]])).rms_error_rad is None
    found = summarize_estimate(run(truth([0, 1], [0.0, 0.4]), []))
    assert found.rms_error_rad is None
    assert found.max_error_rad is None


def test_lag_is_known_without_truth():
    found = summarize_estimate(run(None, [[1.0, 0.3]], [[0.0, 0.0], [2.1, PITCH * 0.3]]))
    assert found.worst_lag_s == pytest.approx(1.1)
