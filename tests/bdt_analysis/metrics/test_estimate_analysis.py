"""Errors of the estimate with known answers."""

from dataclasses import replace

import numpy as np
import pytest

from bdt_analysis.metrics.estimate_analysis import (
    estimate_errors,
    summarize_estimate,
)


def truth(times, gaps) -> np.ndarray:
    rows = np.zeros((len(times), 7))
    rows[:, 0], rows[:, 3] = times, gaps
    return rows


def test_estimate_holds_from_its_stamp_on():
    estimates = np.array([[1.0, 0.5], [3.0, 0.7]])
    errors = estimate_errors(truth([0, 1, 2, 3, 4], [0.1] * 5), estimates)
    assert errors[:, 0].tolist() == [1, 2, 3, 4]
    assert errors[:, 1] == pytest.approx([0.4, 0.4, 0.6, 0.6])


def test_rms_and_largest_error(known_run):
    found = summarize_estimate(known_run([[0.0, 0.3], [1.0, 0.0]], truth=truth([0, 1], [0.0, 0.4])))
    assert found.rms_error_rad == pytest.approx(np.sqrt((0.09 + 0.16) / 2))
    assert found.max_error_rad == pytest.approx(0.4)
    assert found.worst_lag_s is None


def test_nothing_is_known_without_truth_or_estimates(known_run):
    assert summarize_estimate(known_run([[0.0, 0.3]])).rms_error_rad is None
    found = summarize_estimate(known_run(truth=truth([0, 1], [0.0, 0.4])))
    assert found.rms_error_rad is None
    assert found.max_error_rad is None
    assert found.stated_rms_error_rad is None
    assert found.stated_max_error_rad is None
    assert found.max_shortfall_rad is None
    assert found.voltage_offset_v is None


def test_the_voltage_offset_is_the_one_that_was_asked_for_last(known_run):
    asked = np.array([[1.0, -0.05], [2.0, -0.02]])
    run = replace(known_run([[1.0, 0.3]]), voltage_offset_requests=asked)
    assert summarize_estimate(run).voltage_offset_v == -0.02


def test_lag_is_known_without_truth(known_run, pitch):
    found = summarize_estimate(known_run([[1.0, 0.3]], [[0.0, 0.0], [2.1, pitch * 0.3]]))
    assert found.worst_lag_s == pytest.approx(1.1)


def test_an_estimate_that_is_right_when_stated_falls_short_while_it_is_held(known_run):
    """The gap grows by 0.1 rad/s; estimates stated for 1 s and 5 s are known at 2 s and 6 s."""
    times = np.linspace(0.0, 8.0, 801)
    estimates, held = [[1.0, 0.11], [5.0, 0.48]], [[2.0, 0.11], [6.0, 0.48]]
    found = summarize_estimate(
        known_run(estimates, truth=truth(times, 0.1 * times), held_gaps=held)
    )
    assert found.stated_rms_error_rad == pytest.approx(np.sqrt((0.01**2 + 0.02**2) / 2))
    assert found.stated_max_error_rad == pytest.approx(0.02)
    assert found.max_shortfall_rad == pytest.approx(0.599 - 0.11)
    assert found.max_error_rad == pytest.approx(0.499 - 0.11), "in force from the time stated"


def test_the_newest_of_several_estimates_of_one_reversal_is_held(known_run):
    """The later window places the reversal a sample earlier: in force by its time, it is first."""
    gaps = truth([0.0, 1.0, 2.0, 3.0], [0.5] * 4)
    estimates, held = [[0.9, 0.5], [1.0, 0.3]], [[1.0, 0.3], [1.5, 0.5]]
    found = summarize_estimate(known_run(estimates, truth=gaps, held_gaps=held))
    assert found.max_shortfall_rad == pytest.approx(0.2)
    found = summarize_estimate(known_run(estimates, truth=gaps[2:], held_gaps=held))
    assert found.max_shortfall_rad == 0.0


def test_without_ages_an_estimate_is_held_from_its_own_time_on(known_run):
    found = summarize_estimate(
        known_run([[1.0, 0.25]], truth=truth([0.0, 1.0, 2.0], [0.1, 0.2, 0.3]))
    )
    assert found.max_shortfall_rad == pytest.approx(0.05)


def test_an_estimate_that_is_never_short_has_no_shortfall(known_run):
    found = summarize_estimate(known_run([[0.0, 0.5]], truth=truth([0.0, 1.0], [0.1, 0.2])))
    assert found.max_shortfall_rad == 0.0


def test_an_estimate_that_a_hole_may_have_hidden_is_no_error(known_run):
    """The gap grows in the hole from 1 s to 3 s; the next estimate is that at 4 s."""
    gaps = truth([0.0, 1.0, 3.5, 4.0], [0.1, 0.1, 0.9, 0.9])
    estimates = [[0.0, 0.1], [4.0, 0.9]]
    with_hole = summarize_estimate(known_run(estimates, truth=gaps), np.array([[1.5, 3.0]]))
    assert (with_hole.max_error_rad, with_hole.max_shortfall_rad) == (0.0, 0.0)
    assert summarize_estimate(known_run(estimates, truth=gaps)).max_shortfall_rad == (
        pytest.approx(0.8)
    )
