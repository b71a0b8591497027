"""Every dead zone, the estimate behind it, and its delay."""

import numpy as np
import pytest

from bdt_analysis.metrics.reconfigurations import (
    reconfiguration_log,
    summarize_reconfigurations,
)
from bdt_bags.reading.recording import load_recording


def test_log(known_run, pitch):
    first, by_hand, second = reconfiguration_log(
        known_run([[1.0, 0.3], [2.0, 0.4]], [[0.0, 0.0], [1.7, 5e-5], [2.9, pitch * 0.4]])
    )
    assert (first.time_s, first.change_m, first.delay_s) == (0.0, None, None)
    assert by_hand.change_m == pytest.approx(5e-5)
    assert by_hand.estimate_rad is None
    assert second.estimate_time_s == 2.0
    assert second.estimate_rad == 0.4
    assert second.delay_s == second.gap_age_s == pytest.approx(0.9)
    assert second.change_m == pytest.approx(pitch * 0.4 - 5e-5)


def test_age_of_the_gap_and_delay_differ_when_the_gap_is_stated_for_an_earlier_time(known_run):
    """Three windows that end with the same reversal: one stamp, three dead zones."""
    estimates = [[1.5, 0.3]] * 3
    requests = [[2.0, 7e-5, 1.5, 0.3], [3.0, 8e-5, 1.5, 0.3], [4.0, 9e-5, 1.5, 0.3]]
    dead_zones = [[0.0, 0.0], [3.1, 7e-5], [4.1, 8e-5], [5.1, 9e-5]]
    log = reconfiguration_log(known_run(estimates, dead_zones, requests))[1:]
    assert [entry.delay_s for entry in log] == pytest.approx([1.1] * 3)
    assert [entry.gap_age_s for entry in log] == pytest.approx([1.6, 2.6, 3.6])
    assert [entry.estimate_time_s for entry in log] == [1.5] * 3
    assert [entry.estimate_rad for entry in log] == [0.3] * 3


def test_no_dead_zone(known_run):
    assert reconfiguration_log(known_run([[1.0, 0.3]], [])) == []


def test_summary_of_a_loop(following_bag):
    """Delay 0.5 s; update periods end 0.02 s before batches."""
    recording = load_recording(following_bag)
    found = summarize_reconfigurations(recording)
    assert found.from_estimates == recording.reconfigurations
    assert found.from_elsewhere == 0
    assert found.estimates_not_applied == len(recording.estimates) - recording.reconfigurations
    assert found.min_s == pytest.approx(0.52, abs=3e-3)
    assert found.median_s == pytest.approx(found.max_s, abs=3e-3)


def test_summary_of_a_twin_that_asks_for_more_than_the_gap(signal_messages, tmp_path):
    time = 0.01 * np.arange(1000)
    messages = signal_messages(time, np.zeros_like(time), [(0.0, 0.005)])
    messages.dead_zone(0.0, 0.0, initial=True)
    for newest, tolerance in ((2.0, 7e-5), (3.0, 8e-5), (4.0, 9e-5)):
        messages.estimate(1.5, 0.3, 0.01, age=newest - 1.5, tolerance=tolerance)
        if newest < 4.0:
            messages.dead_zone(newest + 1.1, tolerance)
    messages.dead_zone(7.0, 1e-5)
    found = summarize_reconfigurations(load_recording(messages.write(tmp_path / "bag")))
    counts = (found.from_estimates, found.from_elsewhere, found.estimates_not_applied)
    assert counts == (2, 1, 1)
    assert (found.min_s, found.max_s) == pytest.approx((1.1, 1.1))
    assert found.max_gap_age_s == pytest.approx(2.6)


def test_dead_zone_set_by_hand(small_loop, tmp_path):
    messages = small_loop.without()
    before = summarize_reconfigurations(load_recording(messages.write(tmp_path / "a")))
    messages.dead_zone(1.99, 3.3e-5)
    after = summarize_reconfigurations(load_recording(messages.write(tmp_path / "b")))
    assert (before.from_elsewhere, after.from_elsewhere) == (0, 1)
    assert before.from_estimates == after.from_estimates
