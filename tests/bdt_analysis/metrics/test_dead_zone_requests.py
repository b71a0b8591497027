"""Which estimate is behind a dead zone, with known answers."""

import numpy as np
import pytest

from bdt_analysis.metrics.dead_zone_requests import (
    dead_zone_requests,
    matching_requests,
    reconfiguration_lags,
)


def test_a_twin_that_does_not_tell_asks_for_eq_9(known_run, pitch):
    requests = dead_zone_requests(known_run([[1.0, 0.3], [2.0, -0.01]], []))
    assert requests.tolist() == [[1.0, pitch * 0.3, 1.0, 0.3], [2.0, 0.0, 2.0, -0.01]]


def test_neither_estimates_nor_requests(known_run):
    assert dead_zone_requests(known_run([], [])).shape == (0, 4)
    assert matching_requests(np.empty((0, 4)), np.array([[1.0, 1e-5]])).tolist() == [-1]


def test_what_the_twin_tells_counts_and_not_eq_9(known_run, pitch):
    told = [[2.0, 9e-5, 1.5, 0.3]]
    dead_zones = [[2.5, pitch * 0.3], [3.1, 9e-5]]
    assert reconfiguration_lags(known_run([[1.5, 0.3]], dead_zones, told)).tolist() == [
        [3.1, pytest.approx(1.1)]
    ]


def test_lag_of_each_reconfiguration(known_run, pitch):
    times = 0.1 * np.arange(1, 30)
    estimates = np.stack([times, 0.01 * times], axis=1)
    dead_zones = np.stack([times + 1.1, pitch * 0.01 * times], axis=1)
    lags = reconfiguration_lags(known_run(estimates, dead_zones))
    assert lags[:, 0] == pytest.approx(times + 1.1)
    assert lags[:, 1] == pytest.approx(np.full(29, 1.1))


def test_lag_runs_from_the_newest_sample_and_not_from_the_time_for_which_the_gap_is_stated(
    known_run,
):
    requests = [[2.0, 7e-5, 1.5, 0.3], [3.0, 8e-5, 1.5, 0.3]]
    lags = reconfiguration_lags(known_run([[1.5, 0.3]] * 2, [[3.1, 7e-5], [4.1, 8e-5]], requests))
    assert lags[:, 1] == pytest.approx([1.1, 1.1])


def test_equal_requests_are_matched_in_order(known_run, pitch):
    times = np.arange(1.0, 5.0)
    estimates = np.stack([times, np.full(4, 0.2)], axis=1)
    dead_zones = np.stack([times + 1.5, np.full(4, pitch * 0.2)], axis=1)
    lags = reconfiguration_lags(known_run(estimates, dead_zones))
    assert lags[:, 1] == pytest.approx(np.full(4, 1.5))


def test_no_request_is_behind_a_dead_zone_that_is_older_than_its_data():
    requests = np.array([[2.0, 7e-5, 0.5, 0.3]])
    assert matching_requests(requests, np.array([[1.9, 7e-5], [2.1, 7e-5]])).tolist() == [-1, 0]


def test_dead_zone_of_an_operator_has_no_lag(known_run, pitch):
    dead_zones = [[1.5, 1e-5], [3.5, pitch * 0.4]]
    lags = reconfiguration_lags(known_run([[1.0, 0.3], [2.0, 0.4]], dead_zones))
    assert lags.tolist() == [[3.5, 1.5]]


def test_negative_estimate_gives_a_dead_zone_of_zero(known_run):
    assert reconfiguration_lags(known_run([[1.0, -0.01]], [[2.0, 0.0]])).tolist() == [[2.0, 1.0]]
