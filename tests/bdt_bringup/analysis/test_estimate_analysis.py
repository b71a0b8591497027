"""Errors and lags with known answers."""

import numpy as np
import pytest

from bdt_bringup.analysis.estimate_analysis import (
    estimate_errors,
    interval_coverage,
    reconfiguration_lags,
    summarize_estimate,
)

PITCH = 2e-4


def truth(times, gaps) -> np.ndarray:
    rows = np.zeros((len(times), 7))
    rows[:, 0], rows[:, 3] = times, gaps
    return rows


def test_estimate_holds_from_its_stamp_on():
    estimates = np.array([[1.0, 0.5], [3.0, 0.7]])
    errors = estimate_errors(truth([0, 1, 2, 3, 4], [0.1] * 5), estimates)
    assert errors[:, 0].tolist() == [1, 2, 3, 4]
    assert errors[:, 1] == pytest.approx([0.4, 0.4, 0.6, 0.6])


def test_rms_and_largest_error():
    estimates = np.array([[0.0, 0.3], [1.0, 0.0]])
    found = summarize_estimate(truth([0, 1], [0.0, 0.4]), estimates, np.empty((0, 2)), PITCH)
    assert found.rms_error_rad == pytest.approx(np.sqrt((0.09 + 0.16) / 2))
    assert found.max_error_rad == pytest.approx(0.4)
    assert found.worst_lag_s is None


def test_nothing_is_known_without_truth_or_estimates():
    estimates, none = np.array([[0.0, 0.3]]), np.empty((0, 2))
    assert summarize_estimate(None, estimates, none, PITCH).rms_error_rad is None
    found = summarize_estimate(truth([0, 1], [0.0, 0.4]), none, none, PITCH)
    assert found.rms_error_rad is None
    assert found.max_error_rad is None


def test_lag_is_known_without_truth():
    estimates, dead_zones = np.array([[1.0, 0.3]]), np.array([[0.0, 0.0], [2.1, PITCH * 0.3]])
    found = summarize_estimate(None, estimates, dead_zones, PITCH)
    assert found.worst_lag_s == pytest.approx(1.1)


def test_lag_of_each_reconfiguration():
    times = 0.1 * np.arange(1, 30)
    estimates = np.stack([times, 0.01 * times], axis=1)
    dead_zones = np.stack([times + 1.1, PITCH * 0.01 * times], axis=1)
    lags = reconfiguration_lags(estimates, dead_zones, PITCH)
    assert lags[:, 0] == pytest.approx(times + 1.1)
    assert lags[:, 1] == pytest.approx(np.full(29, 1.1))


def test_equal_estimates_are_matched_in_order():
    times = np.arange(1.0, 5.0)
    estimates = np.stack([times, np.full(4, 0.2)], axis=1)
    dead_zones = np.stack([times + 1.5, np.full(4, PITCH * 0.2)], axis=1)
    lags = reconfiguration_lags(estimates, dead_zones, PITCH)
    assert lags[:, 1] == pytest.approx(np.full(4, 1.5))


def test_dead_zone_of_an_operator_has_no_lag():
    estimates = np.array([[1.0, 0.3], [2.0, 0.4]])
    dead_zones = np.array([[1.5, 1e-5], [3.5, PITCH * 0.4]])
    assert reconfiguration_lags(estimates, dead_zones, PITCH).tolist() == [[3.5, 1.5]]


def test_negative_estimate_gives_a_dead_zone_of_zero():
    lags = reconfiguration_lags(np.array([[1.0, -0.01]]), np.array([[2.0, 0.0]]), PITCH)
    assert lags.tolist() == [[2.0, 1.0]]


def test_a_normal_error_is_covered_in_95_of_100_cases():
    errors = 0.3 * np.random.default_rng(1).standard_normal(100_000)
    assert interval_coverage(errors, np.full(errors.shape, 0.3)) == pytest.approx(95.0, abs=0.3)


def test_what_is_not_stated_or_not_known_is_not_counted():
    nan, inf = np.nan, np.inf
    errors = np.array([0.0, 1.0, nan, 1.0, 1.0])
    assert interval_coverage(errors, np.array([1.0, 0.1, 1.0, nan, inf])) == 50.0
    assert interval_coverage(errors[2:], np.array([1.0, nan, nan])) is None
